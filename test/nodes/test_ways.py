"""What the compensator says of joints that do not go where they are sent."""

import numpy as np

from trunk_ros.nodes.control.ways import REST, Ways

SECOND = 10**9


def played(ways, path, answer, begin=0.0):
    """Rest at each angle (joints,) of a path for longer than it takes; ``answer``: what is measured there."""
    at = begin
    for wanted in np.array(path, dtype=float):
        for _ in range(3):
            ways.see(round(at * SECOND), wanted, answer(wanted))
            at += REST
    return at


def test_joints_with_a_wrong_sign_or_ratio_or_a_dead_sensor_are_named_and_others_are_not():
    ways = Ways(["shoulder", "elbow", "wrist", "tool"])
    played(ways, [[0.0] * 4, [0.4] * 4], lambda wanted: wanted * [-1.0, 0.5, 1.05, 0.0] + 0.3)
    assert "shoulder went -0.40 rad where +0.40 rad was asked" in ways.missed
    assert "elbow went +0.20 rad" in ways.missed
    assert "tool went +0.00 rad" in ways.missed
    assert "wrist" not in ways.missed


def test_a_way_that_backlash_or_sag_could_spoil_is_not_judged_but_adds_up():
    ways = Ways(["shoulder"])
    at = played(ways, [[0.0], [0.08]], lambda wanted: 0.0 * wanted)
    assert ways.missed == ""
    played(ways, [[0.16]], lambda wanted: 0.0 * wanted, at)
    assert "went +0.00 rad where +0.16 rad" in ways.missed


def test_a_joint_that_arrives_late_or_goes_its_next_way_is_named_no_longer():
    ways = Ways(["shoulder"])
    at = played(ways, [[0.0], [0.4]], lambda wanted: 0.5 * wanted)
    assert ways.missed
    ways.see(round(at * SECOND), np.array([0.4]), np.array([0.4]))
    assert ways.missed == ""
    at = played(ways, [[0.0]], lambda wanted: wanted + 0.3, at + 1.0)
    assert ways.missed
    played(ways, [[0.4]], lambda wanted: wanted + 0.3, at)
    assert ways.missed == ""


def test_nothing_is_said_on_the_way_or_of_joints_that_nobody_measures():
    ways = Ways(["shoulder", "elbow"])
    at = played(ways, [[0.0, 0.0]], lambda wanted: wanted)
    for step in range(100):
        ways.see(round((at + 0.01 * step) * SECOND), np.array([0.01 * step] * 2), np.zeros(2))
    assert ways.missed == ""
    played(ways, [[1.0, 1.0]], lambda wanted: np.array([1.0, np.nan]), at + 1.0)
    assert ways.missed == ""
