"""Claims about clocks and sensors: what they do is told from physics, put right, and said."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from test.concealed.awkward import Awkward, acting, spoiled
from test.concealed.draws import sign
from test.concealed.everyday import draw_motion
from test.concealed.masses import run_masses
from test.concealed.masses_arm import Arm, having, soft
from test.concealed.nominal import COMPLIANCE, JOINTS, RATIO
from test.concealed.sensing import Run, Sensing, record
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.data.repeated_readings import asked, holding, new_readings
from trunk_ros.data.sensing import clocks_put_right, readings_put_right
from trunk_ros.data.sensing.physics import Motion, beside_physics, fitted
from trunk_ros.data.sensing.skew import Skew, one_clock, skew, without_skew
from trunk_ros.data.sensing.sliding import Sliding, sliding, waited
from trunk_ros.data.sensing.steps import coarse_steps
from trunk_ros.data.sensing.thinned import _filled, how_far_off, thinned
from trunk_ros.data.sensing.wraps import TURN, unwrapped, whole_turns
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.diagnoser import Diagnoser
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.pace import paced, with_its_clocks
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.looked_again import told_from_clocks
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.model import Model, load_model
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.recording import JointSeries, Recording

EVERY = tuple(range(5))
WORN = soft(
    Arm(), EVERY, COMPLIANCE, 1.0
)  # sags before the stick, and is coupled and of another ratio besides
WORN = having(WORN, (0, 2), wheel=1.01, drag=2.0)


def _run(
    arm: Arm, kind: str = "mixed", wandering: bool = False, seconds: float = 40.0, phase: int = 2
) -> Run:
    rng = np.random.default_rng(7)
    reference = draw_motion(rng, kind, np.arange(round(seconds * 100), dtype=np.float64) * 0.01)
    setpoint = reference / RATIO
    motion = run_masses([(0.0, arm)], acting(rng, setpoint, wandering))
    return record(rng, kind, reference, setpoint, motion, Sensing(phase=phase))


def _recording(run: Run) -> Recording:
    begin = min(int(topic["stamp"][0]) for topic in run.topics.values())
    series = {
        key: JointSeries((topic["stamp"] - begin) * 1e-9, JOINTS, topic["position"])
        for key, topic in run.topics.items()
    }
    return Recording("made", begin, max(float(s.stamp[-1]) for s in series.values()), series)


def _spoiled(run: Run, kind: str, size: float = 1.0) -> Recording:
    return _recording(spoiled(np.random.default_rng(3), run, Awkward(kind, size)))


def _right(recording: Recording, model: Model) -> tuple[Recording, list[str]]:
    out = clocks_put_right(readings_put_right(recording, model), model)
    return out, [one.kind for one in out.observed]


@pytest.fixture(scope="module")
def model() -> Model:
    """The nominal one."""
    return load_model("trunk")


@pytest.fixture(scope="module")
def clean() -> Run:
    """A clean arm's recording, its joints read between the gearbox's readings."""
    return _run(Arm())


@pytest.fixture(scope="module")
def worn() -> Run:
    """That of an arm with a lot of physics."""
    return _run(WORN)


NONE = Hypothesis()


def _seen(recording: Recording, model: Model) -> Context:
    """The wires as they are first looked at."""
    return first_look(WireStage([wire_span(recording, model)], model))


def test_nothing_is_seen_where_nothing_is_wrong_with_clocks_and_sensors(
    clean: Run, worn: Run, model: Model
) -> None:
    for run in (clean, worn):
        before = _recording(run)
        after, kinds = _right(before, model)
        assert kinds == []
        assert after.series == before.series


@pytest.mark.parametrize("ppm", [-500.0, 100.0])
def test_skew_is_measured_on_a_clean_arm_and_on_one_with_physics(
    clean: Run, worn: Run, model: Model, ppm: float
) -> None:
    for run in (clean, worn):
        right, kinds = _right(_spoiled(run, "skew", ppm), model)
        assert kinds == ["skew"]
        (seen,) = right.observed
        assert seen.corrected
        assert seen.std is not None
        assert seen.std < (1.0 if run is clean else 10.0)
        assert seen.value == pytest.approx(ppm, abs=2.0 * seen.std + 1.0)
        off = right.series["joint_states"].stamp - _recording(run).series["joint_states"].stamp
        assert np.abs(off).max() < 0.1 * abs(ppm) * 1e-6 * 40.0 + 1.5e-4


def test_skew_is_measured_beside_a_dead_band_far_wider_than_the_models(model: Model) -> None:
    loose = replace(Arm(), capstan=5.0 * Arm().capstan)
    right, kinds = _right(_spoiled(_run(loose), "skew", -100.0), model)
    assert kinds == ["skew"]
    assert right.observed[0].value == pytest.approx(-100.0, abs=10.0)


def test_physics_that_clocks_are_told_from_has_the_models_dead_band_however_narrow(model: Model) -> None:
    """A fast motion over dead bands of 0.4 mrad, which had been taken for 1 mrad: 73 ppm."""
    stamp = np.arange(6000) * 0.01
    moved = 0.25 * np.sin(0.3 * stamp + 0.02 * stamp**2)[:, None] * np.ones(5)
    wide = model.arm.dead_band
    assert (wide < 1e-3).all()
    shown, _ = SharpPlay().run(moved, wide[None], None)
    motion = Motion(stamp, moved, np.gradient(moved, stamp, axis=0), shown, model.arm)
    for joint in range(5):
        features = beside_physics(motion, joint)
        left = motion.off[:, joint] - features @ fitted(features, motion.off[:, joint])[0]
        assert np.abs(left).max() < 1e-2 * wide[joint]


@pytest.mark.parametrize("delay", [0.0, 8e-3])
def test_the_pace_of_clocks_that_differ_is_estimated_with_the_physics(
    clean: Run, model: Model, delay: float
) -> None:
    """A lag that has no name as yet is no pace."""
    told = replace(_right(_spoiled(clean, "skew", 100.0), model)[0].observed[0], std=20.0)
    off = _recording(clean)
    late = without_skew(off.series["joint_states"], Skew(-15e-6, 0.0))
    late = replace(late, stamp=late.stamp + delay)
    found = paced(
        _seen(replace(off, observed=(told,), series={**off.series, "joint_states": late}), model), NONE
    )
    assert found.views[0].span.pace[0] == pytest.approx(15e-6, abs=2e-6)
    assert paced(found, NONE) is found
    alone = _seen(off, model)
    assert paced(alone, NONE) is alone


@pytest.mark.long
@pytest.mark.parametrize("delay", [0.0, 1e-3])
def test_a_skew_that_only_shows_beside_the_physics_is_told_from_a_late_sensor(
    clean: Run, model: Model, delay: float
) -> None:
    """2 ppm, less than a tenth of a millisecond at the end; and one that is late, of clocks that agree."""
    recording = _recording(clean)
    shown = recording.series["joint_states"]
    stamp = shown.stamp + delay if delay else shown.stamp * (1.0 + 2e-6)
    recording = replace(recording, series={**recording.series, "joint_states": replace(shown, stamp=stamp)})
    assert _right(recording, model)[1] == []
    result = Diagnoser([recording], model, None, lambda _: None, experiments=False).run()
    assert [f.effect for f in result.findings] == (["sensor_delay"] if delay else [])
    observed = result.quality["made"]["observed"]
    assert [(one["kind"], one["corrected"]) for one in observed] == ([] if delay else [("skew", True)])
    assert delay or observed[0]["value"] == pytest.approx(2.0, abs=3 * observed[0]["std"])


def test_what_comes_in_steps_gives_way_to_a_skew(clean: Run, model: Model) -> None:
    """12 ppm, which friction that fades in steps had imitated."""
    recording = _recording(clean)
    shown = recording.series["joint_states"]
    off = replace(shown, stamp=shown.stamp * (1.0 + 12e-6))
    recording = replace(recording, series={**recording.series, "joint_states": off})
    span = with_its_clocks(wire_span(recording, model), recording, model)
    first = begun(first_look(WireStage([span], model)))
    moments = {"factor": 0.99, "from_2": 20.0, "times_2": 3.0, "from_3": 40.0, "times_3": 5.0}
    fades = Term("tension_error", shared=moments, own={c: {} for c in range(5)})
    steps = refit(first.context, Hypothesis({"tension_error": fades}))
    assert steps.total < first.total
    found = told_from_clocks(steps)
    assert not found.hypothesis
    assert found.context.views[0].span.pace[0] == pytest.approx(12e-6, abs=2e-6)


def test_friction_that_grows_is_no_skew(model: Model) -> None:
    arm = soft(replace(Arm(), balanced=True), EVERY, COMPLIANCE, 1.0)
    grown = [
        (float(t), replace(arm, joint=arm.joint * (1 + 3 * t / 40.0))) for t in np.arange(0.0, 40.0, 0.5)
    ]
    rng = np.random.default_rng(7)
    reference = draw_motion(rng, "mixed", np.arange(4000, dtype=np.float64) * 0.01)
    motion = run_masses(grown, np.repeat(reference / RATIO, 5, axis=0))
    run = record(rng, "mixed", reference, reference / RATIO, motion, Sensing(phase=2))
    assert _right(_recording(run), model)[1] == []


def test_stamps_of_one_clock_have_no_skew(model: Model) -> None:
    stamp = np.arange(1000.0) * 0.01
    assert one_clock(stamp, stamp[::4])
    assert not one_clock(stamp, stamp * (1 + 1e-4) + 1e-4)
    angles = np.sin(stamp)[:, None] * np.ones(5)
    one = JointSeries(stamp, JOINTS, angles)
    late = JointSeries(stamp, JOINTS, np.sin(stamp * (1 - 1e-3))[:, None] * np.ones(5) * RATIO)
    assert skew(one, late, model.arm) is None
    np.testing.assert_allclose(without_skew(late, Skew(1e-3, 0.0)).stamp, stamp / 1.001)


def _skew_of_late(
    model: Model, stamp: np.ndarray, moved: Callable[[np.ndarray], np.ndarray], late: np.ndarray, noise: float
) -> Skew | None:
    """The skew that is told of joints that move so many s ``late`` behind their gearboxes."""
    times, rng = stamp[:, None], np.random.default_rng(5)
    shown = moved(times - late) + noise * rng.standard_normal((len(stamp), 5))
    gearbox = JointSeries(stamp, JOINTS, moved(times) / model.arm.ratio)
    return skew(gearbox, JointSeries(stamp + 0.004, JOINTS, shown), model.arm)


@pytest.mark.parametrize("own_lags", [False, True])
def test_joints_that_move_in_turn_tell_of_skew_together(model: Model, own_lags: bool) -> None:
    """45 ppm that no joint sees much of by itself; lags of their own are no clock's."""
    stamp = np.arange(12000) * 0.01
    begins = 24.0 * np.arange(5)
    late = 1e-3 * np.array([0.4, 3.1, 1.2, 4.4, 0.9]) if own_lags else 45e-6 * np.ones(5)

    def moved(t: np.ndarray) -> np.ndarray:
        return np.asarray(0.6 * np.sin(2 * np.pi * 2 / 24.0 * np.clip(t - begins, 0.0, 24.0)))

    off = late if own_lags else late * stamp[:, None]
    found = _skew_of_late(model, stamp, moved, off, 7e-5)
    if own_lags:
        assert found is None
    else:
        assert found is not None
        assert abs(found.rate - 45e-6) < 4.0 * found.std < 20e-6


