"""What is said of arms whose tip was recorded: lengths and tilts, and what could pass for them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from test.diagnosis.arms import diagnose, of_the_wires, on, recorded, setpoints_of
from test.effects.example import in_plane
from trunk_ros.chain import Chain
from trunk_ros.diagnosis.tip.judged import fitted_tip, judged_tip
from trunk_ros.diagnosis.tip.stage import ArmFit, ArmProblem
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording

TRUNK = load_model("trunk")
TILT = {"base_tilt": {"angle": 4e-3}}
LONGER = {"link_length_error": {"length_error": on(3, 1e-3)}}
TRUTH = {("base_tilt", -1): 4e-3, ("link_length_error", 2): 1e-3}
NOISE = np.array([3e-5, 3e-5, 2e-4])  # m, m, rad


@dataclass(frozen=True)
class Seen:
    """How the tip is seen: rate [Hz], share of lost and of wild poses, memory of the noise from one sample
    to the next, a constant error, joints (from 0) that stand.
    """

    rate: int = 50
    lost: float = 0.0
    wild: float = 0.0
    memory: float = 0.0
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    still: tuple[int, ...] = ()


def noise(rng: np.random.Generator, shape: tuple[int, ...], memory: float) -> np.ndarray:
    white = rng.normal(size=(shape[0] + 300, *shape[1:]))
    return np.asarray(np.sqrt(1 - memory**2) * lfilter([1.0], [1.0, -memory], white, axis=0)[300:])


def with_pose(recording: Recording, stamp: np.ndarray, tip: np.ndarray) -> Recording:
    """A recording with the tip y, z, roll (n, 3) at these stamps."""
    none, half = np.zeros(len(tip)), tip[:, 2] / 2
    position = np.column_stack([none, tip[:, :2]])
    orientation = np.column_stack([np.sin(half), none, none, np.cos(half)])
    return replace(recording, tip=PoseSeries(stamp, position, orientation))


def bent(effects: dict[str, Any], how: Seen = Seen(), seed: int = 0) -> Recording:
    """Joint angles and tip of an arm with some effects."""
    rng, stamp = np.random.default_rng(seed), np.arange(3000) / 100.0
    theta = 0.625 * setpoints_of(30.0, 5, seed)
    theta[:, list(how.still)] = 0.0
    joints = JointSeries(stamp, TRUNK.arm.joints, theta + 1e-4 * rng.normal(size=theta.shape))
    tip = (in_plane(Chain(Model(TRUNK.arm, effects), "arm").tip(theta, stamp)) + how.shift)[
        :: 100 // how.rate
    ]
    tip += NOISE * noise(rng, tip.shape, how.memory)
    wild = rng.uniform(size=len(tip)) < how.wild
    tip[wild] += rng.normal(size=(wild.sum(), 3)) * [0.02, 0.02, 0.2]
    kept = rng.uniform(size=len(tip)) >= how.lost
    recording = Recording("made", 0, float(stamp[-1]), {"joint_states": joints})
    return with_pose(recording, stamp[:: 100 // how.rate][kept], tip[kept])


def fitted(recording: Recording, model: Model = TRUNK) -> tuple[ArmProblem, ArmFit]:
    found = fitted_tip([recording], model, 0.0, {})
    assert found is not None
    return found


def told(recording: Recording, model: Model = TRUNK) -> list[Finding]:
    return judged_tip(*fitted(recording, model))[1]


def names(found: list[Finding]) -> set[tuple[str, tuple[str, ...]]]:
    return {(f.effect, tuple(f.joints)) for f in found}


BOTH = {("base_tilt", ()), ("link_length_error", ("joint_3",))}


@pytest.mark.parametrize(
    "how",
    [Seen(), Seen(rate=10, lost=0.3), Seen(wild=0.01), Seen(memory=0.9)],
    ids=["plain", "rarely seen with losses", "one pose in a hundred is wild", "noise with a memory"],
)
def test_a_tilt_and_a_length_are_named_however_the_tip_is_seen(how: Seen) -> None:
    found = told(bent(TILT | LONGER, how))
    assert names(found) == BOTH
    assert all(f.confidence > 0.9 and not f.equivalents for f in found)
    assert told(bent({}, how)) == []


def test_wild_poses_are_counted_and_left_out() -> None:
    recording = bent({}, Seen(wild=0.01))
    problem, _ = fitted(recording)
    assert recording.tip is not None
    assert 5 < problem.strays < 30
    assert problem.count == len(recording.tip.stamp) - problem.strays
    (quality,) = diagnose([recording]).quality.values()
    said = f"trunk/tip_pose: {problem.strays} poses far from those beside them are left out"
    assert said in quality["notes"]
    assert quality["topics"]["tip_pose"]["samples"] == len(recording.tip.stamp)


@pytest.mark.parametrize("orientation", [[0.0, 0, 0, 0], [0.0, 0, 0, 1], [np.nan] * 4])
def test_without_orientations_the_place_of_the_tip_is_enough(orientation: list[float]) -> None:
    recording = bent(TILT | LONGER)
    assert recording.tip is not None
    none = np.tile(orientation, (len(recording.tip.stamp), 1))
    stage, found, _ = judged_tip(*fitted(replace(recording, tip=replace(recording.tip, orientation=none))))
    assert set(stage["tip"]) == {"y", "z"}
    assert names(found) == BOTH


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_true_values_lie_within_three_stated_spreads(memory: float) -> None:
    off = []
    for seed in range(12):
        _, done = fitted(bent(TILT | LONGER, Seen(memory=memory), seed))
        off += [(done.values[key] - true) / done.std[key] for key, true in TRUTH.items()]
    assert np.mean(np.abs(off) < 3.0) >= 0.9
    assert np.sqrt(np.mean(np.square(off))) > 0.2  # not so wide as to say nothing


def test_no_value_is_known_better_than_to_a_thousandth() -> None:
    _, done = fitted(bent({"base_tilt": {"angle": 0.5}}))
    assert done.std["base_tilt", -1] >= 1e-3 * done.values["base_tilt", -1]


def test_what_the_model_has_of_the_arm_is_no_finding_and_stays_in_it() -> None:
    model = replace(TRUNK, effects=TILT | LONGER)
    stage, found, effects = judged_tip(*fitted(bent(TILT | LONGER), model))
    assert found == []
    assert effects["base_tilt"]["angle"] == pytest.approx(4e-3, rel=0.03)
    assert effects["link_length_error"]["length_error"] == pytest.approx(on(3, 1e-3), abs=2e-5)
    for signal in stage["tip"].values():
        assert signal["rmse_before"] == pytest.approx(signal["noise_floor"], rel=0.1)


def test_what_the_arm_has_besides_is_found_beside_what_the_model_has() -> None:
    _, found, effects = judged_tip(*fitted(bent(TILT | LONGER), replace(TRUNK, effects=LONGER)))
    assert names(found) == {("base_tilt", ())}
    assert set(effects) == {"base_tilt", "link_length_error"}


def test_a_tilt_that_only_the_model_has_is_found_and_goes() -> None:
    stage, (found,), effects = judged_tip(*fitted(bent({}), replace(TRUNK, effects=TILT)))
    assert found.effect == "base_tilt"
    assert "The model has 0.004 rad" in found.statement
    assert abs(effects["base_tilt"]["angle"]) < 3 * found.parameters["arm"]["angle"]["std"]
    assert stage["tip"]["roll"]["rmse_before"] > 5 * stage["tip"]["roll"]["rmse_after"]


def test_the_new_model_has_the_tilt_of_the_recording_and_not_that_of_the_old_one() -> None:
    recording = of_the_wires(recorded(seconds=15.0))
    joints = recording.series["joint_states"]
    tip = in_plane(TRUNK.arm.tip(joints.position))
    tip += NOISE * np.random.default_rng(1).normal(size=tip.shape)
    result = diagnose([with_pose(recording, joints.stamp, tip)], model=replace(TRUNK, effects=TILT))
    assert [f.effect for f in result.findings] == ["base_tilt"]
    assert abs(result.model.effects["base_tilt"]["angle"]) < 1e-4


def test_what_the_model_has_of_the_arm_stays_where_no_tip_was_recorded() -> None:
    result = diagnose([of_the_wires(recorded(seconds=10.0))], model=replace(TRUNK, effects=TILT))
    assert result.model.effects["base_tilt"] == TILT["base_tilt"]


@pytest.mark.parametrize("shift", [(5e-3, 0.0, 0.0), (0.0, 5e-3, 0.0), (3e-3, -5e-3, 0.0), (0.0, 0.0, 5e-3)])
def test_poses_in_a_shifted_frame_are_neither_a_length_nor_a_tilt(shift: tuple[float, float, float]) -> None:
    (found,) = told(bent({}, Seen(shift=shift)))
    assert (found.effect, found.joints, found.equivalents) == ("unknown", [], [])
    said = {signal: v["value"] for signal, v in found.parameters["arm"].items()}
    assert said == pytest.approx(
        {s: v for s, v in zip(("y", "z", "roll"), shift, strict=True) if v}, rel=0.05
    )


def test_a_shifted_frame_does_not_hide_a_tilt() -> None:
    found = told(bent(TILT, Seen(shift=(0.0, 5e-3, 0.0))))
    assert names(found) == {("base_tilt", ()), ("unknown", ())}


@pytest.mark.parametrize("joint", [2, 3, 4, 5])
def test_a_joint_sensor_whose_zero_is_off_is_neither_a_length_nor_a_tilt(joint: int) -> None:
    recording = bent({})
    recording.series["joint_states"].position[:, joint - 1] += 3e-3
    (found,) = told(recording)
    assert (found.effect, found.joints) == ("unknown", [f"joint_{joint}"])
    assert found.equivalents == ["zero_offset"]
    assert found.parameters[f"joint_{joint}"]["zero"]["value"] == pytest.approx(3e-3, rel=0.05)


def test_a_tilt_beside_a_zero_error_of_the_first_joint_may_be_that_error() -> None:
    model = replace(TRUNK, effects={"zero_offset": {"offset": on(1, -4e-3)}})
    (found,) = told(bent(TILT), model)
    assert (found.effect, found.equivalents) == ("base_tilt", ["zero_offset"])


def test_a_length_that_could_be_a_shift_is_said_to_be_so() -> None:
    """A first link that stands is as good as a shift of its frame."""
    (found,) = told(bent({"link_length_error": {"length_error": on(1, 3e-4)}}, Seen(still=(0,))))
    assert found.equivalents == ["unknown"]
    assert found.confidence < 0.8
    assert "A constant error of the readings would look the same" in found.statement


def test_a_length_that_could_be_the_next_links_is_said_to_be_so() -> None:
    """Two links without a motion between them are one."""
    (found,) = told(bent(LONGER, Seen(still=(2,))))
    assert found.effect == "link_length_error"
    assert found.confidence < 0.8
    assert "would look the same" in found.statement
    assert {*found.joints, found.statement.split("On ")[1][:7]} == {"joint_2", "joint_3"}


def test_what_bends_the_tip_up_and_down_is_placed_by_that() -> None:
    """y shows nothing of it."""
    recording = bent({})
    assert recording.tip is not None
    position, theta = recording.tip.position.copy(), recording.series["joint_states"].position[::2, 3]
    position[:, 2] += 2e-3 * np.sign(theta)
    (found,) = told(replace(recording, tip=replace(recording.tip, position=position)))
    assert found.effect == "unknown"
    assert found.depends_on[:2] == ["position", "joint_4"]
    assert found.evidence["strength"] > 20.0


def test_nanometres_that_no_tracker_sees_are_no_finding() -> None:
    """A tip without noise that bends by 20 nm in a way that has no name."""
    theta, stamp = 0.625 * setpoints_of(30.0, 5, 0), np.arange(3000) / 100.0
    tip = in_plane(Chain(Model(TRUNK.arm, {}), "arm").tip(theta, stamp))
    tip += 2e-8 * np.column_stack([np.sin(40.0 * theta[:, k]) for k in range(3)])
    joints = JointSeries(stamp, TRUNK.arm.joints, theta)
    recording = Recording("made", 0, float(stamp[-1]), {"joint_states": joints})
    seen = with_pose(recording, stamp, tip)
    assert told(seen) == []
    assert (fitted(seen)[0].noise == 1e-6).all()


def test_joints_and_tip_alone_are_enough_for_the_arm() -> None:
    result = diagnose([bent(TILT | LONGER)])
    assert names(result.findings) == BOTH
    assert [stage for stage, told in result.stages.items() if told["compared"]] == ["arm"]


def test_between_the_counts_of_coarse_encoders_the_tip_is_where_the_gearbox_puts_it() -> None:
    rng, stamp, step = np.random.default_rng(3), np.arange(3000) / 100.0, 2 * np.pi / 2**12
    held = 0.7 * setpoints_of(30.0, 5, 3)[300 * (np.arange(3000) // 300)]
    held += 0.02 * setpoints_of(30.0, 5, 3)  # hardly moves for a while, anywhere within its counts
    theta, _ = Chain(TRUNK, "wire").run(held, stamp)
    series = {
        "gearbox_states": JointSeries(stamp, TRUNK.arm.joints, held),
        "joint_states": JointSeries(stamp, TRUNK.arm.joints, np.round(theta / step) * step),
    }
    tip = in_plane(Chain(TRUNK, "arm").tip(theta, stamp))
    recording = Recording("coarse", 0, float(stamp[-1]), series)
    problem, done = fitted(with_pose(recording, stamp, tip + NOISE * rng.normal(size=tip.shape)))
    left = np.concatenate(problem.residual(done.values))
    assert (np.sqrt(np.mean(left**2, axis=0)) < 1.2 * NOISE).all()
    assert done.values == {}


@pytest.mark.parametrize("effects", [{}, TILT])
def test_a_joint_that_rests_between_two_counts_of_its_encoder_is_no_tilt(effects: dict[str, Any]) -> None:
    """Its reading is off by as much all the time, which counts once and not at each pose."""
    rng, stamp, step = np.random.default_rng(0), np.arange(3000) / 100.0, 1.5e-3
    theta = 0.625 * setpoints_of(30.0, 5, 0)
    theta[:, 0] = 0.0
    shown = theta + 1e-4 * rng.normal(size=theta.shape)
    shown[:, 0] = step / 3.0
    tip = in_plane(Chain(Model(TRUNK.arm, effects), "arm").tip(theta, stamp))
    series = {"joint_states": JointSeries(stamp, TRUNK.arm.joints, shown)}
    recording = Recording("rests", 0, float(stamp[-1]), series)
    seen = with_pose(recording, stamp, tip + NOISE * rng.normal(size=tip.shape))
    std = step / np.sqrt(12.0)
    for stays, found in ((0.0, {"base_tilt"}), (30.0, set(effects))):  # s for which a reading stays
        told_of = fitted_tip([seen], TRUNK, 0.0, {"joint_1": (std, stays)})
        assert told_of is not None
        assert {f.effect for f in judged_tip(*told_of)[1]} == found
