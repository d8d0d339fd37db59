"""Predictions for recordings that have lost messages, and between the counts of an encoder."""

import dataclasses

import numpy as np
import pytest

from test.diagnosis.arms import recorded, reshaped
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.simulate import simulate

T = np.arange(0.0, 30.0, 0.01)
LOST = {"setpoints": (7.0, 8.3), "gearbox_states": (15.0, 16.4), "reference": (7.9, 8.1)}


@pytest.fixture(scope="module")
def model() -> Model:
    nominal = load_model("trunk")
    return dataclasses.replace(nominal, effects={"backlash": {"half_width": np.full(5, 2e-3)}})


@pytest.fixture(scope="module")
def whole(model) -> Recording:
    """All topics of a run without a compensator."""
    arm = model.arm
    asked = np.column_stack([0.3 * np.sin((0.5 + 0.1 * k) * T) * np.sin(0.21 * T) for k in range(5)])
    series = {
        "reference": JointSeries(T, arm.joints, asked * arm.ratio),
        "setpoints": JointSeries(T, arm.joints, asked),
    }
    empty = Recording("whole", 0, T[-1], series)
    driven = simulate(empty, model, "setpoints").series["gearbox_states"]
    return Recording("whole", 0, T[-1], series | {"gearbox_states": driven})


def thinned(whole: Recording, *topics: str) -> Recording:
    """Messages of these topics are lost for a while, joint_states ask for angles there as well."""
    series = dict(whole.series)
    for topic in topics:
        first, last = LOST[topic]
        series[topic] = series[topic].rows((first > T) | (last < T))
    joints = whole.series["gearbox_states"].joints
    series["joint_states"] = JointSeries(T, joints, np.full((len(T), len(joints)), np.nan))
    return dataclasses.replace(whole, series=series)


@pytest.mark.parametrize("source", ["setpoints", "gearbox_states"])
@pytest.mark.parametrize(
    "topics", [("setpoints",), ("gearbox_states",), ("setpoints", "gearbox_states", "reference")]
)
def test_messages_that_were_lost_hardly_change_what_is_predicted(whole, model, source, topics):
    lost = simulate(thinned(whole, *topics), model, source).series["joint_states"].position
    full = simulate(thinned(whole), model, source).series["joint_states"].position
    assert np.abs(lost - full).max() < 3e-3


def test_setpoints_that_were_lost_at_the_end_follow_the_reference(whole, model):
    series = dict(whole.series)
    series["setpoints"] = series["setpoints"].rows(T[-1] - 1.2 > T)
    cut = simulate(dataclasses.replace(whole, series=series), model, "setpoints").series["gearbox_states"]
    full = whole.series["gearbox_states"]
    np.testing.assert_allclose(cut.position[-1], full.position[-1], atol=3e-3)


def test_the_nominal_arm_is_the_formula_of_what_the_encoder_said(whole):
    nominal = load_model("trunk")
    gearbox = whole.series["gearbox_states"]
    step = 2 * np.pi / 2**12
    seen = dataclasses.replace(gearbox, position=np.round(gearbox.position / step) * step)
    said = simulate(Recording("seen", 0, T[-1], {"gearbox_states": seen}), nominal).series["joint_states"]
    play = seen.position[:1] * nominal.arm.ratio
    for u in seen.position * nominal.arm.ratio:
        play = np.append(
            play, [np.clip(play[-1], u - nominal.arm.dead_band, u + nominal.arm.dead_band)], axis=0
        )
    late = T > 3
    np.testing.assert_allclose(said.position[late], play[1:][late], atol=1e-12)


def test_a_fitted_model_is_run_between_the_encoder_s_counts(whole, model):
    gearbox = whole.series["gearbox_states"]
    step = 2 * np.pi / 2**14
    seen = dataclasses.replace(gearbox, position=np.round(gearbox.position / step) * step)

    def predicted(series: JointSeries) -> np.ndarray:
        recording = Recording("seen", 0, T[-1], {"gearbox_states": series})
        return np.asarray(simulate(recording, model).series["joint_states"].position)

    off = predicted(seen) - predicted(gearbox)
    counts = (seen.position - gearbox.position) * model.arm.ratio
    assert np.std(off[T > 3]) < 0.6 * np.std(counts[T > 3])


@pytest.mark.parametrize(
    ("kp", "stated", "led"),
    [(20.0, True, True), (17.0, True, False), (20.0, False, False)],
    ids=["the servo", "another servo", "of which nothing is said"],
)
def test_between_counts_the_shaft_goes_as_the_servo_does_if_that_passes_all_readings(
    whole, model, kp, stated, led
):
    believed = dataclasses.replace(model, arm=dataclasses.replace(model.arm, kp=kp, servo_stated=stated))
    gearbox = whole.series["gearbox_states"]
    step = 2 * np.pi / 2**14
    seen = dataclasses.replace(gearbox, position=np.round(gearbox.position / step) * step)

    def predicted(position: JointSeries, *others: str) -> np.ndarray:
        series = {key: whole.series[key] for key in others} | {"gearbox_states": position}
        said = simulate(Recording("seen", 0, T[-1], series), believed).series["joint_states"]
        return np.asarray(said.position)[T > 3]

    without, there = predicted(seen), predicted(seen, "setpoints")
    truth = predicted(gearbox)
    assert (np.std(there - truth) < 0.05 * np.std(without - truth)) == led
    assert np.std(there - truth) < 1.1 * np.std(without - truth)


def test_turns_of_a_gearbox_that_wraps_are_counted_on(whole, model):
    """Its sensor's range may end anywhere."""
    gearbox = whole.series["gearbox_states"]
    position = gearbox.position.copy()
    position[position[:, 1] > 0.1, 1] -= 2 * np.pi
    series = {**whole.series, "gearbox_states": dataclasses.replace(gearbox, position=position)}
    wrapped = simulate(dataclasses.replace(whole, series=series), model).series["joint_states"]
    right = simulate(whole, model).series["joint_states"]
    np.testing.assert_allclose(wrapped.position, right.position, atol=1e-9)


def test_what_is_predicted_from_setpoints_does_not_go_by_how_the_motors_went() -> None:
    """Of the load they are told the recorded torque at most: inertia is that of the course itself."""
    arm = dataclasses.replace(load_model("trunk").arm, load_from="weight_and_inertia")
    model = Model(arm, {"load_droop": {"gain": 0.02}})
    made = recorded(seconds=5.0)
    went = made.series["gearbox_states"]
    other = reshaped(made, "gearbox_states", position=2.0 * went.position)
    one, same = (simulate(each, model, "setpoints").series["gearbox_states"] for each in (made, other))
    assert same.position == pytest.approx(one.position, abs=1e-12)