@pytest.mark.parametrize("own_lags", [False, True])
def test_joints_that_mostly_rest_tell_of_skew_together(model: Model, own_lags: bool) -> None:
    """Moves at three times do not tell in which way a lag grows; one that grows by joint is no clock's."""
    stamp = np.arange(6000) * 0.01
    pace = 72e-6 * (np.array([0.2, 1.5, 0.6, 2.2, 0.5]) if own_lags else np.ones(5))
    size = np.array([0.03, 0.06, -0.05, 0.07, -0.06])

    def moved(t: np.ndarray) -> np.ndarray:
        began = np.array([11.0, 41.0, 52.0])[:, None, None]
        return np.asarray(size * np.sum(1.0 - np.cos(np.pi * np.clip(t - began, 0.0, 4.0)), axis=0))

    found = _skew_of_late(model, stamp, moved, pace * stamp[:, None], 6e-5)
    if own_lags:
        assert found is None
    else:
        assert found is not None
        assert abs(found.rate - 72e-6) < 4.0 * found.std < 40e-6


def test_thinned_setpoints_are_filled_in_and_others_are_not(clean: Run, model: Model) -> None:
    right, kinds = _right(_spoiled(clean, "thinned"), model)
    assert kinds == ["thinned"]
    whole, seen = _recording(clean).series["setpoints"], right.series["setpoints"]
    assert right.observed[0].value == 4
    both = np.isin(np.round(whole.stamp, 6), np.round(seen.stamp, 6))
    there = np.isin(np.round(seen.stamp, 6), np.round(whole.stamp, 6))
    np.testing.assert_allclose(seen.position[there], whole.position[both], atol=1e-4)
    assert there.sum() > 0.98 * len(whole.stamp)


