"""Losses are counted from the publishers' own numbers."""

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
