"""recorder over DDS: nothing missed, nothing changed, nothing lost when it is killed."""

import json
import os
import random
import signal

import pytest

from test.nodes.graph import Received, bag_messages, ended, needs_ros, running, values
from test.recording.kill import kill_once
from trunk_ros import __version__
from trunk_ros.recording.bag.metadata import read_metadata

pytestmark = needs_ros


@pytest.fixture
def recorder(domain, peer, tmp_path):
    """A recorder at work, and its bag."""
    path = tmp_path / "bag"
    given = ("-p", f"output:={path}", "-p", "supervised:=true")
    received = Received(peer)
    with running("recorder", "--ros-args", *given, domain=domain) as process:
        yield process, path, peer, received


def numbered(count):
    from trunk_ros.nodes.graph.ros import String

    return [String(data=f"message {number}") for number in range(count)]


def texts(messages):
    return [raw[8:].rstrip(b"\0").decode() for raw in messages]


def test_every_quality_of_service_is_matched_and_latched_messages_are_kept(recorder):
    from trunk_ros.nodes.graph.ros import DurabilityPolicy, QoSProfile, ReliabilityPolicy, String

    process, path, peer, received = recorder
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    careless = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    peer.node.create_publisher(String, "latched", latched).publish(String(data="sent before"))
    fast = peer.node.create_publisher(String, "fast", careless)
    late = peer.node.create_publisher(String, "late", 100)
    peer.meets(late, node="recorder")
    peer.until(lambda: received("/fast") or fast.publish(String(data="heard?")))
    for message in numbered(50):
        fast.publish(message)
        late.publish(message)
    peer.until(lambda: received("/fast") > 50 and received("/late") == 50 and received("/latched") == 1)
    assert ended(process, signal.SIGINT)[0] == 0
    messages = bag_messages(path)
    assert len(messages["/latched"]) == 1
    assert b"sent before" in messages["/latched"][0]
    assert texts(messages["/late"]) == [m.data for m in numbered(50)]
    assert texts(messages["/fast"])[-50:] == [m.data for m in numbered(50)]


def test_publishers_of_all_qualities_on_one_topic_are_heard_once_each(domain, peer, tmp_path):
    from trunk_ros.nodes.graph.ros import DurabilityPolicy, QoSProfile, ReliabilityPolicy, String

    latched = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    careless = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    first, second = (
        peer.node.create_publisher(String, "mixed", qos) for qos in (latched, QoSProfile(depth=100))
    )
    for text in ("latched 1", "latched 2"):
        first.publish(String(data=text))
    path = tmp_path / "bag"
    received = Received(peer)
    given = ("-p", f"output:={path}", "-p", "supervised:=true")
    with running("recorder", "--ros-args", *given, domain=domain) as process:
        peer.meets(first, second, node="recorder")
        peer.until(lambda: received("/mixed") == 2)
        expected = ["latched 1", "latched 2"]
        third, number = None, 0
        while third is None or number < 100 or not third.get_subscription_count():
            if number == 40:  # joins while the others go on: the recorder has to ask for less
                third = peer.node.create_publisher(String, "mixed", careless)
            for publisher, name in ((first, "latching"), (second, "reliable")):
                publisher.publish(String(data=f"{name} {number}"))
                expected.append(f"{name} {number}")
            number += 1
            peer.spin_once()
        peer.until(lambda: received("/mixed") == len(expected))
        peer.until(lambda: received("/mixed") > len(expected) or third.publish(String(data="heard?")))
        before = received("/mixed")
        third.publish(String(data="careless"))
        peer.until(lambda: received("/mixed") > before)
        assert ended(process, signal.SIGINT)[0] == 0
    kept = texts(bag_messages(path)["/mixed"])
    assert sorted(text for text in kept if text != "heard?") == sorted([*expected, "careless"])


def test_the_bag_carries_what_ros2_bag_needs(recorder):
    import yaml

    from trunk_ros.nodes.graph.ros import String

    process, path, peer, received = recorder
    out = peer.publisher(String, "some/topic")
    peer.meets(out, node="recorder")
    out.publish(String(data="one"))
    peer.until(lambda: received("/some/topic") == 1)
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


def test_the_bag_says_how_it_was_made(domain, peer, tmp_path):
    path = tmp_path / "bag"
    own = """{"seed": 7, "operator": "me"}"""
    given = ("--ros-args", "-p", f"output:={path}", "-p", f"manifest:='{own}'", "-p", "split_duration:=9.0")
    with running("recorder", *given, domain=domain) as process:
        peer.until(lambda: path.exists())
        assert ended(process, signal.SIGINT)[0] == 0
    told = json.loads(read_metadata(path).custom["trunk_ros.manifest"])
    assert (told["seed"], told["operator"], told["version"]) == (7, "me", __version__)
    assert told["command"].startswith("trunk_ros recorder --ros-args -p output:=")
    assert told["recorder"]["split_duration"] == 9.0