@pytest.mark.parametrize("rough", [0.0, 2e-3])
def test_what_was_filled_in_is_known_as_well_as_those_that_were_kept_tell(model: Model, rough: float) -> None:
    """Of setpoints that move smoothly, and of such as a hand on a stick makes; a reference tells all."""
    rng, stamp = np.random.default_rng(0), np.arange(6000) * 0.01
    path = 0.4 * np.sin(0.5 * stamp)[:, None] * np.ones(5)
    hand = lfilter([0.1], [1.0, -0.9], rng.standard_normal((6000, 5)), axis=0)
    path = path + rough * lfilter([0.3], [1.0, -0.7], hand, axis=0)
    kept, whole = JointSeries(stamp[::4], JOINTS, path[::4]), JointSeries(stamp, JOINTS, path)
    filled = _filled(kept, 4, None)
    told = Observed("thinned", "trunk/setpoints", JOINTS, 4, None, "1", True, (), "")
    run = Recording("made", 0, 60.0, {"setpoints": filled}, observed=(told,))
    off = np.sqrt(np.mean((filled.position - path[: len(filled.stamp)]) ** 2, axis=0))
    said = how_far_off([run], JOINTS)
    assert np.all((said > 0.6 * off) & (said < max(3.0 * off.max(), 1e-6)))
    assert not how_far_off([replace(run, series={**run.series, "reference": whole})], JOINTS).any()


