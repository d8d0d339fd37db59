"""replay over DDS."""

import signal
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from test.nodes.graph import Peer, bag_messages, ended, needs_ros, running, trunk
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording

pytestmark = needs_ros

COUNT = 100


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """Two topics of a second at 100 Hz."""
    stamp = np.arange(COUNT) * 0.01
    waves = np.sin(stamp)[:, None] * [0.1, 0.2]
    series = {
        name: JointSeries(stamp, ("a", "b"), scale * waves, None, None)
        for name, scale in (("gearbox_states", 1.0), ("joint_states", 0.6))
    }
    path = tmp_path_factory.mktemp("replay") / "bag"
    write_recording(path, Recording("test", 1_750_000_000 * 10**9, 1.0, series, None, (), {}))
    return path


def raw(peer: Peer, topic: str) -> list[bytes]:
    from trunk_ros.nodes.ros import JointState

    heard: list[bytes] = []
    peer.node.create_subscription(JointState, topic, heard.append, 1000, raw=True)
    return heard


def test_every_message_comes_again_byte_for_byte(domain, peer, bag):
    gearbox, joints = raw(peer, "/trunk/gearbox_states"), raw(peer, "/elsewhere")
    with running(
        "replay", bag, "--rate", 4, "--remap", "/joint_states:=/elsewhere", domain=domain
    ) as process:
        peer.until(lambda: len(gearbox) == COUNT and len(joints) == COUNT)
        out, _ = process.communicate(timeout=10)
    assert f"{2 * COUNT} messages on 2 topics" in out
    there = bag_messages(bag)
    assert gearbox == there["/trunk/gearbox_states"]
    assert joints == there["/joint_states"]


def test_it_keeps_the_pace_of_the_recording(domain, peer, bag):
    from trunk_ros.nodes.ros import JointState

    heard = []
    peer.node.create_subscription(
        JointState, "/trunk/gearbox_states", lambda _: heard.append(time.monotonic()), 1000
    )
    with running("replay", bag, "--topics", "trunk/gearbox_states", domain=domain):
        peer.until(lambda: len(heard) == COUNT)
    late = np.array(heard) - np.arange(COUNT) * 0.01
    first, last = late[: COUNT // 2].min(), late[COUNT // 2 :].min()  # a busy machine may delay some
    assert last - first == pytest.approx(0.0, abs=0.1)


def test_it_plays_a_part_and_tells_the_time(domain, peer, bag):
    from trunk_ros.nodes.ros import Clock

    gearbox, clock = raw(peer, "/trunk/gearbox_states"), peer.listen(Clock, "/clock")
    part = ("--from-time", "50%", "--until", "0.7", "--topics", "/trunk/gearbox_states", "--clock", "100")
    with running("replay", bag, *part, domain=domain) as process:
        peer.until(lambda: process.poll() is not None)
    assert gearbox == bag_messages(bag)["/trunk/gearbox_states"][50:70]
    assert clock[0].clock.sec == 1_750_000_000
    assert len(clock) == 20


def test_step_by_step_each_line_gives_one_message(domain, peer, bag):
    gearbox = raw(peer, "/trunk/gearbox_states")
    with running("replay", bag, "--step", "--topics", "/trunk/gearbox_states", domain=domain) as process:
        peer.until(lambda: peer.node.count_publishers("/trunk/gearbox_states"))
        peer.spin(1.0)
        assert not gearbox
        process.stdin.write("\n\n\n")
        process.stdin.flush()
        peer.until(lambda: gearbox)
        peer.spin(0.5)
        assert len(gearbox) == 3


def test_steps_asked_for_from_two_sides_at_once_all_count(monkeypatch):
    from trunk_ros.nodes.replay import Replay, read_steps

    node, each = SimpleNamespace(steps=threading.Semaphore(0)), 2000
    monkeypatch.setattr("sys.stdin", ["\n"] * each)
    reader = threading.Thread(target=read_steps, args=[node])
    reader.start()
    for _ in range(each):
        assert Replay.on_step(node, None, SimpleNamespace()).success
    reader.join()
    assert sum(node.steps.acquire(blocking=False) for _ in range(3 * each)) == 2 * each


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["nowhere"], "nowhere"),
        (["{bag}", "--topics", "/none"], "no topic /none"),
        (["{bag}", "--rate", "0"], "above 0"),
        (["{bag}", "--from-time", "9"], "ends at"),
        (["{bag}", "--remap", "x"], "OLD:=NEW"),
    ],
)
def test_what_cannot_be_played_is_refused_in_one_line(bag, arguments, told):
    done = trunk("replay", *(argument.format(bag=bag) for argument in arguments))
    assert done.returncode == 2
    assert told in done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr


def test_paused_it_stands_still_until_the_service_lets_it_go_on(domain, peer, bag):
    from trunk_ros.nodes.ros import SetBool, Trigger

    gearbox = raw(peer, "/trunk/gearbox_states")
    pause = peer.node.create_client(SetBool, "/replay/pause")
    step = peer.node.create_client(Trigger, "/replay/step")
    part = ("--paused", "--rate", 4, "--topics", "/trunk/gearbox_states")
    with running("replay", bag, *part, domain=domain) as process:
        peer.until(lambda: pause.service_is_ready() and step.service_is_ready())
        peer.spin(1.5)
        assert not gearbox
        assert answered(peer, step, Trigger.Request()).success
        peer.until(lambda: gearbox)
        peer.spin(0.5)
        assert len(gearbox) == 1
        assert answered(peer, pause, SetBool.Request(data=False)).success
        peer.until(lambda: len(gearbox) == COUNT)
        peer.until(lambda: process.poll() is not None)


def answered(peer, client, request):
    future = client.call_async(request)
    peer.until(lambda: future.done())
    return future.result()


def test_looped_it_begins_again_until_it_is_ended(domain, peer, bag):
    gearbox = raw(peer, "/trunk/gearbox_states")
    with running(
        "replay", bag, "--loop", "--rate", 20, "--exclude", "joint_states", domain=domain
    ) as process:
        peer.until(lambda: len(gearbox) > 2 * COUNT)
        assert ended(process, signal.SIGINT)[0] == 0
    assert gearbox[COUNT : 2 * COUNT] == gearbox[:COUNT]
