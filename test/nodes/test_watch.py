"""watch over DDS: a change is said, recorded with the minutes around it, and diagnosed."""

import signal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from test.diagnosis.arms import on, recorded
from test.nodes.graph import JOINTS, PATIENCE, Received, ended, needs_ros, running
from trunk_ros.recording.read import read_recording

pytestmark = [needs_ros, pytest.mark.timeout(600)]

TOPICS = {
    "setpoints": "trunk/setpoints",
    "gearbox_states": "trunk/gearbox_states",
    "joint_states": "joint_states",
}
BATCH = 10  # samples that may be on their way


def publish_all(peer, publishers, clock, recording, start):
    """Publish a recording from ``start`` ns of simulated time on, no faster than the node takes it."""
    from rosgraph_msgs.msg import Clock

    from trunk_ros.nodes.graph.messages import joint_state, time_message

    stamps = start + np.rint(recording.series["joint_states"].stamp * 1e9).astype(int)
    for k, ns in enumerate(stamps.tolist()):
        clock.publish(Clock(clock=time_message(ns)))
        for key, publisher in publishers.items():
            publisher.publish(joint_state(ns, JOINTS, recording.series[key].position[k]))
        if k % BATCH == BATCH - 1:
            yield k + 1


def test_topics_without_a_publisher_are_said_once(domain, peer):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    publisher = peer.publisher(JointState, "joint_states")
    heard = peer.listen(DiagnosticArray, "diagnostics")
    alone = "/trunk/setpoints, /trunk/gearbox_states"

    def told():
        values = {
            item.value for each in heard for item in each.status[0].values if item.key == "no publisher"
        }
        return alone in values

    with running("watch", "--ros-args", "-p", "timeout:=0.5", domain=domain) as watch:
        peer.meets(publisher, node="watch")
        peer.until(told)
        _, _, said = ended(watch, signal.SIGINT)
    lines = [line for line in said.splitlines() if "no publisher of" in line]
    assert f"no publisher of {alone}: watched" in lines[-1]
    assert len(lines) <= 2  # before the publisher was met


def test_stamps_that_jump_back_are_said_with_their_topic():
    from trunk_ros.nodes.watch import Watch

    said, anew = [], []
    node = SimpleNamespace(
        origin=-1,
        newest=-1,
        looked=-1,
        health=SimpleNamespace(note=said.append),
        monitor=SimpleNamespace(restart=lambda: anew.append(1)),
    )
    for seconds in (100.0, 100.5, 99.8, 101.0, 50.0, 50.1):  # a late message is no jump
        Watch.seconds(node, "joint_states", round(seconds * 1e9))
    assert said == ["joint_states: the stamps jumped back"]
    assert len(anew) == 1


def test_findings_are_logged_in_one_line():
    from trunk_ros.nodes.watch import Watch

    logged, published = [], []
    value = {"value": 0.0040025, "std": 4.7e-06, "unit": "rad"}
    found = {
        "stage": "wire", "joints": ["shoulder"], "effect": "backlash", "regime": "reversal",
        "confidence": 0.9,
        "parameters": {"shoulder": {"half_width": value}}, "statement": "shoulder: ...",
    }  # fmt: skip
    other = {**found, "joints": ["elbow"], "effect": "unknown", "parameters": {}}
    node = SimpleNamespace(
        log=lambda level, text: logged.append(text), now=lambda: 0, say=lambda *words: published.append(words)
    )
    change = SimpleNamespace(stage="wire", joint="shoulder")
    look = SimpleNamespace(bag="bag", output=Path("seen"), result=lambda: ([found, other], ""))
    Watch.tell_findings(node, look, change)
    assert len(published) == 2
    assert logged == [
        "backlash (90%): shoulder half_width 0.0040025 ± 4.7e-06 rad; unknown (90%): elbow; seen/report.html"
    ]
    look.result = lambda: ([], "verdict: no mismatch")
    Watch.tell_findings(node, look, change)
    assert logged[1:] == ["wire, shoulder: no finding (verdict: no mismatch)"]


def test_a_wider_dead_band_is_said_recorded_and_diagnosed(domain, peer, tmp_path):
    from rosgraph_msgs.msg import Clock

    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    publishers = {key: peer.publisher(JointState, topic) for key, topic in TOPICS.items()}
    clock = peer.publisher(Clock, "clock")
    changes = peer.listen(DiagnosticArray, "trunk/changes")
    received = Received(peer)
    options = {
        "use_sim_time": "true",
        "supervised": "true",
        "after": "20.0",
        "output": str(tmp_path / "seen"),
    }
    arguments = [f"{name}:={value}" for name, value in options.items()]
    arguments = [part for argument in arguments for part in ("-p", argument)]
    with running("watch", "--ros-args", *arguments, domain=domain):
        peer.meets(*publishers.values(), clock, node="watch")
        sent, begun = 0, 1_750_000_000 * 10**9
        wider = {"backlash": {"half_width": on(2, 1e-3)}}
        for recording, at in ((recorded({}, 40.0, 1), 0), (recorded(wider, 35.0, 2), 40)):
            for count in publish_all(peer, publishers, clock, recording, begun + at * 10**9):
                peer.until(lambda count=sent + count: received("/joint_states") >= count)
            sent += len(recording.series["joint_states"].stamp)
        peer.until(lambda: len(changes) >= 1)
        first = changes[0].status[0]
        values = {item.key: item.value for item in first.values}
        assert first.name == "wire/joint_2"
        assert (values["kind"], values["regime"], values["or"]) == ("change", "reversal", "")
        assert float(values["size"]) == pytest.approx(-1e-3, rel=0.1)
        assert 0 <= float(values["since"]) - begun / 1e9 - 40 < 10

        def kinds():
            return [{item.key: item.value for item in each.status[0].values} for each in changes]

        seconds = iter(range(75, 10_000))

        def tick():
            clock.publish(clock_at(begun + next(seconds) * 10**9))

        # the diagnosis yields to all other work, of which a test run has a lot
        peer.answered(tick, lambda: any(each["kind"] == "finding" for each in kinds()), 4 * PATIENCE)
    found = next(each for each in kinds() if each["kind"] == "finding")
    assert (found["effect"], found["joints"]) == ("backlash", "joint_2")
    bag = read_recording(found["bag"])
    assert bag.duration > 50.0
    assert {"setpoints", "gearbox_states", "joint_states"} <= set(bag.series)


def clock_at(ns):
    from rosgraph_msgs.msg import Clock

    from trunk_ros.nodes.graph.messages import time_message

    return Clock(clock=time_message(ns))