def test_without_a_reference_the_rate_is_that_of_the_gearbox(clean: Run, model: Model) -> None:
    series = _spoiled(clean, "thinned").series
    found = thinned(series["setpoints"], series["gearbox_states"], model)
    assert found is not None
    assert found.times in (3, 4)


def test_thinned_setpoints_are_told_of_servos_that_are_not_the_nominal_ones(model: Model) -> None:
    """What such a servo is off by is larger than the stairs."""
    run = _spoiled(_run(Arm()), "thinned").series
    slower = replace(model, arm=replace(model.arm, kp=0.4 * model.arm.kp))
    found = thinned(run["setpoints"], run["gearbox_states"], slower, run["reference"])
    assert found is not None
    assert found.times == 4


def test_thinned_setpoints_are_told_where_they_came_unevenly(clean: Run, model: Model) -> None:
    """As a logger that sleeps between two of them keeps them: its phase wanders through all of them."""
    series = _recording(clean).series
    stamp, at = series["setpoints"].stamp, np.arange(0.0, 39.0, 0.0404)
    rows = np.unique(np.searchsorted(stamp, at))
    found = thinned(series["setpoints"].rows(rows), series["gearbox_states"], model, series["reference"])
    assert found is not None
    assert found.times == 4


@pytest.mark.parametrize("gain", [1.0, 4.0])
def test_setpoints_that_did_come_so_rarely_are_left_alone(model: Model, gain: float) -> None:
    rng = np.random.default_rng(7)
    reference = draw_motion(rng, "mixed", np.arange(3000, dtype=np.float64) * 0.01)
    held = np.repeat(reference[::4], 4, axis=0)[: len(reference)] / RATIO
    motion = run_masses([(0.0, Arm())], np.repeat(held, 5, axis=0))
    run = record(rng, "mixed", reference, held, motion, Sensing())
    series = _recording(run).series
    kept = series["setpoints"].rows(np.arange(len(held)) % 4 == 0)
    quicker = replace(model, arm=replace(model.arm, kp=gain * model.arm.kp))
    assert thinned(kept, series["gearbox_states"], quicker) is None


@pytest.mark.parametrize("kind", ["mixed", "pick_and_place", "one_by_one"])
def test_a_latency_that_slides_is_taken_out_but_for_its_mean(model: Model, kind: str) -> None:
    recording = _recording(_run(WORN, kind, wandering=True))
    right, kinds = _right(recording, model)
    assert kinds == ["wandering_latency"]
    assert right.observed[0].value == pytest.approx(0.01)
    assert np.ptp(right.series["setpoints"].stamp - recording.series["setpoints"].stamp[:1]) > 0
    assert (np.diff(right.series["setpoints"].stamp) > 0).all()


