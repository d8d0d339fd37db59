"""recorder over DDS: nothing missed, nothing changed, nothing lost when it is killed."""

import json
import signal

import pytest

from test.nodes.graph import bag_messages, ended, needs_ros, running, trunk
from trunk_ros.recording.metadata import read_metadata

pytestmark = needs_ros


@pytest.fixture
def recorder(domain, peer, tmp_path):
    """A recorder at work, and its bag."""
    path = tmp_path / "bag"
    with running("recorder", "--ros-args", "-p", f"output:={path}", domain=domain) as process:
        yield process, path, peer


def numbered(count):
    from trunk_ros.nodes.ros import String

    return [String(data=f"message {number}") for number in range(count)]


def heard(publisher):
    return lambda: publisher.get_subscription_count() > 0


def test_every_quality_of_service_is_matched_and_latched_messages_are_kept(recorder):
    from trunk_ros.nodes.ros import DurabilityPolicy, QoSProfile, ReliabilityPolicy, String

    process, path, peer = recorder
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    careless = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    peer.node.create_publisher(String, "latched", latched).publish(String(data="sent before"))
    fast = peer.node.create_publisher(String, "fast", careless)
    late = peer.node.create_publisher(String, "late", 100)
    peer.until(lambda: heard(fast)() and heard(late)())
    for message in numbered(50):
        fast.publish(message)
        late.publish(message)
        peer.spin(0.002)
    peer.spin(0.3)
    assert ended(process, signal.SIGINT)[0] == 0
    messages = bag_messages(path)
    assert len(messages["/latched"]) == 1
    assert b"sent before" in messages["/latched"][0]
    assert [raw[8:].rstrip(b"\0").decode() for raw in messages["/late"]] == [m.data for m in numbered(50)]
    assert len(messages["/fast"]) == 50


def test_the_bag_carries_what_ros2_bag_needs(recorder):
    import yaml

    from trunk_ros.nodes.ros import String

    process, path, peer = recorder
    out = peer.publisher(String, "some/topic")
    peer.until(heard(out))
    out.publish(String(data="one"))
    peer.spin(0.3)
    assert ended(process, signal.SIGTERM)[0] == 0
    told = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (told["version"], told["storage_identifier"]) == (9, "mcap")
    assert told["relative_file_paths"] == ["bag_0.mcap"]
    topics = {each["topic_metadata"]["name"]: each for each in told["topics_with_message_count"]}
    entry = topics["/some/topic"]
    assert entry["message_count"] == 1
    assert entry["topic_metadata"]["type"] == "std_msgs/msg/String"
    assert entry["topic_metadata"]["type_description_hash"].startswith(
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db12"
    )
    assert entry["topic_metadata"]["offered_qos_profiles"][0]["reliability"] == "reliable"
    assert json.loads(read_metadata(path).custom["trunk_ros.loss"])["/some/topic"]["lost"] == 0


def test_killed_it_has_lost_at_most_the_last_second(recorder):
    from trunk_ros.nodes.ros import String

    process, path, peer = recorder
    out = peer.publisher(String, "numbers")
    peer.until(heard(out))
    for message in numbered(150):
        out.publish(message)
        peer.spin(0.01)
    peer.spin(1.0)
    for message in numbered(20):
        out.publish(message)
        peer.spin(0.01)
    process.kill()
    process.wait()
    repaired = trunk("recover", path)
    assert repaired.returncode == 0, repaired.stderr
    assert len(bag_messages(path)["/numbers"]) >= 150


@pytest.mark.parametrize("arguments", [[], ["-p", "output:=/proc/nowhere/bag"], ["-p", "output:=."]])
def test_an_output_that_cannot_be_is_refused(arguments):
    done = trunk("recorder", "--ros-args", *arguments)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1, done.stderr
