"""What a node says about itself."""

from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.health import OK, WARN, Health, Stream


def test_a_stream_is_stale_only_after_it_has_begun():
    health = Health({"in": Stream(0.5)})
    assert health.report(10 * SECOND)[:2] == (OK, "ok")
    health.streams["in"].arrived(10 * SECOND)
    assert health.report(10 * SECOND + SECOND // 4)[0] == OK
    level, words, _ = health.report(11 * SECOND)
    assert (level, words) == (WARN, "no in for 1.0 s")


def test_rates_are_those_since_the_last_report():
    health = Health({"in": Stream(0.5)})
    assert not health.due(0)
    for step in range(200):
        health.ticked(late=step * 1000)
        health.streams["in"].arrived(step)
    assert health.due(2 * SECOND)
    values = health.report(2 * SECOND)[2]
    assert (values["rate [Hz]"], values["in [Hz]"], values["worst lateness [ms]"]) == (
        "100.0",
        "100.0",
        "0.199",
    )


def test_the_same_words_are_counted_not_repeated():
    health = Health()
    for _ in range(3):
        health.note("odd")
    assert health.report(SECOND)[:2] == (WARN, "odd (3 times)")
    assert health.report(2 * SECOND)[:2] == (OK, "ok")
