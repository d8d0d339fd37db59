"""Servos of which nothing is said, and servos that differ from joint to joint."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, of_joints
from test.test_servo import STEP, reference
from trunk_ros.compiled import Array
from trunk_ros.data.align import servo_span
from trunk_ros.diagnosis import Diagnosis
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.servos.nominal_servo import _like_others, with_its_servo
from trunk_ros.diagnosis.servos.servo_loop import Loop
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.simulate import simulate

PERIOD = 0.01  # s between setpoints
NOISE = 5e-5  # rad
JOINTS = ("shoulder", "elbow", "wrist")
PLAIN: dict[str, tuple[float, float, float]] = {
    "kp": (20.0, 20.0, 20.0), "tau_v": (0.02, 0.02, 0.02), "v_max": (5.0, 5.0, 5.0), "delay": (0.0, 0.0, 0.0)
}  # fmt: skip
OWN: dict[str, tuple[float, float, float]] = {
    "kp": (12.0, 30.0, 60.0),
    "tau_v": (0.01, 0.03, 0.005),
    "v_max": (9.0, 0.6, 9.0),
    "delay": (0.0, 0.008, 0.02),
}


def _path(asked: Array, kp: float, tau_v: float, v_max: float, delay: float) -> Array:
    """Angles (m,) each 2 ms under setpoints (n,) that come late, and stay at the last one for a second."""
    rows = np.arange(int((len(asked) * PERIOD + 1.0) / STEP)) - round(delay / STEP)
    held = np.clip(rows // round(PERIOD / STEP), 0, len(asked) - 1)
    return reference(asked[held], 1, kp, tau_v, v_max)


def _asked(t: Array, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    out = np.zeros((len(t), len(JOINTS)))
    for j in range(len(JOINTS)):
        for frequency in rng.uniform(0.05, 0.5, 5):
            out[:, j] += rng.uniform(0.1, 0.4) * np.sin(2 * np.pi * frequency * t + rng.uniform(0, 6))
    out *= np.clip(t / 2, 0.0, 1.0)[:, None]
    out[len(t) // 2 : len(t) // 2 + 300] += 0.3
    return out


def recorded_servos(
    servo: dict[str, tuple[float, float, float]],
    seed: int = 1,
    pulled: float = 0.0,
    after: float = 0.004,
    seconds: float = 10.0,
) -> Recording:
    """``pulled``: rad per rad that a spring at the shoulder's motor pulls it off its setpoint; ``after``: s
    between a setpoint and the next reading.
    """
    t = np.arange(0.0, seconds, PERIOD)
    asked, rng = _asked(t, seed), np.random.default_rng(seed)
    shown = t + after
    went = np.empty_like(asked)
    for j in range(len(JOINTS)):
        kp, tau_v, v_max, delay = (servo[name][j] for name in ("kp", "tau_v", "v_max", "delay"))
        path = _path(asked[:, j] * (1.0 - pulled * (j == 0)), kp, tau_v, v_max, delay)
        went[:, j] = np.interp(shown, STEP * np.arange(len(path)), path)
    went += NOISE * rng.standard_normal(went.shape)
    series = {"setpoints": JointSeries(t, JOINTS, asked), "gearbox_states": JointSeries(shown, JOINTS, went)}
    return Recording("servos", 0, float(shown[-1]), series)


def stiff() -> Recording:
    """One joint whose servo is nearly where it is asked to be at each moment."""
    gains = {"kp": (200.0,) * 3, "tau_v": (2e-3,) * 3}
    return of_joints(recorded_servos(PLAIN | gains, after=0.0, seconds=5.0), JOINTS[0])


def _stated(**servo: object) -> Model:
    flat = {
        f"servo.{name}": value for name, value in {"kp": 20.0, "tau_v": 0.02, "v_max": 5.0, **servo}.items()
    }
    return Model.from_parameters(
        {"arm.joints": list(JOINTS), "wire.ratio": [1.0], "wire.dead_band": [0.0], **flat}
    )


def _left(model: Model, recording: Recording) -> Array:
    """(joints,) rms of measured less predicted, once the servos have settled [rad]."""
    there = simulate(recording, model, "setpoints").series["gearbox_states"].position
    off = there - recording.series["gearbox_states"].position
    return np.asarray(np.sqrt(np.mean(off[100:] ** 2, axis=0)))


@pytest.fixture(scope="module")
def of_nobody() -> Diagnosis:
    """What is found on servos of which nothing is said."""
    return diagnose(recorded_servos(OWN), model="direct")


def test_servos_of_which_nothing_is_said_are_no_mismatch(of_nobody: Diagnosis) -> None:
    assert (of_nobody.verdict, of_nobody.findings) == ("no_mismatch", [])


def test_they_are_found_joint_by_joint(of_nobody: Diagnosis) -> None:
    arm = of_nobody.model.arm
    np.testing.assert_allclose(arm.kp, OWN["kp"], rtol=0.1)
    np.testing.assert_allclose(arm.tau_v, OWN["tau_v"], rtol=0.1)
    np.testing.assert_allclose(arm.delay, OWN["delay"], atol=1e-3)
    assert np.asarray(arm.v_max)[1] == pytest.approx(OWN["v_max"][1], rel=0.01)


def test_their_model_predicts_another_motion(of_nobody: Diagnosis, tmp_path: object) -> None:
    path = f"{tmp_path}/model.yaml"
    save_model(of_nobody.model, path)
    assert _left(load_model(path), recorded_servos(OWN, seed=2)).max() < 2 * NOISE


def test_what_no_such_loop_does_is_found_beyond_it() -> None:
    found = diagnose(of_joints(recorded_servos(OWN, pulled=0.01), *JOINTS[:2]), model="direct")
    assert found.findings
    assert {joint for finding in found.findings for joint in finding.joints} == {"shoulder"}


def test_setpoints_sampled_beside_the_shaft_move_on_between_the_samples() -> None:
    """A table of what was asked every 20 ms, of a servo that got a new setpoint every 10 ms."""
    whole = stiff()
    asked, went = whole.series["setpoints"], whole.series["gearbox_states"]
    some = np.arange(0, len(asked.stamp), 2)
    thin = replace(whole, series={"setpoints": asked.rows(some), "gearbox_states": went.rows(some)})
    found = diagnose(thin, model="direct").model
    assert found.setpoints == "sampled"
    held = diagnose(whole, model="direct").model
    assert held.setpoints == "held"


def test_a_drive_that_is_fed_the_speed_of_its_profile_is_found_so_and_predicted_elsewhere() -> None:
    """A table of a profile that moves on between its rows, and of a shaft that is ahead of it."""

    def table(seed: int) -> Recording:
        t = np.arange(0.0, 8.0, STEP)
        kp, share, slow = 40.0, 1.2, 0.3 + 0.1 * seed
        asked = 0.5 * (1.0 - np.cos(slow * t) * np.cos(6.0 * t))[:, None]
        fed = asked[:, 0] + share / kp * np.gradient(asked[:, 0], STEP)
        went = np.array(reference(fed, 1, kp, 5e-3, 9.0))[:, None]
        went = went + NOISE * np.random.default_rng(seed).standard_normal(went.shape)
        some = np.arange(0, len(t), round(PERIOD / STEP))
        series = {
            "setpoints": JointSeries(t[some], JOINTS[:1], asked[some]),
            "gearbox_states": JointSeries(t[some], JOINTS[:1], went[some]),
        }
        return Recording("profile", 0, float(t[-1]), series)

    found = diagnose(table(1), model="direct")
    assert found.findings == []
    assert float(found.model.arm.feedforward[0]) == pytest.approx(1.2, abs=0.05)
    assert _left(found.model, table(2)).max() < 2 * NOISE


@pytest.mark.parametrize(
    ("name", "servo", "effect", "expected"),
    [
        ("gain", {"kp": (15.0, 20.0, 28.0)}, "servo_bandwidth", {"shoulder": -0.25, "wrist": 0.4}),
        ("age", {"delay": (0.0, 0.02, 0.0)}, "servo_delay", {"elbow": 0.02}),
        ("top speed", {"v_max": (5.0, 0.6, 5.0)}, "velocity_saturation", {"elbow": 0.6}),
    ],
)
def test_stated_servos_that_differ_from_joint_to_joint_are_named_so(
    name: str,
    servo: dict[str, tuple[float, float, float]],
    effect: str,
    expected: dict[str, float],
) -> None:
    (finding,) = diagnose(recorded_servos(PLAIN | servo), model=_stated()).findings
    assert (finding.effect, finding.evidence["form"]) == (effect, "apart"), name
    for joint, value in expected.items():
        (said,) = finding.parameters[joint].values()
        assert said["value"] == pytest.approx(value, rel=0.02)


def test_a_model_may_state_the_servo_of_each_joint() -> None:
    model = _stated(
        kp=list(OWN["kp"]), tau_v=list(OWN["tau_v"]), v_max=list(OWN["v_max"]), delay=list(OWN["delay"])
    )
    assert diagnose(recorded_servos(OWN), model=model).findings == []
    assert Model.from_parameters(model.parameters()).parameters() == model.parameters()
    assert model.only(JOINTS[1:]).arm.kp.tolist() == list(OWN["kp"][1:])  # type: ignore[union-attr]


def test_a_servo_is_that_of_its_joint_and_one_that_was_not_asked_to_move_is_left_as_it_is() -> None:
    """An arm of five joints, in another order, of which three were recorded and two were asked to move."""
    names = ["base", "wrist", "elbow", "shoulder", "tool"]
    flat = {"arm.joints": names, "wire.ratio": [1.0], "wire.dead_band": [0.0]}
    whole = recorded_servos(OWN)
    still = whole.series["setpoints"].position.copy()
    still[:, 1] = still[0, 1]
    rest = whole.series["gearbox_states"].position.copy()
    rest[:, 1] = still[0, 1] + NOISE * np.random.default_rng(5).standard_normal(len(rest))
    series = {
        "setpoints": replace(whole.series["setpoints"], position=still),
        "gearbox_states": replace(whole.series["gearbox_states"], position=rest),
    }
    found = diagnose(replace(whole, series=series), model=Model.from_parameters(flat)).model
    np.testing.assert_allclose(found.arm.kp, [20.0, 60.0, 20.0, 12.0, 20.0], rtol=0.1)
    assert np.asarray(found.arm.v_max)[[0, 2, 4]].tolist() == [1.5] * 3
    assert Model.from_parameters(found.parameters()).parameters() == found.parameters()


def test_a_top_speed_that_was_not_met_is_not_claimed() -> None:
    """The shoulder creeps, the elbow runs into its limit, the wrist is faster than the model has it."""
    whole = recorded_servos(OWN)
    size = np.array([0.002, 1.0, 1.0])
    series = {
        "setpoints": _scaled(whole.series["setpoints"], size),
        "gearbox_states": _scaled(whole.series["gearbox_states"], size),
    }
    top = np.asarray(diagnose(replace(whole, series=series), model="direct").model.arm.v_max)
    assert top[0] == 1.5
    assert top[1] == pytest.approx(OWN["v_max"][1], rel=0.01)
    asked = whole.series["gearbox_states"].position[:, 2]
    assert top[2] > np.abs(np.diff(asked)).max() / PERIOD


def _scaled(series: JointSeries, size: Array) -> JointSeries:
    return replace(series, position=series.position * size)


def test_a_long_recording_tells_its_servos_by_the_stretches_in_which_they_move() -> None:
    """Half a minute of motion after two of rest."""
    elbow = JOINTS.index("elbow")
    whole = of_joints(recorded_servos(OWN, seconds=30.0), "elbow")
    rest = np.arange(0.0, 120.0, PERIOD)

    def after_rest(series: JointSeries) -> JointSeries:
        stamp = np.concatenate([rest, series.stamp + 120.0])
        first = np.repeat(series.position[:1], len(rest), axis=0)
        noise = NOISE * np.random.default_rng(9).standard_normal(first.shape)
        quiet = first if series is whole.series["setpoints"] else first + noise
        return JointSeries(stamp, series.joints, np.concatenate([quiet, series.position]))

    series = {name: after_rest(each) for name, each in whole.series.items()}
    found = with_its_servo(
        load_model("direct").for_joints(("elbow",)), [replace(whole, duration=150.0, series=series)]
    ).arm
    np.testing.assert_allclose(found.kp, OWN["kp"][elbow], rtol=0.02)
    np.testing.assert_allclose(found.delay, OWN["delay"][elbow], atol=3e-4)
    np.testing.assert_allclose(found.v_max, OWN["v_max"][elbow], rtol=0.01)


@pytest.mark.parametrize(
    ("has", "gains"),
    [
        ({"relative": 0.2}, (24.0, 24.0, 30.0)),
        ({"relative": np.array([0.2, 0.2, 0.5]), "form": "apart"}, (24.0, 24.0, 24.0)),
    ],
    ids=["shared before", "shared now"],
)
def test_of_joints_that_share_a_value_or_have_their_own_those_that_changed_are_said(
    has: dict[str, object], gains: tuple[float, float, float]
) -> None:
    model = replace(_stated(), effects={"servo_bandwidth": has})
    (finding,) = diagnose(recorded_servos(PLAIN | {"kp": gains}), model=model).findings
    assert (finding.effect, finding.joints) == ("servo_bandwidth", ["wrist"])
    value = finding.parameters["wrist"]["relative"]
    assert value["simulation"] == np.ravel(has["relative"])[-1]
    assert value["recording"] == pytest.approx(gains[2] / 20.0 - 1.0, abs=0.01)
    assert "the model has" in finding.statement


def test_an_encoder_alone_is_no_servo_and_stays_in_the_model() -> None:
    flat = {
        "arm.joints": list(JOINTS),
        "wire.ratio": [1.0],
        "wire.dead_band": [0.0],
        "servo.counts_per_rev": 4096.0,
    }
    model = Model.from_parameters(flat)
    assert not model.arm.servo_stated
    again = Model.from_parameters(model.parameters()).arm
    assert (again.counts_per_rev, again.servo_stated) == (4096.0, False)


def test_that_a_simulators_setpoints_are_samples_says_nothing_of_the_arms() -> None:
    """Both follow alike; the simulator wrote every second setpoint into a table."""
    whole = stiff()
    went = whole.series["gearbox_states"]
    noise = NOISE * np.random.default_rng(3).standard_normal(went.position.shape)
    arm = replace(
        whole, series=whole.series | {"joint_states": replace(went, position=went.position + noise)}
    )
    some = np.arange(0, len(went.stamp), 2)
    thin = replace(arm, series={name: each.rows(some) for name, each in arm.series.items()})
    assert diagnose(arm, model="direct", against=thin).model.setpoints == "held"


def test_a_joint_far_off_begins_again_from_the_numbers_of_the_others() -> None:
    """A delay in the place of the velocity loop: no small step leads back."""
    gains = {"kp": (10.0, 15.0, 20.0), "tau_v": (0.021,) * 3, "delay": (0.006,) * 3, "v_max": (9.0,) * 3}
    recording = recorded_servos(PLAIN | gains)
    context = first_look(ServoStage([servo_span(recording, (model := _stated()))], model))
    wrong, right = np.array([12.5, 0.002, 9.0, 0.021, 0.0]), np.array([15.0, 0.021, 9.0, 0.006, 0.0])
    loop = Loop.of(context, 0)
    left = loop.left(wrong)
    found, less = _like_others(loop, wrong, [right], left)
    assert less < left / 10.0
    assert found[0] == pytest.approx(10.0, rel=0.02)
    assert _like_others(loop, wrong, [], left) == (pytest.approx(wrong), left)


def test_servos_that_are_tried_at_once_leave_what_each_leaves_by_itself() -> None:
    context = first_look(
        ServoStage([servo_span(recorded_servos(OWN, seconds=5.0), (model := _stated()))], model)
    )
    some = [np.array([kp, 0.02, 5.0, late, share]) for kp, late, share in ((12, 0, 0), (300, 0.01, 0.5))]
    loop = Loop.of(context, 1)
    for one, both in zip(map(loop.residual, some), loop.residuals(some), strict=True):
        assert np.array_equal(one, both)


def test_a_servo_that_gives_way_to_its_load_is_no_slow_one_and_is_simulated_under_the_recorded_torque() -> (
    None
):
    """An impedance, Kp (q* - q) - Kd q' = tau: the load takes it half of the way from where it is asked."""
    stiff, damped, seconds = 35.0, 2.0, 10.0
    t = np.arange(0.0, seconds, STEP)
    asked = _asked(np.arange(0.0, seconds, PERIOD), 5)[:, :1]
    held = asked[np.clip((t / PERIOD + 1e-6).astype(int), 0, len(asked) - 1)]
    load = 4.0 * np.sin(2.0 * np.pi * 0.21 * t) + 3.0 * np.sign(np.sin(2.0 * np.pi * 0.11 * t))
    angle = np.zeros_like(held)
    for k in range(1, len(t)):
        speed = (stiff * (held[k - 1] - angle[k - 1]) + load[k - 1]) / damped
        angle[k] = angle[k - 1] + STEP * speed
    rows = np.arange(2, len(t), round(PERIOD / STEP))
    went = angle[rows] + NOISE * np.random.default_rng(7).standard_normal((len(rows), 1))
    series = {
        "setpoints": JointSeries(t[:: round(PERIOD / STEP)], JOINTS[:1], asked),
        "gearbox_states": JointSeries(t[rows], JOINTS[:1], went, effort=-load[rows, None]),
    }
    recording = Recording("compliant", 0, seconds, series)
    result = diagnose(recording, model="direct")
    assert result.model.arm.kp == pytest.approx([stiff / damped], rel=0.1)
    (found,) = result.findings
    assert found.effect == "load_droop"
    (said,) = found.parameters.values()
    assert said["gain"]["value"] == pytest.approx(1.0 / stiff, rel=0.05)
    predicted = simulate(recording, result.model, "setpoints").series["gearbox_states"].position
    off = [np.sqrt(np.mean((each - angle[rows])[100:] ** 2)) for each in (asked[: len(rows)], predicted)]
    assert off[1] < 0.05 * off[0]