def test_a_latency_that_slides_is_followed_from_few_motions(model: Model) -> None:
    """An arm that mostly rests shows few of its teeth; how long one takes is that of what was drawn."""
    rng, drawn = np.random.default_rng(16), np.random.default_rng(16)
    slower = float(drawn.uniform(1e-3, 6e-3)) * sign(drawn)
    reference = draw_motion(rng, "resting", np.arange(6000, dtype=np.float64) * 0.01)
    motion = run_masses([(0.0, Arm())], acting(np.random.default_rng(16), reference / RATIO, True))
    run = record(rng, "resting", reference, reference / RATIO, motion, Sensing(phase=2))
    series = _recording(run).series
    found = sliding(series["setpoints"], series["gearbox_states"], model)
    assert found is not None
    assert found.takes == pytest.approx(0.01 * (1.0 + slower) / slower, rel=1e-3)
    assert abs(found.phase - round(found.phase)) < 0.01


@pytest.mark.parametrize(
    ("arm", "kind"),
    [(Arm(gain=1.13), "fast"), (replace(soft(Arm(), EVERY, COMPLIANCE, 1.0), gives=80.0), "mixed")],
)
def test_a_latency_that_slides_is_seen_beside_other_gains_and_loads(
    model: Model, arm: Arm, kind: str
) -> None:
    """The loops round its teeth, and what the weight does is not the angle's sine alone."""
    series = _recording(_run(arm, kind, wandering=True, seconds=60.0)).series
    found = sliding(series["setpoints"], series["gearbox_states"], model)
    assert found is not None
    drawn = np.random.default_rng(7)
    draw_motion(drawn, kind, np.arange(6000, dtype=np.float64) * 0.01)
    slower = float(drawn.uniform(1e-3, 6e-3)) * sign(drawn)
    assert found.takes == pytest.approx(0.01 * (1.0 + slower) / slower, rel=0.02)


def test_a_slow_servo_does_not_slide(model: Model) -> None:
    series = _recording(_run(replace(Arm(), gain=0.8))).series
    assert sliding(series["setpoints"], series["gearbox_states"], model) is None


def test_waits_are_a_saw_about_their_mean() -> None:
    stamp = np.arange(500.0) * 0.01
    found = Sliding(1.7, 0.3, 0.01)
    waits = found.waits(stamp)
    assert waits.min() >= 0.0
    assert waits.max() < 0.01
    moved = waited(JointSeries(stamp, ("a",), stamp[:, None]), found)
    off = moved.stamp - moved.position[:, 0]
    assert abs(off.mean()) < 1e-3
    assert np.abs(off).max() <= 0.005 + 1e-12


@pytest.mark.parametrize("period", [0.021, 0.0335, 0.0477])
def test_latched_readings_get_the_time_at_which_they_were_read(model: Model, period: float) -> None:
    run = _run(Arm(), phase=0)
    right, kinds = _right(_spoiled(run, "latched", period), model)
    assert kinds == ["repeats"]
    apart = np.diff(right.series["joint_states"].stamp)
    assert np.median(apart) == pytest.approx(period, rel=1e-4)
    assert np.mean(np.abs(apart - period) < 1e-4) > 0.97
    said = right.series["joint_states"]
    t = np.arange(len(run.theta_clean)) * 0.01
    lags = np.arange(0.0, 0.03, 5e-4)
    off = [
        np.abs(said.position[:, 0] - np.interp(said.stamp - lag, t, run.theta_clean[:, 0])).mean()
        for lag in lags
    ]
    assert min(off) < 2e-4  # a constant age is all that is left, beside noise of 1e-4


def test_even_stamps_and_uneven_sensors_stay_as_they_are() -> None:
    even = np.arange(200.0) * 0.03
    np.testing.assert_array_equal(asked(even, 0.03, 0.01), even)
    uneven = np.cumsum(np.random.default_rng(1).uniform(0.02, 0.06, 200))
    np.testing.assert_array_equal(asked(uneven, 0.04, 0.01), uneven)


