"""What a bag says of the run: the command, and when the clock was set."""

import time

from trunk_ros.nodes.bags.run_notes import WallClock, command

SECOND = 10**9


class Clocks:
    """Clocks that a test sets."""

    def __init__(self, monkeypatch):
        self.wall, self.mono = 1_750_000_000 * SECOND, 5 * SECOND
        monkeypatch.setattr(time, "time_ns", lambda: self.wall)
        monkeypatch.setattr(time, "monotonic_ns", lambda: self.mono)

    def pass_by(self, ns):
        self.wall += ns
        self.mono += ns


def test_a_clock_that_is_set_is_said_once(monkeypatch):
    clocks = Clocks(monkeypatch)
    wall = WallClock()
    clocks.pass_by(SECOND)
    assert wall.look() == ""
    clocks.wall -= 3600 * SECOND
    assert wall.look() == "the clock was set back by 3600.000 s"
    clocks.pass_by(SECOND)
    assert wall.look() == ""
    assert wall.jumps == ["the clock was set back by 3600.000 s at 1750000001.000"]


def test_a_clock_that_is_set_makes_no_gap(monkeypatch):
    clocks = Clocks(monkeypatch)
    wall = WallClock()
    before = wall.steady(clocks.wall)
    clocks.pass_by(SECOND)
    wall.look()
    assert wall.steady(clocks.wall) - before == SECOND
    clocks.pass_by(SECOND)
    arrived = clocks.wall
    clocks.wall += 7200 * SECOND
    wall.look()
    assert SECOND <= wall.steady(arrived) - before <= 2 * SECOND


def test_the_command_is_what_was_typed():
    assert (
        command(["/somewhere/trunk_ros/__main__.py", "recorder", "-p", "a b"])
        == "trunk_ros recorder -p 'a b'"
    )
    assert command(["/somewhere/bin/recorder", "--ros-args"]) == "recorder --ros-args"
