"""Losses are counted from the publishers' own numbers."""

from itertools import zip_longest
from types import SimpleNamespace

import pytest

from trunk_ros.console import console
from trunk_ros.nodes import bringup
from trunk_ros.nodes.graph.losses import Tally, in_words


def tally(numbers, publishers=1):
    it = Tally(publishers=publishers)
    for at, number in enumerate(numbers):
        it.note(number, at * 10**9)
    return it


def test_a_gap_is_a_loss():
    it = tally([1, 2, 3, 6, 7])
    assert (it.received, it.lost, it.expected) == (5, 2, 7)


def test_what_was_sent_before_the_recording_is_no_loss():
    it = tally([41, 42, 43])
    assert (it.lost, it.before) == (0, 40)


def test_two_publishers_with_the_same_numbers_are_told_apart():
    assert tally([1, 1, 2, 2, 3, 3], publishers=2).lost == 0
    assert tally([5, 1, 6, 2, 7, 3], publishers=2).lost == 0
    assert tally([1, 1, 2, 4, 3, 5], publishers=2).lost >= 1


def test_a_publisher_that_comes_later_is_no_loss_once_it_is_counted():
    it = tally([1, 2, 3])
    assert not it.goes_on(8)
    it.publishers = 2
    it.note(8, 10**9)
    assert it.goes_on(4)
    assert it.goes_on(9)
    assert (it.lost, it.before) == (0, 7)


def test_a_publisher_that_begins_anew_is_no_loss():
    assert tally([7, 8, 9, 1, 2]).lost == 0


def in_turn(*streams):
    return [number for turn in zip_longest(*streams) for number in turn if number]


@pytest.mark.parametrize(
    "after", [in_turn(range(1, 21), range(121, 141)), in_turn(range(121, 141), range(1, 21))]
)
def test_a_publisher_that_begins_anew_beside_another_one_is_no_loss(after):
    before = in_turn(range(1, 121), range(1, 51))
    assert tally(before + after, publishers=2).lost == 0
    assert tally([*before, *after, 151], publishers=2).lost == 10


def test_a_publisher_that_begins_anew_again_and_again_is_no_loss():
    numbers = in_turn(range(1, 101), range(1, 101))
    for last in range(100, 1100, 50):
        numbers += in_turn(range(last + 1, last + 51), range(1, 51))
    assert tally(numbers, publishers=2).lost == 0


def test_what_passes_in_a_pause_is_neither_received_nor_lost():
    it = tally([1, 2, 3])
    it.pause()
    for number in (4, 9, 10):
        it.note(number, 100 * 10**9)
    it.resume()
    it.note(11, 200 * 10**9)
    it.note(13, 201 * 10**9)
    assert (it.received, it.lost) == (5, 1)
    assert it.summary()["longest_gap_s"] == 1.0


def test_types_that_are_not_recorded_are_said():
    it = tally([1, 2])
    it.unrecorded = ["std_msgs/msg/String"]
    assert in_words("run", {"/a": it.summary()}) == [
        "run: 2 messages on 1 topics, none of those lost",
        "  /a: also published as std_msgs/msg/String, not recorded: a topic has one type",
    ]


def test_the_longest_gap_is_kept():
    it = Tally()
    for at in (0, 10, 25, 30):
        it.note(None, at * 10**9)
    assert it.summary()["longest_gap_s"] == 15.0


def test_a_run_is_summed_up_with_what_each_topic_lacks():
    it = tally([1, 2, 5])
    it.dropped = 1
    assert in_words("run", {"/a": it.summary(), "/b": tally([1, 2]).summary()}) == [
        "run: 4 messages on 2 topics, 3 lost",
        "  /a: of 5 messages 2 lost on the way, 1 not written; longest gap 1 s",
    ]
    assert in_words("run", {"/b": tally([1]).summary()}) == ["run: 1 messages on 1 topics, none lost"]


def test_a_quiet_run_is_not_summed_up(monkeypatch, capsys):
    bag = SimpleNamespace(messages={"/joint_states": 7}, custom={})
    monkeypatch.setattr(bringup, "read_metadata", lambda path: bag)
    monkeypatch.setattr(console._Asked, "level", console.Level.QUIET)
    bringup.summarise(SimpleNamespace(output="run"))
    bringup.note("asked to end: closing the recording")
    assert capsys.readouterr() == ("", "")
    bringup.say("ended early: no answer")
    assert "ended early" in capsys.readouterr().err


def test_counts_of_a_run_stand_in_one_column_whatever_the_names_of_the_topics(monkeypatch, capsys):
    messages = {"/joint_states": 7, "/a_far_away_arm/with_a_long_name/joint_states": 12}
    bag = SimpleNamespace(messages=messages, custom={})
    monkeypatch.setattr(bringup, "read_metadata", lambda path: bag)
    bringup.summarise(SimpleNamespace(output="run"))
    lines = [line for line in capsys.readouterr().out.splitlines() if "joint_states" in line]
    assert len({len(line) for line in lines}) == 1
