"""Messages in bulk: thousands of serialised JointState or PoseStamped become arrays without a loop."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from trunk_ros.recording.messages.block import Block, Bytes, Whole
from trunk_ros.recording.messages.layout import Field, Layout
from trunk_ros.recording.recording import Floats

_MOST_LAYOUTS = 64  # that are kept to be tried
_MOST_KINDS = 10_000  # of messages in a topic: with more, what is in it was never written by a publisher
_SHORTEST = 28  # bytes of a message with a header and a joint


@dataclass(frozen=True)
class Piece:
    """Messages with the same joints. stamp_ns, log_ns, place in the file: (n,); the rest (n, joints)."""

    joints: tuple[str, ...]
    stamp_ns: Whole
    log_ns: Whole
    place: Whole
    position: Floats | None
    velocity: Floats | None
    effort: Floats | None

    def rows(self, keep: npt.NDArray[np.bool_]) -> "Piece":
        """The messages chosen by `keep` (n,)."""
        position, velocity, effort = (
            None if values is None else values[keep] for values in (self.position, self.velocity, self.effort)
        )
        times = self.stamp_ns[keep], self.log_ns[keep], self.place[keep]
        return Piece(self.joints, *times, position, velocity, effort)


@dataclass
class Decoder:
    """Decodes the blocks of one topic with the layouts that `layout_of` finds in its messages."""

    layout_of: Callable[[bytes, str], Layout]
    layouts: list[Layout] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    messages: int = 0
    unreadable: int = 0
    blank: int = 0
    kinds: int = 0

    def add(self, block: Block) -> None:
        """Decode a block; messages that are of another type are counted and left out."""
        place = self.messages + np.arange(len(block.start), dtype=np.int64)
        self.messages += len(place)
        left = np.asarray(block.size >= _SHORTEST)
        self.unreadable += int((~left).sum())
        for tried, layout in enumerate(self._layouts(block, left)):
            rows = np.flatnonzero(left & (block.size >= layout.end))
            if tried > 2 * _MOST_LAYOUTS:  # no two messages are alike: stop comparing each with all
                rows = rows[:1]
            if not len(rows):
                continue
            content = gather(block.data, block.start[rows], layout.end)
            same = (content[:, layout.fixed] == layout.expected).all(axis=1)
            rows, content = (rows, content) if same.all() else (rows[same], content[same])
            left[rows] = False
            if len(rows):
                self.pieces.append(_piece(layout, content, block.log_ns[rows], place[rows]))

    def _layouts(self, block: Block, left: npt.NDArray[np.bool_]) -> Iterator[Layout]:
        """The known layouts, then new ones for as long as there are messages that none fits."""
        yield from list(self.layouts)
        while left.any():
            if self.kinds >= _MOST_KINDS:
                self.unreadable += int(left.sum())
                return
            first = int(left.argmax())
            begin = int(block.start[first])
            try:
                layout = self.layout_of(
                    block.data[begin : begin + int(block.size[first])].tobytes(), block.encoding
                )
            except ValueError:
                left[first] = False
                self.unreadable += 1
                continue
            self.kinds += 1
            self.layouts = [*self.layouts[-_MOST_LAYOUTS:], layout]
            yield layout


def gather(data: Bytes, start: Whole, width: int) -> Bytes:
    """(n, width) bytes of `data` from each start on."""
    rows: Bytes = np.lib.stride_tricks.sliding_window_view(data, width)[start]
    return rows


def stamps(content: Bytes, start: int, order: str) -> Whole:
    """(n,) ns of the seconds and nanoseconds that lie at byte `start` of each row."""
    parts = np.ascontiguousarray(content[:, start : start + 8])
    seconds = parts.view(order + "i4")[:, 0].astype(np.int64)
    return seconds * 10**9 + parts.view(order + "u4")[:, 1].astype(np.int64)


def numbers(content: Bytes, where: Field, order: str) -> Floats | None:
    """(n, count) float64 of a field, None where it is empty."""
    if not where.count:
        return None
    cut = np.ascontiguousarray(content[:, where.start : where.start + 8 * where.count])
    return cut.view(order + "f8").astype(np.float64)


def _piece(layout: Layout, content: Bytes, log_ns: Whole, place: Whole) -> Piece:
    position, velocity, effort = (
        numbers(content, each, layout.order) for each in (layout.position, layout.velocity, layout.effort)
    )
    stamp_ns = stamps(content, layout.stamp, layout.order)
    return Piece(layout.joints, stamp_ns, log_ns, place, position, velocity, effort)
