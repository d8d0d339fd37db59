"""Claims about hum: a tone that all readings share is the sensors', and what physics swings is left alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.concealed.bag import write_bag
from test.concealed.seeds import drawn
from test.real.features import play
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.data.sensing import clocks_put_right
from trunk_ros.data.sensing.band import Band
from trunk_ros.data.sensing.hum import _beside, hums, tone
from trunk_ros.data.sensing.physics import apart, beside_physics, motion_of
from trunk_ros.diagnosis.diagnoser import Diagnoser
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.hummed import _tone as _tone_of
from trunk_ros.diagnosis.search.hummed import told_from_hum
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.model import Model, load_model
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, Recording

STAMP = np.arange(6000.0) * 0.01
NOISE, SIZE, FREQUENCY = 1e-4, 1.5e-4, 0.47
PHASES = np.array([0.0, 1.3, 2.9, 4.0, 5.5])


@pytest.fixture(scope="module")
def model() -> Model:
    """The nominal one."""
    return load_model("trunk")


def _recording(model: Model, add: Array, moving: Array | None = None) -> Recording:
    """Joints that follow their gearboxes through a play, with ``add`` (n, 5) rad on top of their readings."""
    rng, arm = np.random.default_rng(4), model.arm
    if moving is None:
        slow = rng.normal(size=(len(STAMP), 5)).cumsum(axis=0)
        moving = np.stack([np.convolve(x, np.hanning(300), "same") for x in slow.T], axis=1)
        moving *= 0.5 / np.abs(moving).max(axis=0)
        moving[:, 3] = 0.2  # one joint rests
    joint = np.stack([play(u, w) for u, w in zip(moving.T, arm.dead_band, strict=True)], axis=1)
    shown = joint + add + NOISE * rng.standard_normal(joint.shape)
    series = {
        "gearbox_states": JointSeries(STAMP, arm.joints, moving / arm.ratio),
        "joint_states": JointSeries(STAMP, arm.joints, shown),
    }
    return Recording("hum", 0, float(STAMP[-1]), series)


def _tone(frequency: float, sizes: Array) -> Array:
    return np.asarray(sizes * np.sin(2 * np.pi * frequency * STAMP[:, None] + PHASES))


def test_a_tone_of_one_size_on_all_joints_is_taken_out_and_said(model: Model) -> None:
    tone = _tone(FREQUENCY, np.full(5, SIZE))
    spoiled, clean = _recording(model, tone), _recording(model, 0.0 * tone)
    right = clocks_put_right(spoiled, model)
    (seen,) = right.observed
    assert (seen.kind, seen.corrected, seen.joints) == ("hum", True, model.arm.joints)
    assert seen.value == pytest.approx(SIZE, rel=0.05)
    left = right.series["joint_states"].position - clean.series["joint_states"].position
    assert np.sqrt(np.mean(left**2)) < 0.1 * SIZE


def test_two_tones_are_taken_out_one_by_one(model: Model) -> None:
    both = _tone(FREQUENCY, np.full(5, SIZE)) + _tone(3.1 * FREQUENCY, np.full(5, 0.6 * SIZE))
    right = clocks_put_right(_recording(model, both), model)
    assert [seen.kind for seen in right.observed] == ["hum", "hum"]


@pytest.mark.parametrize("frequency", [0.14, 0.2, 49.93])
def test_a_tone_as_slow_as_the_motion_or_at_half_the_rate_is_found_as_well(
    model: Model, frequency: float
) -> None:
    right = clocks_put_right(_recording(model, _tone(frequency, np.full(5, SIZE))), model)
    (seen,) = right.observed
    assert seen.kind == "hum"
    assert seen.value == pytest.approx(SIZE, rel=0.2)


@pytest.mark.parametrize("sizes", [(1.0, 1.0, 0.0, 1.0, 1.0), (1.0, 1.5, 0.7, 1.0, 1.2)])
def test_what_swings_joints_by_their_own_sizes_is_left_to_the_diagnosis(
    model: Model, sizes: tuple[float, ...]
) -> None:
    recording = _recording(model, _tone(FREQUENCY, SIZE * np.array(sizes)))
    right = clocks_put_right(recording, model)
    assert right.observed == ()
    assert right.series == recording.series


def test_what_a_steady_motion_does_to_joints_that_are_alike_is_no_hum(model: Model) -> None:
    """Play that the model does not know, on joints that all swing alike: the same loop on each."""
    alike = replace(model, arm=replace(model.arm, dead_band=np.full(5, 2e-3)))
    moving = 0.3 * np.sin(2 * np.pi * FREQUENCY * STAMP[:, None] + PHASES)
    assert clocks_put_right(_recording(alike, 0.0 * moving, moving), model).observed == ()


def test_overtones_of_one_swing_are_of_the_plays_that_it_goes_through() -> None:
    """They come back as often as the swing does, here 10 and 15 mrad on all joints."""
    names, stamp = ("a", "b", "c"), np.arange(2000) / 100
    phases = 0.7 * np.arange(3)
    swing = 0.5 * (np.sin(2 * np.pi * 0.3 * stamp[:, None] + phases) - np.sin(phases))
    joint = np.stack([play(u, w) for u, w in zip(swing.T, (0.12, 0.15, 0.1), strict=True)], axis=1)
    joint += NOISE * np.random.default_rng(0).standard_normal(joint.shape)
    shown = JointSeries(stamp, names, joint)
    assert hums(JointSeries(stamp, names, swing), shown, load_model("direct").for_joints(names).arm) == []


def test_where_most_joints_swing_physics_may_make_waves_of_one_size(model: Model) -> None:
    """However far behind: a joint answers by its ratio, its friction, or the load of all."""
    swings = 0.3 * np.sin(2 * np.pi * FREQUENCY * STAMP[:, None] + 1.7 * PHASES)
    slow = 0.1 * np.sin(2 * np.pi * np.array([0.11, 0.13, 0.17, 0.19, 0.23]) * STAMP[:, None])
    noise = np.random.default_rng(2).standard_normal(slow.shape)
    off = _tone(FREQUENCY, np.full(5, SIZE)) + NOISE * noise
    found = [
        tone(STAMP, off.T, asked.T, lambda _: np.ones((len(STAMP), 1)), 2.0)
        for asked in (slow, swings + slow, (np.arange(5) != 1) * swings + slow)
    ]
    assert found[0] is not None
    assert found[0].frequency == pytest.approx(FREQUENCY, abs=1e-3)
    assert found[1:] == [None, None]


def test_what_late_readings_do_to_a_joint_leaves_nothing_that_may_be_hum(model: Model) -> None:
    moving = _recording(model, np.zeros((len(STAMP), 5))).series["gearbox_states"].position * model.arm.ratio
    late = np.stack([np.interp(STAMP - 0.03, STAMP, one) for one in moving.T], axis=1) - moving
    series = _recording(model, late).series
    motion = motion_of(series["gearbox_states"], series["joint_states"], model.arm)
    left = [_beside(beside_physics(motion, j, motion.speed[:, j]), motion.off[:, j])[0] for j in range(5)]
    assert np.std(left, axis=1) == pytest.approx(NOISE, rel=0.25)  # 30 ms late makes 1.3 to 2.8 mrad


def test_a_clean_recording_has_no_hum_and_few_joints_tell_of_none(model: Model) -> None:
    tone = _tone(FREQUENCY, np.full(5, SIZE))
    two = model.arm.joints[:2]
    series = {key: one.select(two) for key, one in _recording(model, tone).series.items()}
    assert hums(series["gearbox_states"], series["joint_states"], model.arm.only(two)) == []
    clean = _recording(model, 0.0 * tone).series
    assert hums(clean["gearbox_states"], clean["joint_states"], model.arm) == []


def test_what_comes_back_four_times_may_have_happened_to_the_arm(model: Model) -> None:
    slow = _recording(model, _tone(4.0 / STAMP[-1], np.full(5, 2.0 * SIZE))).series
    assert hums(slow["gearbox_states"], slow["joint_states"], model.arm) == []


def test_what_comes_back_three_times_is_hum_where_nothing_else_is_left(model: Model) -> None:
    recording = _recording(model, _tone(3.0 / STAMP[-1], np.full(5, 2.0 * SIZE)))
    result = Diagnoser([recording], model, None, lambda _: None, experiments=False).run()
    assert result.findings == []
    (observed,) = result.quality["hum"]["observed"]
    assert observed["kind"] == "hum"
    assert observed["value"] == pytest.approx(2.0 * SIZE, rel=0.05)


def test_a_tone_is_found_beside_physics_that_was_fitted_while_it_was_there(model: Model) -> None:
    """A zero and a creep take a part of it: on that joint it looks smaller than on the others."""
    seconds = 15.0
    drift = np.exp(-STAMP / seconds)[:, None] * np.array([0.0, 0.0, 2e-3, 0.0, 0.0])
    recording = _recording(model, drift + _tone(3.0 / STAMP[-1], np.full(5, 2.0 * SIZE)))
    first = begun(first_look(WireStage([wire_span(recording, model)], model)))
    own = {2: {"amplitude": -2e-3, "time_constant": seconds}}
    zero = Term("zero_offset", own={2: {"offset": 2e-3}})
    drifts = Term("thermal_drift", "exponential", own=own)
    fitted = refit(first.context, Hypothesis(thermal_drift=drifts, zero_offset=zero))
    right = told_from_hum(fitted, lambda column: {})
    assert [hum.size for view in right.context.views for _, hum in view.hums] == [
        pytest.approx(2.0 * SIZE, rel=0.05)
    ]


@pytest.mark.parametrize("sizes", [(1.0, 1.0, 0.0, 1.0, 1.0), (1.0, 1.6, 0.6, 1.3, 0.8)])
def test_what_comes_back_three_times_in_sizes_of_its_own_is_no_hum(
    model: Model, sizes: tuple[float, ...]
) -> None:
    recording = _recording(model, _tone(3.0 / STAMP[-1], 2.0 * SIZE * np.array(sizes)))
    first = begun(first_look(WireStage([wire_span(recording, model)], model)))
    assert told_from_hum(first, lambda column: {}) is first


def test_sums_over_stretches_of_time_give_what_waves_near_by_share_with_signals() -> None:
    rng = np.random.default_rng(2)
    stamp = np.sort(rng.uniform(3.0, 63.0, 4000))
    stamp = stamp[(stamp < 20.0) | (stamp > 31.0)]  # a gap
    signals = rng.normal(size=(len(stamp), 3))
    band = Band.of(stamp, 2.5, signals[:, :1], signals[:, 1:])
    for frequency in (2.5, 2.5 - 16.5 / 60.0, 2.5 + 16.5 / 60.0):
        turn = 2 * np.pi * frequency * stamp
        np.testing.assert_allclose(
            band.at(frequency), np.stack([np.cos(turn), np.sin(turn)]) @ signals, atol=1e-9
        )


def test_mixtures_of_features_are_orthonormal_and_leave_out_what_others_say() -> None:
    rng = np.random.default_rng(3)
    features = rng.normal(size=(500, 4)) * [1e-6, 1.0, 1e5, 1.0]
    features[:, 3] = features[:, 1] - 2e6 * features[:, 0]
    mixed = features @ apart(features)
    assert mixed.shape == (500, 3)
    np.testing.assert_allclose(mixed.T @ mixed, np.eye(3), atol=1e-9)


@pytest.mark.parametrize(("times", "seen"), [(4.7, False), (10.0, True)])
def test_sizes_that_are_hardly_known_are_not_said_to_be_alike(times: float, seen: bool) -> None:
    """Strong physics that no feature says anything of: any sizes are alike beside it."""
    rest = SIZE / times * np.sqrt(len(STAMP) / 2.0)
    off = _tone(FREQUENCY, np.full(5, SIZE)) + rest * np.random.default_rng(6).standard_normal(
        (len(STAMP), 5)
    )
    still = 0.1 * np.sin(2 * np.pi * np.array([0.11, 0.13, 0.17, 0.19, 0.23]) * STAMP[:, None])
    found = tone(STAMP, off.T, still.T, lambda _: np.ones((len(STAMP), 1)), 2.0)
    assert (found is not None) == seen


def test_what_physics_lets_all_joints_do_is_no_tone_before_it_has_its_name(
    model: Model, tmp_path: Path
) -> None:
    """Joints that creep back by about one share of their positions, at places that come back slowly."""
    write_bag(drawn("pairs", 651_021).train, tmp_path / "arm", 0)
    first = begun(first_look(WireStage([wire_span(read_recording(tmp_path / "arm"), model)], model)))
    assert _tone_of(first.context, first.hypothesis, 0) is not None
    assert told_from_hum(first, lambda column: {}) is first