def test_what_was_sent_before_the_end_is_recorded_and_nothing_that_comes_after(domain, peer, tmp_path):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, String

    path, said = tmp_path / "bag", peer.listen(DiagnosticArray, "diagnostics")
    given = ("-p", f"output:={path}", "-p", "topics:=['/numbers']")
    out = peer.publisher(String, "numbers")
    with running("recorder", "--ros-args", *given, domain=domain) as process:
        peer.meets(out, node="recorder")
        out.publish(String(data="heard?"))
        peer.until(lambda: values(said, "recorder").get("messages") == "1")
        for message in numbered(90):
            out.publish(message)
        process.send_signal(signal.SIGINT)
        while process.poll() is None:  # publishers that go on do not keep it from ending
            out.publish(String(data="after"))
            peer.spin_once()
    kept = texts(bag_messages(path)["/numbers"])
    assert kept[1:91] == [message.data for message in numbered(90)]
    assert process.returncode == 0
    assert "none lost" in process.stdout.read()


def test_messages_of_a_mebibyte_are_kept_byte_for_byte(recorder):
    from trunk_ros.nodes.graph.ros import String

    process, path, peer, received = recorder
    out = peer.publisher(String, "large")
    peer.meets(out, node="recorder")
    sent = [str(number) * (1 << 20) for number in range(10)]
    for number, text in enumerate(sent):
        out.publish(String(data=text))
        peer.until(lambda number=number: received("/large") > number)
    assert ended(process, signal.SIGINT)[0] == 0
    assert texts(bag_messages(path)["/large"]) == sent


def test_while_the_clock_has_not_begun_messages_wait_in_the_room_there_is(domain, peer, tmp_path):
    from trunk_ros.nodes.graph.ros import String

    path, count, size = tmp_path / "bag", 30, 10_000
    given = ("-p", f"output:={path}", "-p", "use_sim_time:=true", "-p", "buffer_size:=0.1")
    received = Received(peer)
    with running("recorder", "--ros-args", *given, "-p", "supervised:=true", domain=domain) as process:
        out = peer.publisher(String, "large")
        peer.meets(out, node="recorder")
        for number in range(count):
            out.publish(String(data=f"{number:02}" * (size // 2)))
        peer.until(lambda: received("/large") == count)
        assert ended(process, signal.SIGINT)[0] == 0
    kept = [int(raw[8:10]) for raw in bag_messages(path)["/large"]]
    room = int(0.1 * (1 << 20)) // size
    assert kept == list(range(room))
    loss = json.loads(read_metadata(path).custom["trunk_ros.loss"])["/large"]
    assert (loss["received"], loss["lost"], loss["dropped"]) == (count, 0, count - room)


def test_a_second_recorder_on_the_same_folder_is_refused(command, recorder):
    process, path, peer, received = recorder
    peer.until(lambda: received("/diagnostics"))
    second = command("recorder", "--ros-args", "-p", f"output:={path}")
    assert second.returncode == 2
    assert "is being recorded" in second.stderr
    assert ended(process, signal.SIGINT)[0] == 0
    assert "/diagnostics" in bag_messages(path)
    third = command("recorder", "--ros-args", "-p", f"output:={path}")
    assert third.returncode == 2
    assert third.stderr.strip().endswith("exists: give another output")


def test_what_a_killed_recorder_left_is_repaired_by_the_next(command, recorder):
    process, path, peer, received = recorder
    peer.until(lambda: received("/diagnostics"))
    (file,) = path.glob("*.mcap")
    size = file.stat().st_size
    peer.until(lambda: file.stat().st_size > size)
    process.kill()
    process.wait()
    following = command("recorder", "--ros-args", "-p", f"output:={path}")
    assert following.returncode == 2
    assert "repaired, " in following.stderr
    assert json.loads(read_metadata(path).custom["trunk_ros.manifest"])["version"] == __version__
    assert len(following.stderr.splitlines()) == 1
    assert bag_messages(path)["/diagnostics"]


@pytest.mark.parametrize("number", range(int(os.environ.get("KILLS", "3"))))
def test_killed_at_any_moment_it_has_lost_at_most_the_last_second(domain, monkeypatch, tmp_path, number):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    kill_once(tmp_path / "bag", random.Random(number))


@pytest.mark.parametrize("arguments", [[], ["-p", "output:=/proc/nowhere/bag"], ["-p", "output:=."]])
def test_an_output_that_cannot_be_is_refused(command, arguments):
    done = command("recorder", "--ros-args", *arguments)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1, done.stderr