def test_turns_are_counted_on_and_fast_joints_are_left_alone(model: Model) -> None:
    angle = np.linspace(0.0, 12.0, 500)
    out, times = unwrapped((angle + np.pi) % TURN - np.pi)
    np.testing.assert_allclose(out, angle)
    assert times == 2
    assert unwrapped(np.cumsum(np.full(50, 2.5)) % TURN)[1] == 0  # nobody can count those
    assert unwrapped(np.array([0.0, 6.28]))[1] == 0  # nor tell whether these two are one turn
    gap = (angle + np.pi) % TURN - np.pi
    gap[100:110] = np.nan
    np.testing.assert_allclose(unwrapped(gap)[0][110:], angle[110:])
    assert whole_turns(np.full(9, TURN + 0.1)) == TURN
    assert whole_turns(np.full(9, 2.0)) == 0.0


def test_a_wrapped_joint_is_that_of_an_encoder_without_end(model: Model) -> None:
    run = _run(Arm(), "turning", phase=0)
    right, kinds = _right(_spoiled(run, "wrapped"), model)
    assert kinds == ["wrap"]
    np.testing.assert_allclose(right.series["joint_states"].position, run.theta_clean, atol=1e-3)


def test_coarse_encoders_on_resting_joints_are_named(model: Model) -> None:
    run = _run(Arm(), "resting", seconds=60.0)
    step = 2 * np.pi / 2**12
    recording = _spoiled(run, "coarse", step)
    right, kinds = _right(recording, model)
    assert kinds == ["steps"]
    assert right.observed[0].value == pytest.approx(step)
    assert not right.observed[0].corrected
    series = _recording(run).series
    assert coarse_steps(series["gearbox_states"], series["joint_states"], model.arm) == {}


def test_repeats_are_left_out_of_all_joints_alike(model: Model) -> None:
    held = _spoiled(_run(Arm(), phase=0), "latched", 0.04).series["joint_states"]
    new, period = new_readings(held)
    assert period == pytest.approx(0.04, abs=1e-6)
    assert len(new.stamp) == pytest.approx(len(held.stamp) / 4, rel=0.02)
    position = held.position.copy()
    position[:, 2] = np.nan  # a dead sensor hides nothing of the others
    assert new_readings(replace(held, position=position))[1] == period


def _polled_in_turn(run: Run, period: float) -> Recording:
    """Each joint is read every ``period`` s, one after the other, with noise and counts of 1e-4 rad."""
    recording = _recording(run)
    shown = recording.series["joint_states"]
    position, t = shown.position.copy(), np.arange(len(run.theta_clean)) * 0.01
    for j, angle in enumerate(run.theta_clean.T):
        late = period * j / len(JOINTS)
        number = np.maximum(np.floor((shown.stamp - late) / period), 0.0).astype(int)
        noise = np.random.default_rng(j).normal(0.0, 1e-4, number[-1] + 1)[number]
        position[:, j] = np.round((np.interp(number * period + late, t, angle) + noise) / 1e-4) * 1e-4
    changed = {**recording.series, "joint_states": replace(shown, position=position)}
    return replace(recording, series=changed)


@pytest.mark.parametrize("period", [0.0617, 0.1003])
def test_joints_that_are_read_in_turn_are_brought_to_one_time(model: Model, period: float) -> None:
    """A joint's reading that is no news had counted as new where another joint had one."""
    run = _run(Arm(), phase=0, seconds=90.0)
    recording = _polled_in_turn(run, period)
    right, kinds = _right(recording, model)
    shown = right.series["joint_states"]
    assert kinds == ["repeats"]
    assert "Joints are read in turn" in right.observed[0].statement
    assert len(shown.stamp) == pytest.approx(90.0 / period, rel=0.1)
    t = np.arange(len(run.theta_clean)) * 0.01
    for column, angle in zip(shown.position.T, run.theta_clean.T, strict=True):
        off = np.abs(column - np.interp(shown.stamp, t, angle))
        assert np.nanmedian(off) < 3e-4
        assert np.nanquantile(off, 0.95) < 2e-3  # what was interpolated on a fast way
    result = Diagnoser([recording], model, None, lambda _: None, experiments=False).run()
    assert result.findings == []


