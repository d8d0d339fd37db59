"""A step of simulated time ends when everybody has acted and nothing is under way."""

from trunk_ros.nodes.graph.progress import Ledger, Progress


def ledger(sent, received, stamp=5, lag=0):
    it = Ledger(["out", "in"], {"in": lag})
    it.note(Progress("out", stamp, sent={"t": sent}))
    it.note(Progress("in", stamp, received={"t": received}))
    return it


def test_a_message_under_way_keeps_the_step_open():
    assert not ledger(3, 2).complete(5)
    assert ledger(3, 3).complete(5)


def test_a_node_that_has_not_acted_keeps_the_step_open():
    assert not ledger(3, 3, stamp=4).complete(5)
    assert not Ledger(["out"]).complete(5)


def test_a_recorder_may_be_behind_but_not_at_the_end():
    it = ledger(10, 3, lag=20)
    assert it.complete(5)
    assert it.in_flight(strict=True) == {"t -> in": 7}


def test_what_was_given_up_and_comes_after_all_is_waited_for_again():
    it = ledger(3, 2)
    assert it.excuse() == {"t -> in": 1}
    assert it.complete(5)
    it.note(Progress("in", 5, received={"t": 3}))
    assert it.complete(5)
    it.note(Progress("out", 5, sent={"t": 4}))
    assert not it.complete(5)


def test_a_receiver_that_speaks_before_the_sender_does_not_count_as_a_loss():
    it = ledger(3, 4)
    assert it.complete(5)
    it.note(Progress("out", 5, sent={"t": 4}))
    assert it.complete(5)


def test_progress_goes_through_text_unchanged():
    progress = Progress("n", 7, {"a": 1}, {"b": 2}, {">a": 3})
    assert Progress.from_json(progress.to_json()) == progress
