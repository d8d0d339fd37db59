"""Physics without a name: what it depends on is told, and a curve stands in for it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import PAIR, SHORT, diagnose, of_the_servos, of_the_wires, recorded, reshaped
from trunk_ros.compiled import Array
from trunk_ros.data.spectrum import repeats_in, spectrum
from trunk_ros.diagnosis import Diagnosis
from trunk_ros.diagnosis.discrepancy.curves import Place, with_curve
from trunk_ros.diagnosis.discrepancy.jumps import jumps, moved_by, turns_of
from trunk_ros.diagnosis.discrepancy.smooth import smoothed
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.report import render
from trunk_ros.diagnosis.verdict.curve_words import statement
from trunk_ros.effects.curve import KNOTS, VALUES
from trunk_ros.effects.effect import Now
from trunk_ros.effects.wire.unknown import Unknown
from trunk_ros.effects.wire.unknown_cycle import UnknownCycle
from trunk_ros.model import Model, load_model, save_model

NOISE = np.random.default_rng(5)


def with_added(column: int, of: Any) -> Diagnosis:
    """The diagnosis of a good arm to one of whose joints something (stamp, speeds) -> (n,) is added."""
    recording = of_the_wires(recorded(nominal=SHORT))
    joints = recording.series["joint_states"]
    speeds = np.gradient(joints.position, joints.stamp, axis=0)
    smooth = np.apply_along_axis(lambda v: np.convolve(v, np.ones(15) / 15, "same"), 0, speeds)
    position = joints.position.copy()
    position[:, column] += of(joints.stamp, smooth)
    return diagnose([reshaped(recording, "joint_states", position=position)], SHORT)


def left(result: Diagnosis, joint: str) -> float:
    """Held-out error over the noise floor."""
    said = result.stages["wire"]["joints"][joint]
    return float(said["rmse_after"] / said["noise_floor"])


STAMP = np.arange(0.0, 60.0, 0.01)
PASSES = 0.3 * np.sin(np.column_stack([0.9 * STAMP, 0.53 * STAMP + 1.0]))
IN_TURN = np.column_stack([np.where(STAMP < 7.0, PASSES[:, 0], PASSES[699, 0]), PASSES[:, 1]])
AT_TIMES = np.searchsorted([7.3, 12.9, 21.4, 33.8, 44.1, 52.6], STAMP) % 2 * 1.0


@pytest.mark.parametrize(
    ("rest", "angles", "by_motion"),
    [
        (np.sign(np.gradient(PASSES[:, 0])) * (STAMP > 30.0), PASSES, True),  # friction that has changed
        ((PASSES[:, 0] > 0.12) * 1.0, PASSES, True),
        ((PASSES[:, 1] > -0.07) * 1.0, PASSES, True),
        (AT_TIMES, PASSES, False),
        (AT_TIMES, IN_TURN, False),
    ],
    ids=[
        "at its turns",
        "at a place",
        "at another joint's place",
        "at moments of its own",
        "while it stands",
    ],
)
def test_jumps_are_a_matter_of_time_unless_the_motion_brings_them_on(
    rest: Array, angles: Array, by_motion: bool
) -> None:
    noise = np.random.default_rng(8).normal(size=len(STAMP))
    moments = jumps(STAMP, 10.0 * rest + noise, 60.0, 30)
    assert len(moments) > 4
    assert moved_by(STAMP, rest, moments, angles, 0) == by_motion


def test_what_follows_the_speed_of_another_joint_names_that_joint() -> None:
    result = with_added(1, lambda _, speed: 4e-3 * speed[:, 0])
    (found,) = result.findings
    assert (found.effect, found.joints) == ("unknown", ["joint_2"])
    assert found.depends_on == ["joint_1", "speed"]
    assert found.regime == "high_speed"
    assert found.curve["x_unit"] == "rad/s"
    assert left(result, "joint_2") < 1.3


def test_what_shakes_the_arm_is_told_with_its_frequency_and_drawn_over_its_period() -> None:
    result = with_added(1, lambda t, _: 5e-4 * np.sin(2 * np.pi * 5.3 * t + 1.0))
    (found,) = result.findings
    assert (found.effect, found.joints, found.depends_on) == ("unknown", ["joint_2"], ["time"])
    assert "5.3 Hz" in found.statement
    (curve,) = found.curve["joints"].values()
    assert np.ptp(curve["x"]) == pytest.approx(1 / 5.3, rel=1e-3)
    assert np.ptp(curve["y"]) == pytest.approx(1e-3, rel=0.05)
    assert left(result, "joint_2") < 1.2
    assert "5.3 Hz" in render(result)


@pytest.mark.long
def test_a_zero_that_jumps_to_and_fro_is_told_with_its_moments() -> None:
    moments = (4.0, 8.0, 13.0, 17.5)
    result = with_added(2, lambda t, _: 1e-3 * (np.searchsorted(moments, t) % 2))
    (found,) = result.findings
    assert (found.effect, found.joints, found.depends_on) == ("unknown", ["joint_3"], ["time"])
    assert "jumps 4 times" in found.statement
    assert (found.curve["x_unit"], found.curve["y_unit"]) == ("s", "rad")
    np.testing.assert_allclose(found.curve["joints"]["joint_3"]["x"][1:], moments, atol=0.05)
    assert left(result, "joint_3") < 1.2


@pytest.mark.long
def test_errors_that_a_servo_does_not_answer_to_have_no_other_name() -> None:
    zone = {p.name: np.full(2, 3e-3) for p in VALUES}
    ends = {"on": ["position"] * 2, "low": np.full(2, -1.0), "high": np.full(2, 1.0)}
    result = diagnose([of_the_servos(recorded({"unknown_dead_zone": ends | zone}, nominal=PAIR))], PAIR)
    assert {(f.effect, f.stage) for f in result.findings} == {("unknown", "servo")}
    assert {joint for f in result.findings for joint in f.joints} == set(PAIR.arm.joints)
    seen = result.model.effects["unknown_dead_zone"]
    middle = np.array([seen[p.name] for p in VALUES[8:16]])
    assert np.median(middle) == pytest.approx(3e-3, rel=0.1)


@pytest.mark.parametrize(("power", "furthest"), [(1.0, 4.0), (2.0, 2.0)])
def test_beyond_its_ends_a_curve_goes_on_straight_but_not_for_ever(power: float, furthest: float) -> None:
    """One that is a straight line is trusted further than one that bends."""
    x = np.linspace(0.0, 1.0, KNOTS)
    values = {p.name: np.array([v]) for p, v in zip(VALUES, 1e-3 * x**power, strict=True)}
    curve = Unknown({"low": np.zeros(1), "high": np.ones(1), **values}, {"on": ("position",)})

    def at(place: float) -> float:
        one = np.array([[place]])
        now = Now(*[np.zeros(1)] * 2, one, one, one, one, one, ("joint_1",), np.ones(1))
        return float(curve.run(np.zeros((1, 1)), now, None)[0][0, 0])

    assert at(1.3) == pytest.approx((1.0 + 0.3 * power) * 1e-3, rel=0.02)
    assert at(-0.4) == pytest.approx(-0.4e-3 if power == 1.0 else 0.0, abs=2e-5)
    assert at(9.0) == pytest.approx(furthest * 1e-3, rel=0.02)


def test_beyond_its_ends_a_curve_that_winds_is_held() -> None:
    wave = 1e-3 * np.sin(8.0 * np.pi * np.linspace(0.0, 1.0, KNOTS))
    values = {p.name: np.array([v]) for p, v in zip(VALUES, wave, strict=True)}
    curve = Unknown({"low": np.zeros(1), "high": np.ones(1), **values}, {"on": ("position",)})
    far = np.linspace(-1.0, 2.0, 61)[:, None]
    now = Now(*[np.arange(61.0)] * 2, far, far, far, far, far, ("joint_1",), np.ones(1))
    assert np.abs(curve.run(0.0 * far, now, None)[0]).max() < 2.2e-3


def test_a_curve_bends_as_much_as_its_data_ask_for() -> None:
    x = np.linspace(0.0, 1.0, 4000)
    design = Unknown.basis(x, 0.0, 1.0)

    def error(wave: Array) -> tuple[float, float]:
        values, bends = smoothed(design, wave + NOISE.normal(size=len(x)), Unknown.bend())
        return float(np.sqrt(np.mean((design @ values - wave) ** 2))), bends

    straight, few = error(x)
    waved, many = error(3.0 * np.sin(20.0 * x))
    assert straight < 0.05
    assert few < 4.0 < many
    assert waved < 0.1


@pytest.mark.parametrize("frequency", [0.11, 3.21, 17.7])
def test_a_line_is_found_between_the_steps_of_its_spectrum(frequency: float) -> None:
    stamp = np.sort(np.linspace(0.0, 40.0, 4000) + NOISE.uniform(-2e-3, 2e-3, 4000))
    found, share = spectrum(stamp, np.sin(2 * np.pi * frequency * stamp) + NOISE.normal(size=4000))
    assert found == pytest.approx(frequency, abs=2e-3)
    assert share == pytest.approx(1 / 3, abs=0.05)


@pytest.mark.parametrize(
    ("period", "again"), [(8.0, True), (4.0, True), (2.0, True), (5.1, False), (0.4, False)]
)
def test_what_swings_as_often_as_a_motion_repeats_may_be_of_the_motion(period: float, again: bool) -> None:
    stamp = np.arange(0.0, 60.0, 0.02)
    places = 0.3 * np.cumsum(NOISE.normal(size=8))
    cycle = np.interp(stamp % 8.0, np.arange(9.0), np.append(places, places[0]))
    alone = 0.3 * np.sin(0.9 * stamp) + 0.2 * np.sin(0.37 * stamp)
    assert repeats_in(np.column_stack([alone, cycle]), stamp, period, KNOTS) == again
    assert not repeats_in(alone[:, None], stamp, period, KNOTS)


def test_a_swing_is_said_to_come_without_the_motion_only_where_that_shows() -> None:
    stamp = np.arange(0.0, 60.0, 0.02)
    span: Any = SimpleNamespace(measured=np.asarray, source=np.sin(np.pi / 4.0 * stamp)[:, None], stamp=stamp)
    context: Any = SimpleNamespace(views=[SimpleNamespace(span=span)], telling=lambda _: [0])
    said = [
        statement(context, UnknownCycle, Term("unknown_cycle", own={0: {"high": period}}), "wrist")
        for period in (8.0, 5.1)
    ]
    assert "as often as the motion repeats" in said[0]
    assert "whether the joint moves or not" not in said[0]
    assert "whether the joint moves or not" in said[1]


def test_noise_does_not_jump_and_steps_do_when_they_do() -> None:
    stamp = np.arange(4000) * 0.01
    noise = NOISE.normal(size=4000)
    assert len(jumps(stamp, noise, 60.0, KNOTS)) == 0
    found = jumps(stamp, noise + 2.0 * ((stamp > 10.0) & (stamp < 12.0)), 60.0, KNOTS)
    np.testing.assert_allclose(found, [10.0, 12.0], atol=0.03)


@pytest.mark.parametrize("hertz", [0.06, 0.1, 3.0])
def test_a_joint_turns_twice_a_swing_however_slowly_it_goes(hertz: float) -> None:
    stamp = np.arange(0.0, 10.0 / hertz, 0.01)
    x = np.sin(2 * np.pi * hertz * stamp) + 1e-3 * np.random.default_rng(0).standard_normal(len(stamp))
    turns = stamp[turns_of(x, 0.1)]
    assert np.abs(turns - (0.25 + 0.5 * np.arange(20)) / hertz).max() < 0.05 / hertz


def test_where_a_joint_stands_at_its_turn_it_turns_as_it_sets_out_again() -> None:
    x = np.concatenate([np.linspace(0, 1, 100), np.ones(50), np.linspace(1, 0, 100)])
    assert turns_of(x, 0.1)[0] in range(148, 162)
    assert not len(turns_of(np.linspace(0.0, 1.0, 500), 0.1))


@pytest.mark.parametrize("kind", ["unknown", "unknown_servo", "unknown_gain", "unknown_friction"])
@pytest.mark.parametrize("most", [90.1, 1e9])
def test_a_curve_of_any_size_is_read_as_it_was_written(kind: str, most: float, tmp_path: Path) -> None:
    """One of 11 rad over a joint that swung through 4 had made a model that nothing took."""
    drawn = with_curve(Hypothesis(), Place(kind, "time", 0.0, 4.0), 1, np.linspace(-11.0, most, KNOTS))
    model = Model(SHORT.arm, drawn.model_effects(len(SHORT.arm.joints)))
    save_model(model, tmp_path / "model.yaml")
    assert load_model(tmp_path / "model.yaml").hash() == model.hash()
