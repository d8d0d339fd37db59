"""Text out of serialised std_msgs/String."""

import struct

from trunk_ros.recording.messages.block import Block

HEADER = 4  # bytes of CDR before the first field


def last_text(block: Block) -> str:
    """The text of the last message; "" where there is none that can be read."""
    if not len(block.start):
        return ""
    begin, size = int(block.start[-1]), int(block.size[-1])
    data = block.data[begin : begin + size].tobytes()
    order = "<"
    if block.encoding == "cdr":
        order, data = "<" if data[1:2] == b"\x01" else ">", data[HEADER:]
    if len(data) < HEADER:
        return ""
    length = struct.unpack_from(order + "I", data)[0]
    return data[HEADER : HEADER + length].rstrip(b"\0").decode(errors="replace")
