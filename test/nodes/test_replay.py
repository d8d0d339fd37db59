"""replay over DDS."""

import signal
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from test.nodes.graph import PATIENCE, Peer, bag_messages, ended, needs_ros, running
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


PATIENT = ("--wait", 60)  # s until the test's ends are found, on the slowest machine


def raw(peer: Peer, topic: str) -> list[bytes]:
    from trunk_ros.nodes.graph.ros import JointState

    heard: list[bytes] = []
    peer.node.create_subscription(JointState, topic, heard.append, 1000, raw=True)
    return heard


def test_every_message_comes_again_byte_for_byte(domain, peer, bag):
    gearbox, joints = raw(peer, "/trunk/gearbox_states"), raw(peer, "/elsewhere")
    with running(
        "replay", bag, *PATIENT, "--rate", 4, "--remap", "/joint_states:=/elsewhere", domain=domain
    ) as process:
        peer.until(lambda: len(gearbox) == COUNT and len(joints) == COUNT)
        out, _ = process.communicate(timeout=PATIENCE)
    assert f"{2 * COUNT} messages on 2 topics" in out
    there = bag_messages(bag)
    assert gearbox == there["/trunk/gearbox_states"]
    assert joints == there["/joint_states"]


@pytest.mark.parametrize("rate", [0.5, 1.0, 4.0])
def test_it_keeps_the_pace_of_the_recording_and_makes_up_for_delays(monkeypatch, rate):
    from trunk_ros.nodes import replay

    wall, sent = SimpleNamespace(now=100.0), []

    def spin_once(timeout_sec):
        wall.now += timeout_sec if timeout_sec != 0 else 0.03  # serving a callback takes a while

    def publish(topic, data, at):
        sent.append((at, wall.now))
        node.count += 1

    node = SimpleNamespace(given=SimpleNamespace(rate=rate), paused=False, count=0, publish=publish)
    monkeypatch.setattr(replay, "time", SimpleNamespace(monotonic=lambda: wall.now))
    player = replay.Player(node, SimpleNamespace(spin_once=spin_once), SimpleNamespace(asked=False))
    player.play((number * 10**7, "/topic", b"") for number in range(COUNT))
    due, at = np.array(sent).T
    late = (at - 100.0) - due * 1e-9 / rate
    assert len(sent) == COUNT
    assert late.min() > -1e-6
    assert 0.01 < late.max() < 0.04
    assert late[-1] < 1e-6


def test_it_is_not_faster_than_the_recording(domain, peer, bag):
    from trunk_ros.nodes.graph.ros import JointState

    heard = []
    peer.node.create_subscription(
        JointState, "/trunk/gearbox_states", lambda _: heard.append(time.monotonic()), 1000
    )
    part = (*PATIENT, "--rate", 0.25, "--topics", "trunk/gearbox_states")
    begun = time.monotonic()
    with running("replay", bag, *part, domain=domain):
        peer.until(lambda: len(heard) == COUNT)
    assert (
        heard[-1] - begun > 3.9
    )  # of 4 s, and the start: however late the first comes, the last is not early


def test_it_plays_a_part_and_tells_the_time(domain, peer, bag):
    from trunk_ros.nodes.graph.ros import Clock

    gearbox, clock = raw(peer, "/trunk/gearbox_states"), peer.listen(Clock, "/clock")
    part = (
        "--from-time",
        "50%",
        "--until",
        "0.7",
        "--topics",
        "/trunk/gearbox_states",
        "--clock",
        "100",
        *PATIENT,
    )
    with running("replay", bag, *part, domain=domain) as process:
        peer.until(lambda: len(gearbox) >= 20 and len(clock) >= 20)
        peer.until(lambda: process.poll() is not None)
    assert gearbox == bag_messages(bag)["/trunk/gearbox_states"][50:70]
    assert clock[0].clock.sec == 1_750_000_000
    assert len(clock) == 20


def test_step_by_step_each_line_gives_one_message(domain, peer, bag):
    from trunk_ros.nodes.graph.ros import DiagnosticArray

    gearbox, said = raw(peer, "/trunk/gearbox_states"), peer.listen(DiagnosticArray, "diagnostics")
    with running(
        "replay", bag, "--step", *PATIENT, "--topics", "/trunk/gearbox_states", domain=domain
    ) as process:
        peer.more(said, 3)  # seconds of its own
        assert not gearbox
        process.stdin.write("\n\n\n")
        process.stdin.flush()
        peer.until(lambda: gearbox)
        peer.more(said, 2)
        assert "3 messages on 1 topics" in ended(process, signal.SIGINT)[1]
    assert gearbox == bag_messages(bag)["/trunk/gearbox_states"][:3]


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
def test_what_cannot_be_played_is_refused_in_one_line(command, bag, arguments, told):
    done = command("replay", *(argument.format(bag=bag) for argument in arguments))
    assert done.returncode == 2
    assert told in done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr


def test_paused_it_stands_still_until_the_service_lets_it_go_on(domain, peer, bag):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, SetBool, Trigger

    gearbox, said = raw(peer, "/trunk/gearbox_states"), peer.listen(DiagnosticArray, "diagnostics")
    pause = peer.node.create_client(SetBool, "/replay/pause")
    step = peer.node.create_client(Trigger, "/replay/step")
    part = ("--paused", "--rate", 4, "--topics", "/trunk/gearbox_states")
    with running("replay", bag, *part, domain=domain) as process:
        peer.more(said, 3)  # seconds of its own
        assert not gearbox
        assert peer.call(step, Trigger.Request()).success
        peer.until(lambda: gearbox)
        peer.more(said, 2)
        assert len(gearbox) == 1
        assert peer.call(pause, SetBool.Request(data=False)).success
        peer.until(lambda: len(gearbox) == COUNT)
        peer.until(lambda: process.poll() is not None)


def test_looped_it_begins_again_until_it_is_ended(domain, peer, bag):
    gearbox = raw(peer, "/trunk/gearbox_states")
    with running("replay", bag, "--loop", "--rate", 4, "--exclude", "joint_states", domain=domain) as process:
        peer.until(lambda: len(gearbox) > 2 * COUNT)
        assert ended(process, signal.SIGINT)[0] == 0
    assert gearbox[COUNT : 2 * COUNT] == gearbox[:COUNT]


def test_the_model_of_a_comparison_has_the_short_form_that_it_has_in_every_command():
    from trunk_ros.nodes.bags.replay_arguments import parser

    assert (
        parser().parse_args(["bag", "--through", "wire_elasticity", "-m", "mine.yaml"]).model == "mine.yaml"
    )
