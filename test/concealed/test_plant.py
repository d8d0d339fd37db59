"""Claims about the parametric plant, checked on the contract's formulas and on the labelled recordings."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.concealed.case import draw_case
from test.concealed.ceiling import errors
from test.concealed.draws import ALL
from test.concealed.hidden import Hidden
from test.concealed.labelled import labelled_truth
from test.concealed.nominal import (
    COMPLIANCE,
    COUNTS_PER_REV,
    HALF_WIDTH,
    JOINTS,
    RATIO,
    Array,
    load,
    nominal_wire,
    tip,
)
from test.concealed.plant import run
from test.concealed.removed import read_angles
from test.concealed.trajectory import KINDS, REACH, draw_reference

HERE = Path(__file__).parent
LABELLED = HERE.parents[2] / "shared" / "concealed"
needs_labelled = pytest.mark.skipif(not LABELLED.exists(), reason="labelled recordings are not here")
T = np.arange(6000, dtype=np.float64) * 0.01
PAYLOAD = {"dev_00": 0.06235, "dev_two_1": 0.0639}  # kg, fitted: the labels do not say
MADE_OF = {"load_elasticity": "wire", "viscoelastic_creep": "one_mode", "thermal_drift": "exponential",
           "presliding_hysteresis": "uniform", "link_resonance": "absolute_damping"}  # fmt: skip


MAY_USE = {
    "score.py": {"trunk_ros.__main__"},  # the commands, as a user runs them
    "solver.py": {"trunk_ros.__main__"},
    "live.py": {"trunk_ros.nodes.graph.ros"},  # rclpy itself, and nothing of the arm
}


def test_plants_share_no_code_with_what_they_test() -> None:
    for file in HERE.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            used = {name for name in names if name.startswith("trunk_ros")}
            assert used <= MAY_USE.get(file.name, set()), file.name


def test_an_arm_without_hidden_physics_is_the_nominal_formula() -> None:
    motion = run((), draw_reference(np.random.default_rng(1), "mixed", T) / RATIO)
    np.testing.assert_array_equal(motion.theta, nominal_wire(motion.phi))


def test_the_nominal_dead_band_is_that_of_the_contract() -> None:
    stretch = 0.11364 + np.exp(-0.10 * 0.9774) * np.array([0.059, 0.10915, 0.15915, 0.20915, 0.25915])
    np.testing.assert_allclose(HALF_WIDTH, 1.0 * stretch / (252523.55e6 * 0.113e-6 * 0.016), rtol=1e-12)


def test_load_is_the_moment_of_the_weight_beyond_each_joint() -> None:
    theta = np.array([[0.1, -0.2, 0.3, 0.05, -0.1]])
    mass, payload = np.array([60, 55, 50, 45, 40]) * 1e-3, 0.05
    lifted = []
    for step in (-1e-6, 1e-6):
        turned = theta + step * np.eye(5)
        angles = turned.cumsum(axis=1)
        ends = 0.05 * np.cos(angles).cumsum(axis=1)
        middles = ends - 0.025 * np.cos(angles)
        lifted.append(9.81 * (middles @ mass + payload * ends[:, -1]))
    np.testing.assert_allclose(load(theta, payload)[0], -(lifted[1] - lifted[0]) / 2e-6, rtol=1e-5)


def test_a_straight_arm_points_upwards_and_a_positive_angle_leans_to_minus_y() -> None:
    np.testing.assert_allclose(tip(np.zeros((1, 5)))[0], [0, 0.25, 0])
    assert tip(np.array([[0.1, 0, 0, 0, 0]]))[0, 0] < 0


@pytest.mark.parametrize("kind", KINDS)
def test_motions_stay_within_reach(kind: str) -> None:
    assert np.abs(draw_reference(np.random.default_rng(3), kind, T)).max() <= REACH * 1.0001


def _recorded(name: str, topic: str) -> Array:
    return read_angles(LABELLED / name / "train", topic).angle


def _hidden(name: str) -> tuple[Hidden, ...]:
    """The labelled physics of a recording, in the form that it was found to be made of."""
    out = []
    for t in labelled_truth(LABELLED)[name]["truth"]:
        shared = dict(t["parameters"].get("arm", {}))
        own = [t["parameters"].get(joint, {}) for joint in t["joints"]]
        values: dict[str, Any] = {key: np.array([one[key] for one in own]) for key in own[0]} | shared
        if "source" in values:
            values["source"] = JOINTS.index(values["source"])
            values["gain"] = np.array([values["gain"]])
        if t["effect"] == "load_elasticity":
            values = {"compliance": COMPLIANCE, "payload": PAYLOAD[name]}
        place = (np.arange(24) + 0.5) / 24
        extra = {"place": place, "weight": np.full(24, 1 / 24)}
        joints = tuple(JOINTS.index(joint) for joint in t["joints"])
        if t["stage"] == "servo" or t["effect"] == "sensor_delay":
            values, joints = {k: float(np.ravel(v)[0]) for k, v in values.items()}, ALL
        out.append(Hidden(t["effect"], joints, MADE_OF.get(t["effect"], ""), values, (), extra))
    return tuple(out)


@needs_labelled
@pytest.mark.parametrize(
    "name",
    ["dev_00", "dev_01", "dev_02", "dev_03", "dev_05", "dev_10", "dev_13", "dev_14", "dev_16", "dev_17",
     "dev_21", "dev_null_0", "dev_two_0", "dev_two_1"],
)  # fmt: skip
def test_the_labelled_physics_run_from_the_recorded_setpoints_leaves_only_sensor_noise(name: str) -> None:
    noise = labelled_truth(LABELLED)[name]["noise"]["noise"]
    motion = run(_hidden(name), _recorded(name, "trunk/setpoints"))
    counts = (_recorded(name, "trunk/gearbox_states") - motion.phi[::5]) / (2 * np.pi / COUNTS_PER_REV)
    assert np.abs(counts).max() < 1.0
    shown = read_angles(LABELLED / name / "train", "joint_states")
    first = round((shown.stamp[0] % 10**7) / 2e6)  # the topic's phase, in steps of 2 ms
    left = (shown.angle - motion.theta[first::5])[300:]
    np.testing.assert_allclose(left.std(axis=0), noise, rtol=0.05)


def test_on_readings_of_counts_even_the_hidden_physics_leaves_some_of_their_error() -> None:
    """And it is less than a quarter of the noise; what the servo's course tells is not asked."""
    case = draw_case(3, effects=["ratio_error"], level=(4.0, 5.0))
    before, after = errors(case)
    assert 0.01 < after < 0.25 < before
