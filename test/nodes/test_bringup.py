"""The whole graph over DDS."""

import json
import os
import signal
import subprocess
import time
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from test.nodes.graph import JOINTS, bag_messages, ended, needs_ros, running, size_of, trunk
from trunk_ros.model import load_model, save_model
from trunk_ros.recording.bag.metadata import read_metadata
from trunk_ros.recording.read import read_recording

pytestmark = needs_ros

PER_STEP = (
    "/clock", "/joint_states", "/trunk/gearbox_states", "/trunk/reference",
    "/trunk/setpoints", "/trunk/tip_pose", "/trunk/wire_states",
)  # fmt: skip
SECONDS, RATE = 3, 100


def simulated(path, *arguments, seconds=SECONDS):
    done = trunk("bringup", "--output", path, "--seconds", seconds, "--sim-time", *arguments)
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("simulated") / "run"
    return path, simulated(path)


def test_simulated_time_records_every_step_of_every_topic(bag):
    path, done = bag
    messages = bag_messages(path)
    for topic in PER_STEP:
        assert 0 <= SECONDS * RATE - len(set(messages[topic])) <= 1, topic
    assert len(messages["/trunk/joint_trajectory"]) == len(messages["/robot_description"]) == 1
    assert len(messages["/diagnostics"]) >= 4 * (SECONDS - 1)
    assert "lost: 0" in done.stdout
    assert f"{path}: " in done.stdout


def test_a_run_in_a_namespace_is_read_with_it(tmp_path):
    """As the report prints both."""
    simulated(tmp_path / "run", "--ros-args", "-r", "__ns:=/left", seconds=1)
    topics = set(bag_messages(tmp_path / "run")) - {"/clock", "/tf", "/tf_static"}
    assert all(topic.startswith("/left/") for topic in topics), topics
    series = read_recording(tmp_path / "run", namespace="/left").series
    assert {"setpoints", "gearbox_states", "joint_states"} <= series.keys()


def test_the_bag_says_what_made_it_and_what_was_lost(bag):
    custom = read_metadata(bag[0]).custom
    losses = json.loads(custom["trunk_ros.loss"])
    assert all(each["lost"] == each["dropped"] == 0 for each in losses.values())
    assert losses["/joint_states"]["expected"] == SECONDS * RATE
    made = json.loads(custom["trunk_ros.manifest"])
    assert made["models"]["compensator"] == load_model("trunk").hash()
    assert made["command"].startswith("bringup --output")


def test_the_recording_is_one_that_the_diagnosis_reads(bag):
    recording = read_recording(bag[0])
    assert set(recording.series) == {
        "reference",
        "setpoints",
        "gearbox_states",
        "joint_states",
        "wire_states",
    }
    assert recording.joints == tuple(JOINTS)
    assert not recording.notes
    np.testing.assert_allclose(np.diff(recording.series["joint_states"].stamp), 0.01, atol=1e-9)
    assert np.ptp(recording.series["joint_states"].position, axis=0).min() > 0.05


def test_runs_of_one_and_of_several_processes_have_identical_payloads_on_every_topic(bag, tmp_path):
    simulated(tmp_path / "again", "--processes")
    first, second = bag_messages(bag[0]), bag_messages(tmp_path / "again")
    topics = [topic for topic in first if not topic.endswith("/transition_event")]  # of the wall's clock
    assert set(PER_STEP) | {"/diagnostics", "/robot_description"} <= set(topics)
    for topic in topics:
        assert payloads(topic, first) == payloads(topic, second), topic


def payloads(topic, bag):
    """What the messages of a topic say, without the padding behind text, which nobody sets.

    Nodes that share a topic take turns in any order.
    """
    from trunk_ros.nodes.graph.ros import DiagnosticArray, String, deserialize_message

    kind = {"/diagnostics": DiagnosticArray, "/robot_description": String}.get(topic)
    if topic == "/clock":
        return list(dict.fromkeys(bag[topic]))  # said again where a step takes long
    if kind is None:
        return bag[topic]
    return sorted(str(deserialize_message(message, kind)) for message in bag[topic])


def test_real_time_in_several_processes_loses_nothing(tmp_path):
    done = trunk("bringup", "--output", tmp_path / "run", "--seconds", 3, "--processes")
    assert done.returncode == 0, done.stderr
    assert "lost: 0" in done.stdout
    series = read_recording(tmp_path / "run").series
    for name in ("joint_states", "gearbox_states", "setpoints", "reference"):
        assert np.ptp(series[name].stamp) > 1.5, name


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_asked_to_end_it_leaves_a_whole_bag(tmp_path, domain, peer, number):
    from trunk_ros.nodes.graph.ros import JointState

    path, joints = tmp_path / "run", peer.listen(JointState, "joint_states")
    with running("bringup", "--output", path, "--seconds", 1000, domain=domain) as process:
        wait_for_data(path)
        joints.clear()
        peer.until(lambda: len(joints) > RATE / 2)
        code, out, _ = ended(process, number)
    assert code == 0
    assert "lost: 0" in out
    assert len(bag_messages(path)["/joint_states"]) > RATE / 2