def test_a_joint_that_rests_on_a_count_hides_no_repeats_of_the_others(model: Model) -> None:
    held = _spoiled(_run(Arm(), phase=0), "latched", 0.04).series["joint_states"]
    position = held.position.copy()
    position[:, 2] = 1e-3 * np.round(1.4 * position[:, 2] / np.ptp(position[:, 2]))
    assert 2 <= len(np.unique(position[:, 2])) <= 3
    new, period = new_readings(replace(held, position=position))
    assert period == pytest.approx(0.04, abs=1e-6)
    assert len(new.stamp) < len(held.stamp) / 3


@pytest.mark.parametrize("rate", [14.0, 37.0, 40.0, 61.0], ids=lambda rate: f"{rate:g}_hz")
def test_a_sensor_of_any_pace_below_its_topics_is_seen_to_repeat_itself(rate: float) -> None:
    stamp = np.arange(0.0, 60.0, 0.01)
    read = np.floor(stamp * rate) / rate
    shown = 0.4 * np.sin(1.3 * read) + 0.1 * np.sin(2.3 * read)
    assert holding(stamp, shown) == pytest.approx(1.0 / rate, abs=0.006)


def _posture_after_posture(stamp: Array) -> Array:
    """(n,) rad: every 4 s the joint goes to another posture, smoothly, and rests there."""
    posture = np.random.default_rng(2).uniform(-0.2, 0.2, int(stamp[-1] / 4.0) + 2)
    number = (stamp / 4.0).astype(int)
    done = np.clip(stamp / 4.0 - number, 0.0, 0.7) / 0.7
    return np.asarray(posture[number] + np.diff(posture)[number] * done**2 * (3.0 - 2.0 * done))


def _polled(stamp: Array, angle: Array, period: float, late: float) -> Array:
    """(n,) rad: the angle as a sensor shows it that is read every ``period`` s, in counts of 0.01 degrees."""
    read = np.maximum(np.floor((stamp - late) / period) * period + late, 0.0)
    return np.asarray(np.round(np.interp(read, stamp, angle) / np.deg2rad(0.01)) * np.deg2rad(0.01))


@pytest.mark.parametrize("period", [0.06, 0.1, 0.15])
def test_a_coarse_sensor_with_a_clock_repeats_its_readings_near_rest_as_well(period: float) -> None:
    """There the next count takes several periods, as it does with an encoder."""
    stamp = np.arange(0.0, 120.0, 0.02)
    shown = _polled(stamp, _posture_after_posture(stamp), period, 0.03)
    assert holding(stamp, shown) == pytest.approx(period, abs=0.002)


@pytest.mark.parametrize("period", [0.02, 0.1])
@pytest.mark.parametrize("step", [1e-4, 1e-3, 4e-3])
def test_stairs_of_an_encoder_are_no_clock_whatever_the_motion(period: float, step: float) -> None:
    stamp = np.arange(0.0, 120.0, period / 5)
    angle = _posture_after_posture(stamp)
    assert holding(stamp, np.round(angle / step) * step) == 0.0
    steady = np.abs(np.mod(step / period * stamp, 0.5) - 0.25)  # a count in each period
    assert holding(stamp, np.round(steady / step) * step) == 0.0
    sticks = np.round(angle / 0.02) * 0.02  # goes on in jumps, with noise
    noise = np.random.default_rng(0).normal(0.0, step, len(stamp))
    assert holding(stamp, np.round((sticks + noise) / step) * step) == 0.0


@pytest.mark.parametrize("step", [3e-4, 1e-3, 1e-2], ids=lambda step: f"{step:g}_rad")
def test_a_coarse_sensor_repeats_nothing(step: float) -> None:
    stamp = np.arange(0.0, 60.0, 0.01)
    angle = 0.4 * np.sin(1.3 * stamp) + 0.1 * np.sin(2.3 * stamp)
    noise = np.random.default_rng(0).normal(0.0, 3e-4, len(stamp))
    assert holding(stamp, np.round((angle + noise) / step) * step) == 0.0


@pytest.mark.parametrize("slow", [0.3, 0.5, 0.7])
def test_a_coarse_sensor_that_moves_slowly_for_a_while_repeats_nothing(slow: float) -> None:
    """Steps: fast and slow ways one after the other, without noise."""
    fast = (np.arange(6000) // 500) % 2 == 0
    counts = np.cumsum(np.where(fast, 6.3, slow))
    assert holding(0.01 * np.arange(6000.0), np.floor(counts)) == 0.0
