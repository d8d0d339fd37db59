"""recorder on a disk that is too small, or too slow."""

import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from test.nodes.graph import (
    ROOT,
    Received,
    bag_messages,
    ended,
    environment,
    needs_ros,
    size_of,
    values,
    words,
)
from trunk_ros.recording.bag.metadata import read_metadata

pytestmark = needs_ros

MIB = 1 << 20


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 8 MiB; mounting one needs rights that not every machine gives."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", folder], capture_output=True)
    if mounted.returncode:
        pytest.skip("no right to mount a small file system here")
    yield folder
    subprocess.run(["umount", folder], check=True)


@contextmanager
def started(
    code: str, *parameters: str, domain: int, limit: int | None = None
) -> Iterator[subprocess.Popen[str]]:
    """A recorder after some Python of the test; limit: largest file in bytes."""
    main = "import sys; from trunk_ros.__main__ import main; sys.exit(main(sys.argv[1:]))"
    given = [part for parameter in parameters for part in ("-p", parameter)]

    def limited() -> None:
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    process = subprocess.Popen(
        [sys.executable, "-c", f"{code}\n{main}", "recorder", "--ros-args", *given],
        cwd=ROOT,
        env=environment(domain),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=limited,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def publish_noise(peer, over, most: int = 10_000, received=None) -> int:
    """Publish messages of 100 kB that cannot be compressed until it is over; returns how many.

    ``received``: how many the recorder has; then no more are under way than its queues hold.
    """
    from trunk_ros.nodes.graph.ros import String

    out = peer.publisher(String, "noise")
    peer.meets(out, node="recorder")
    for number in range(most):
        if received is not None:
            peer.until(lambda number=number: over() or number - received("/noise") < 20)
        if over():
            return number
        out.publish(String(data=f"{number:06d}" + os.urandom(50_000).hex()))
        peer.spin_once()
    return most


def assert_whole(path: Path) -> int:
    """Every message up to the last is there, and the metadata says how many; returns that number."""
    kept = [int(raw[8:14]) for raw in bag_messages(path)["/noise"]]
    assert kept == list(range(len(kept)))
    assert read_metadata(path).messages["/noise"] == len(kept)
    loss = json.loads(read_metadata(path).custom["trunk_ros.loss"])["/noise"]
    assert loss["received"] - loss["dropped"] == len(kept)
    return len(kept)


def assert_ended(process) -> str:
    """It has ended with one line on the standard error."""
    _, error = process.communicate(timeout=60)
    assert process.returncode == 2
    assert len(error.splitlines()) == 1, error
    return error


def test_a_full_disk_ends_the_recording_with_what_it_has(domain, peer, small_disk):
    received = Received(peer)
    with started("", f"output:={small_disk / 'bag'}", "supervised:=true", domain=domain) as process:
        publish_noise(peer, lambda: process.poll() is not None, received=received)
        assert "is full: the recording was ended" in assert_ended(process)
    assert assert_whole(small_disk / "bag") > 20


def test_a_disk_that_others_fill_at_once_leaves_a_whole_bag(domain, peer, small_disk):
    received = Received(peer)
    given = (f"output:={small_disk / 'bag'}", "compression:=none", "supervised:=true")
    with started("", *given, domain=domain) as process:

        def filled() -> bool:
            files = list(small_disk.glob("bag/*.mcap"))
            if files and size_of(files[0]) > 2 * MIB:
                room = os.statvfs(small_disk)
                with suppress(OSError), (small_disk / "others").open("ab", buffering=0) as stream:
                    stream.write(bytes(room.f_bavail * room.f_frsize))  # the recorder may be faster
            return process.poll() is not None

        publish_noise(peer, filled, received=received)
        assert "bag" in assert_ended(process)
    assert assert_whole(small_disk / "bag") > 5


def test_a_quota_that_is_reached_leaves_a_whole_bag(domain, peer, tmp_path):
    """A limit on the size of files stands for the quota."""
    received = Received(peer)
    given = (f"output:={tmp_path / 'bag'}", "supervised:=true")
    with started("", *given, domain=domain, limit=3 * MIB) as process:
        publish_noise(peer, lambda: process.poll() is not None, received=received)
        assert "cannot be written" in assert_ended(process)
    assert assert_whole(tmp_path / "bag") > 5


STANDING = """
import os, time
from trunk_ros.recording.mcap.write import ChunkWriter
append = ChunkWriter._append

def wait_and_append(self, data):
    while os.path.exists({stands!r}):
        time.sleep(0.01)
    return append(self, data)

ChunkWriter._append = wait_and_append
"""


def test_a_slow_disk_is_buffered_up_to_a_bound_and_then_counted_as_loss(domain, peer, tmp_path):
    """A disk that stands still until the recorder has said so, whatever the speed of this machine."""
    from trunk_ros.nodes.graph.ros import DiagnosticArray

    said = peer.listen(DiagnosticArray, "/diagnostics")
    path, stands = tmp_path / "bag", tmp_path / "stands"
    code = STANDING.format(stands=str(stands))
    given = (f"output:={path}", "buffer_size:=1.0", "topics:=['/noise']")

    def counted() -> int:
        shown = values(said, "recorder")
        return int(shown["messages"]) + int(shown["lost"])

    with started(code, *given, domain=domain) as process:
        peer.until(lambda: words(said, "recorder"))
        stands.touch()
        sent = publish_noise(peer, lambda: "the disk is too slow" in words(said, "recorder"))
        stands.unlink()
        peer.until(lambda: counted() == sent)
        status, out, _ = ended(process, signal.SIGINT)
    assert status == 0
    loss = json.loads(read_metadata(path).custom["trunk_ros.loss"])["/noise"]
    kept = len(bag_messages(path)["/noise"])
    assert loss["received"] + loss["lost"] == sent
    assert loss["received"] - loss["dropped"] == kept >= 10  # what the buffer holds at least
    assert loss["dropped"] > 0
    assert f"{loss['dropped']} not written" in out
