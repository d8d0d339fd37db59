"""The motion that an ambiguous diagnosis proposes, made by the same concealed arm."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from test.concealed.bag import write_bag
from test.concealed.hidden import Hidden
from test.concealed.nominal import Array
from test.concealed.plant import run
from test.concealed.sensing import PERIOD, Sensing, record
from test.concealed.servo import compensated
from test.diagnosis.arms import of_the_wires, recorded
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis import diagnose
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.evidence import evidence
from trunk_ros.diagnosis.experiment.design import Design, Experiment, experiment, proposals, statement
from trunk_ros.diagnosis.experiment.discrimination import Difference, Other, span_of
from trunk_ros.diagnosis.experiment.motions import Stretch, _Path, limits_of, most_of, seconds_of
from trunk_ros.diagnosis.experiment.rival_forms import sides_of
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.descent import Desk
from trunk_ros.diagnosis.search.greedy import search
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.levels import CLEARLY, TENFOLD
from trunk_ros.model import load_model
from trunk_ros.motion import named_trajectory
from trunk_ros.nodes.run.plan import plan_of
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.trajectory import Limits, load_trajectory

FILE = "experiment_wire.yaml"
TRUTHS = [
    Hidden("ratio_error", (2,), "", {"relative": np.array([8e-3])}),
    Hidden("joint_coupling", (2,), "", {"gain": np.array([8e-3]), "source": 1}),
]
ALL = (0, 1, 2, 3, 4)
LATE = [
    Hidden("sensor_delay", ALL, "pure", {"delay": 0.012}),
    Hidden("viscous_lag", ALL, "first_order", {"time_constant": np.full(5, 0.012)}),
]


def all_joints_alike(seconds: float = 20.0) -> Array:
    """Reference (n, 5) of joints that all move together: none can be told from another as the cause."""
    t = np.arange(round(seconds / PERIOD)) * PERIOD
    rng = np.random.default_rng(3)
    waves = [np.sin(2 * np.pi * rng.uniform(0.04, 0.15) * t + rng.uniform(0, 6)) for _ in range(3)]
    alike = 0.1 * np.sum(waves, axis=0) * np.clip(t / 2.0, 0.0, 1.0)
    return np.repeat(alike[:, None], 5, axis=1)


def slow(seconds: float = 30.0) -> Array:
    """Reference (n, 5) below 0.1 rad/s, each joint for itself: a lag and a delay look the same."""
    t = np.arange(round(seconds / PERIOD)) * PERIOD
    rng = np.random.default_rng(5)
    rate, phase = rng.uniform(0.03, 0.06, 5), rng.uniform(0.0, 6.0, 5)
    waves = 0.2 * np.sin(2 * np.pi * rate * t[:, None] + phase)
    return np.asarray(waves * np.clip(t / 5.0, 0.0, 1.0)[:, None])


def made(path: Path, truth: Hidden, reference: Array, seed: int) -> Path:
    """The bag of a concealed arm that follows a reference, through the nominal compensator."""
    setpoints = compensated(reference, PERIOD)
    motion = run((truth,), setpoints)
    seen = record(np.random.default_rng(seed), "own", reference, setpoints, motion, Sensing())
    seen.topics.pop("setpoints")  # servos are not compared
    write_bag(seen, path)
    return path


def proposed(path: Path) -> Array:
    """The reference (n, 5) of a trajectory file; joints that it has not stand."""
    trajectory = load_trajectory(path)
    wanted = trajectory.sample(np.arange(0.0, trajectory.duration, PERIOD))[0]
    return np.pad(wanted, ((0, 0), (0, 5 - wanted.shape[1])))


def of_two(bag: Path) -> Recording:
    """What a bag shows of the first two joints: it takes half the time where each joint does the same."""
    whole = read_recording(bag)
    some = {key: each.select(each.joints[:2]) for key, each in whole.series.items()}
    return replace(whole, series=some)


@pytest.fixture(scope="module")
def doubtful(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Path, Diagnosis]]:
    """doubtful(effect) -> what is said of an arm that has it and whose joints move alike, and its folder."""

    @cache
    def once(effect: str) -> tuple[Path, Diagnosis]:
        folder = tmp_path_factory.mktemp(effect)
        (truth,) = (each for each in TRUTHS if each.effect == effect)
        result = diagnose([made(folder / "bag", truth, all_joints_alike(), 0)])
        result.save(folder)
        return folder, result

    return once


@pytest.fixture(scope="module")
def ambiguous(doubtful: Callable[[str], tuple[Path, Diagnosis]]) -> tuple[Path, Diagnosis]:
    return doubtful(TRUTHS[0].effect)


@pytest.fixture(scope="module")
def designed(ambiguous: tuple[Path, Diagnosis]) -> tuple[Context, Experiment]:
    model = load_model("trunk")
    stage = WireStage([wire_span(read_recording(ambiguous[0] / "bag"), model)], model)
    state = search(first_look(stage), Desk())
    found = experiment(state, evidence(state))
    assert found is not None
    return state.context, found


@pytest.mark.parametrize("truth", TRUTHS, ids=lambda h: h.effect)
def test_the_proposed_run_on_the_same_arm_ends_the_ambiguity(
    truth: Hidden, doubtful: Callable[[str], tuple[Path, Diagnosis]], tmp_path: Path
) -> None:
    folder, first = doubtful(truth.effect)
    (found,) = first.findings
    assert {found.effect, *found.equivalents} >= {"ratio_error", "joint_coupling"}
    second = made(tmp_path / "second", truth, proposed(folder / FILE), 1)
    settled = diagnose([folder / "bag", second])
    assert [(f.effect, f.joints, f.equivalents) for f in settled.findings] == [
        (truth.effect, ["joint_3"], [])
    ]
    assert settled.experiments == []


@pytest.mark.parametrize("truth", LATE, ids=lambda h: h.effect)
def test_a_run_that_only_one_of_two_can_show_says_so_and_does_what_it_says(
    truth: Hidden, tmp_path: Path
) -> None:
    first = made(tmp_path / "first", truth, slow(), 0)
    doubtful = diagnose([of_two(first)])
    assert [(f.effect, f.equivalents) for f in doubtful.findings] == [("sensor_delay", ["viscous_lag"])]
    (told,) = doubtful.experiments
    assert "if it is viscous lag (proportional)" in told["statement"], "the form that shows most"
    assert told["statement"].endswith(
        "both remain possible: viscous lag (proportional) can do what sensor delay does."
    )
    doubtful.save(tmp_path)
    second = made(tmp_path / "second", truth, proposed(tmp_path / FILE), 1)
    settled = diagnose([of_two(first), of_two(second)])
    left = [(f.effect, f.equivalents) for f in settled.findings]
    if truth.effect == "viscous_lag":
        assert left == [("viscous_lag", [])]
        assert settled.experiments == []
    else:
        assert left == [("sensor_delay", ["viscous_lag"])]
        assert settled.trajectories == {}
        assert settled.experiments[0]["statement"].startswith(
            "No motion within the joint limits decides between"
        )


def test_a_rival_explains_in_one_form_what_is_said_of_it() -> None:
    model, tight = load_model("trunk"), {"tension_error": {"factor": 1.35}}
    stage = WireStage([wire_span(recorded(tight, seconds=20.0, size=0.15), model)], model)
    state = search(first_look(stage), Desk())
    found = evidence(state)["tension_error"]
    assert {"stribeck_friction", "presliding_hysteresis"} <= set(found.equivalents)
    for rival in found.equivalents:
        forward, *turned = sides_of(state, "tension_error", rival, found)
        assert [duel.true for duel in turned] == forward.others
        for other in forward.others:
            context = state.context.seen_with(other.hypothesis)
            cost = sum(float(np.sum(context.whitened(other.hypothesis, c) ** 2)) for c in context.columns)
            assert cost - state.total == pytest.approx(other.loss, abs=0.01)


def test_without_experiments_the_same_is_said(ambiguous: tuple[Path, Diagnosis]) -> None:
    folder, result = ambiguous
    without = diagnose([folder / "bag"], experiments=False)
    assert (without.experiments, without.trajectories) == ([], {})
    assert without.to_json() | {"experiments": result.experiments} == result.to_json()


def test_each_pair_is_told_with_its_file_and_what_to_look_for(ambiguous: tuple[Path, Diagnosis]) -> None:
    folder, result = ambiguous
    (told,) = json.loads((folder / "diagnosis.json").read_text())["experiments"]
    assert told["separates"] == [result.findings[0].effect, *result.findings[0].equivalents]
    assert told["trajectory"] == FILE
    assert "look at joint_3 at" in told["statement"]
    assert "times the noise" in told["statement"]


def test_the_file_is_within_the_limits_of_the_arm(
    ambiguous: tuple[Path, Diagnosis], designed: tuple[Context, Experiment]
) -> None:
    trajectory, arm = load_trajectory(ambiguous[0] / FILE), load_model("trunk").arm
    assert trajectory.joints == arm.joints
    hardest = limits_of(designed[0]).acceleration
    trajectory.check(Limits(arm.lower, arm.upper, arm.v_max * np.abs(arm.ratio), hardest))


def test_bringup_accepts_the_file(ambiguous: tuple[Path, Diagnosis]) -> None:
    plan = plan_of(["--trajectory", str(ambiguous[0] / FILE), "--without", "recorder"])
    assert plan.trajectory is not None
    assert plan.trajectory.duration > 5.0


def test_the_designed_motion_separates_better_than_the_default_one(
    designed: tuple[Context, Experiment],
) -> None:
    context, done = designed
    default = named_trajectory("default", context.arm, done.motion.duration)
    for duel, seen in zip(done.duels, done.seen, strict=True):
        assert seen.ratio > 1.5 * duel.seen_in(context, default).ratio


def test_what_it_promises_is_what_the_arm_shows(
    designed: tuple[Context, Experiment], ambiguous: tuple[Path, Diagnosis], tmp_path: Path
) -> None:
    context, done = designed
    (duel,) = done.duels
    for truth in TRUTHS:
        bag = made(tmp_path / truth.effect, truth, proposed(ambiguous[0] / FILE), 1)
        problem_there = context.over([wire_span(read_recording(bag), context.stage.model)])
        samples = sum(problem_there.count(c) for c in duel.columns)
        ruled_out = all(  # joints that move alike are the same source: any may come first
            other.refitted(problem_there, duel.columns)[0] - samples > duel.wanted(problem_there, other)
            for other in duel.others
        )
        assert ruled_out == (truth.effect == duel.truth)


def test_rivals_that_can_turn_into_each_other_are_said_to_be_beyond_any_motion() -> None:
    result = diagnose([of_the_wires(recorded({"sensor_delay": {"delay": 0.03}}, seconds=20.0))])
    (found,) = result.findings
    assert (found.effect, found.equivalents) == ("sensor_delay", ["viscous_lag"])
    (told,) = result.experiments
    assert told["statement"].startswith("No motion within the joint limits decides between")
    assert told["trajectory"] == ""
    assert result.trajectories == {}


def test_where_no_motion_decides_the_whole_motion_is_told_beside_its_largest_sample() -> None:
    base = {"backlash": SimpleNamespace(form="")}
    duel = SimpleNamespace(truth="backlash", other="viscous_lag", base=base)
    seen = Difference(0, 3.0, 0.1, 0.0, 5.7e-4, 1e-4, 0.3, 0.24 * CLEARLY)
    told = statement(duel, seen, True, SimpleNamespace(joints=["elbow"]), {}, FILE)
    assert "by 0.57 mrad in one sample of elbow (5.7 times the noise), but over all samples by 0.3" in told
    assert told.endswith("24% of what a decision takes.")
    hidden = replace(seen, gap=0.89e-4, rms=0.54, ratio=TENFOLD)
    there = SimpleNamespace(joints=["elbow"], duration=20.0)
    told = statement(duel, hidden, False, there, {}, FILE)
    assert "diagnose it: no sample of elbow shows whether it is backlash or viscous lag" in told
    assert told.endswith("(0.089 mrad at most, 0.89 times the noise), all of them do (0.54 times rms).")


@pytest.mark.parametrize(
    ("unit", "gap", "angle", "speed"),
    [("1", "1.1", "+0.30", "+1.00 per s"), ("rad", "1.1 rad", "+0.30 rad", "+1.00 rad/s")],
)
def test_a_joint_without_a_unit_has_none_in_an_experiment(
    unit: str, gap: str, angle: str, speed: str
) -> None:
    base = {"backlash": SimpleNamespace(form="")}
    duel = SimpleNamespace(truth="backlash", other="viscous_lag", base=base)
    seen = Difference(0, 3.0, 0.3, 1.0, 1.1, 1e-3, 0.3, TENFOLD)
    there = SimpleNamespace(joints=["grip"], duration=20.0)
    told = statement(duel, seen, True, there, {"grip": unit}, FILE)
    assert f"grip at 3.0 s ({angle}, at {speed}): " in told
    assert f"the joint reads {gap} higher than" in told


@pytest.mark.parametrize("period", [0.01, 0.42], ids=["moving", "stop_and_measure"])
def test_an_arm_without_limits_is_not_moved_beyond_what_it_did(period: float, tmp_path: Path) -> None:
    stamp, rng = np.arange(3000) * period, np.random.default_rng(0)
    alike = 0.7 + 0.3 * np.sin(2 * np.pi * np.arange(3000) / 300) + 0.1 * np.sin(np.arange(3000) / 17)
    driving = np.column_stack([alike, alike])
    shown = driving * [1.0, 1.01] + rng.normal(size=driving.shape) * 2e-4
    topics = {"gearbox_states": driving, "joint_states": shown}
    series = {key: JointSeries(stamp, ("a", "b"), position) for key, position in topics.items()}
    result = diagnose([Recording("made", 1, float(stamp[-1]), series)], model="direct")
    (motion,) = result.trajectories.values()
    assert motion.duration <= 3.0 * stamp[-1]
    position, velocity, _ = motion.sample(np.linspace(0.0, motion.duration, 5000))
    assert position.min() >= alike.min()
    assert position.max() <= alike.max()
    assert np.abs(velocity).max() <= np.abs(np.gradient(alike, stamp)).max()
    result.save(tmp_path)
    assert plan_of(["--trajectory", str(tmp_path / FILE), "--model", "direct", "--without", "recorder"])


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_a_joint_that_never_moved_is_left_where_it_stood(speed: float) -> None:
    limits = Limits(*(np.array([value]) for value in (0.3, 0.3, speed, 0.0)))
    path = _Path(limits, 0)
    path.follow(Stretch("all", 0.5, 0.5, 0.5), True, 8.0)
    assert {angle for _, angle in path.points} == {0.3}


def test_a_motion_begins_where_the_arm_may_be_and_not_hours_away() -> None:
    """A tip that moves by a millimetre, 0.1 m away from 0: the way from there took 5540 s."""
    limits = Limits(*(np.array([value]) for value in (-0.108, -0.107, 2e-5, 1e-6)))
    path = _Path(limits, 0, fastest=1.5)
    assert path.lead < 120.0
    path.stay(path.lead)
    path.follow(Stretch("all", 0.0, 0.9, 0.9), True, path.lead + 200.0)
    angles = np.array([angle for _, angle in path.points])
    assert angles.min() >= -0.108
    assert angles.max() <= -0.107
    assert np.ptp(angles) > 5e-4


@pytest.mark.parametrize(("step", "many"), [(0.01, 16), (1.0, 5), (20.0, 1)])
def test_a_motion_is_no_longer_than_a_few_recordings(step: float, many: int) -> None:
    view = SimpleNamespace(span=SimpleNamespace(stamp=np.arange(0.0, 398.0, step)))
    context = SimpleNamespace(step=step, views=[view])
    assert most_of(context, 16) == many
    assert many * seconds_of(context) <= 3.0 * 398.0


def test_a_motion_is_repeated_only_as_often_as_it_decides_more() -> None:
    """One pair that no motion tells had made four of it for the other, which one or two tell."""
    design = SimpleNamespace(most=16, ratios=lambda parts: np.array([0.1, 0.5 * len(parts)]))
    part = Stretch("all", 0.0, 0.9, 0.9)
    assert Design.repeated(design, [part]) == [part] * 3
    design.ratios = lambda parts: np.array([0.1])
    assert Design.repeated(design, [part, part]) == [part] * 8


def test_what_joints_share_is_held_in_a_motion_that_only_others_show(
    designed: tuple[Context, Experiment],
) -> None:
    """An arm that sags had ended in an error where a stretch moved a joint that does not."""
    context, done = designed
    terms = [Term("sensor_delay", shared={"delay": 0.004}, own={0: {}, 1: {}})]
    late = Other(context, Hypothesis({term.effect: term for term in terms}), 0.0)
    span = span_of(context, done.motion)
    there = context.over([replace(span, valid=np.tile(np.arange(5) == 4, (len(span.target), 1)))])
    assert there.columns == [4]
    (pinned,) = late.pinned(there, [0, 1])
    assert [f.parameter.name for f in pinned.free] == ["delay"]
    assert pinned.unfitted() == pytest.approx(pinned.linear()) == 0.0


def test_what_earlier_recordings_hold_is_held_about_the_middle_of_the_motion_as_well(
    designed: tuple[Context, Experiment],
) -> None:
    """Rivals had been refitted by steps that left out what earlier recordings hold."""
    context, done = designed
    ripple = {"amplitude": 1e-3, "cycles_per_rev": 12.0, "phase": 1.0}
    waves = Other(
        context, Hypothesis({"transmission_ripple": Term("transmission_ripple", own={2: ripple})}), 0.0
    )
    (pinned,) = waves.pinned(context.over([span_of(context, done.motion)]), [2])
    x = pinned.at * 1.01
    turn, jacobian, rest = pinned.turned(np.eye(len(x))), pinned.jacobian(x), pinned(x)
    assert not np.allclose(turn, np.eye(len(x)))
    for change, (slope, curvature) in (
        (np.eye(len(x)), pinned.normal(x)),
        (turn, pinned.normal_about(x)),
    ):
        moved = jacobian @ change
        assert slope == pytest.approx(moved.T @ rest, rel=1e-3, abs=1e-3 * np.abs(slope).max())
        assert curvature == pytest.approx(moved.T @ moved, rel=1e-3, abs=1e-3 * np.abs(curvature).max())


def test_units_are_those_of_the_joints(designed: tuple[Context, Experiment]) -> None:
    (told,) = proposals(designed[1], FILE, {"joint_3": "m"})
    assert "mm" in told["statement"]
    assert "rad" not in told["statement"].replace("ratio", "")


def test_without_rivals_there_is_no_experiment(tmp_path: Path) -> None:
    hidden = {"ratio_error": {"relative": np.array([0, 0, 0, 6e-3, 0])}}
    result = diagnose([of_the_wires(recorded(hidden, seconds=20.0))])
    assert [f.equivalents for f in result.findings] == [[]]
    assert result.experiments == []
    result.save(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["diagnosis.json", "model.yaml"]