def test_a_node_that_is_killed_ends_the_run_with_a_whole_bag(tmp_path, domain, peer):
    from trunk_ros.nodes.graph.ros import JointState

    path, joints = tmp_path / "run", peer.listen(JointState, "joint_states")
    with running("bringup", "--output", path, "--seconds", 1000, "--processes", domain=domain) as process:
        wait_for_data(path)
        ears = partial(peer.node.get_subscriptions_info_by_topic, "joint_states")
        peer.until(lambda: "recorder" in {ear.node_name for ear in ears()})
        joints.clear()
        peer.until(lambda: len(joints) > RATE)
        os.kill(child(process.pid, "wire_elasticity"), signal.SIGKILL)
        _, error = process.communicate(timeout=120)
    assert process.returncode == 1
    assert "wire_elasticity was ended by signal 9" in error
    assert len(bag_messages(path)["/joint_states"]) > 0


def test_processes_do_not_outlive_a_bringup_that_is_killed(tmp_path, domain):
    with running(
        "bringup", "--output", tmp_path / "run", "--seconds", 1000, "--processes", domain=domain
    ) as process:
        wait_for_data(tmp_path / "run")
        node = child(process.pid, "servo_driver")
        process.kill()
        process.wait()
        end = time.monotonic() + 60
        while alive(node):
            assert time.monotonic() < end
            time.sleep(0.05)


def test_an_existing_output_is_refused_before_anything_starts(command, tmp_path):
    done = command("bringup", "--output", tmp_path, "--seconds", 5)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [f"trunk_ros: {tmp_path} exists: give another output, or --overwrite"]


def test_knowing_the_plant_takes_the_error_away(tmp_path):
    model = load_model("trunk")
    effects = {
        "backlash": {"half_width": np.full(5, 2e-3)},
        "ratio_error": {"relative": np.full(5, 0.02)},
        "joint_coupling": {"gain": np.array([0, 0.03, 0.02, 0.03, 0.04]), "source": ["joint_1"] * 5},
    }
    plant = tmp_path / "plant.yaml"
    save_model(replace(model, effects=effects), plant)
    for believed in ("trunk", plant):
        models = ("--model", believed, "--plant-model", plant, "--trajectory", "sweeps")
        simulated(tmp_path / f"with_{str(believed)[-4:]}", *models, seconds=5)
    nominal, known = (true_error(tmp_path / name) for name in ("with_runk", "with_yaml"))
    assert nominal > 2e-3
    assert known < 3e-4


def true_error(path):
    """Root mean square of joint angle less reference [rad], after the play has engaged."""
    series = read_recording(path).series
    reference, joints = series["reference"], series["joint_states"]
    same = np.searchsorted(joints.stamp, reference.stamp - 1e-6)
    return np.sqrt(np.mean((joints.position[same] - reference.position)[300:] ** 2))


def test_others_may_stand_in_for_servo_and_wire(tmp_path, domain, peer):
    from trunk_ros.nodes.graph.messages import joint_state, nanoseconds
    from trunk_ros.nodes.graph.ros import Clock, JointState

    gearbox, joints = (
        peer.publisher(JointState, topic) for topic in ("trunk/gearbox_states", "joint_states")
    )
    asked = {"phi": np.zeros(5)}

    def on_clock(message):
        now = nanoseconds(message.clock)
        gearbox.publish(joint_state(now, JOINTS, asked["phi"]))
        joints.publish(joint_state(now, JOINTS, 0.625 * asked["phi"]))

    def on_setpoints(message):
        asked["phi"] = np.asarray(message.position)

    peer.node.create_subscription(Clock, "/clock", on_clock, 100)
    peer.node.create_subscription(JointState, "trunk/setpoints", on_setpoints, 100)
    without = ("--without", "servo_driver", "wire_elasticity")
    arguments = ("--output", tmp_path / "run", "--seconds", 2, "--sim-time", *without)
    with running("bringup", *arguments, domain=domain) as process:
        peer.until(lambda: process.poll() is not None, timeout=200)
        assert process.returncode == 0, process.stderr.read()
    messages = bag_messages(tmp_path / "run")
    for topic in ("/joint_states", "/trunk/gearbox_states", "/clock"):
        assert len(set(messages[topic])) == 2 * RATE
    assert "/trunk/wire_states" not in messages
    assert len(messages["/robot_description"]) == 1


def wait_for_data(path):
    """Until a recording of some size is on disk."""
    end = time.monotonic() + 120
    while not any(size_of(file) > 40000 for file in path.glob("*.mcap")):
        assert time.monotonic() < end, "nothing recorded"
        time.sleep(0.05)


def child(parent, name):
    """Process number of a child that runs a node."""
    listed = subprocess.run(["ps", "-o", "pid=,args=", "--ppid", str(parent)], capture_output=True, text=True)
    return next(int(line.split()[0]) for line in listed.stdout.splitlines() if f"trunk_ros {name}" in line)


def alive(number):
    """Whether a process runs (a zombie does not)."""
    try:
        with open(f"/proc/{number}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
