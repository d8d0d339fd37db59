"""Claims about joints that follow another one along a curve."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import SHORT, of_the_wires, reshaped
from trunk_ros.compiled import Array
from trunk_ros.diagnosis import Finding
from trunk_ros.recording.recording import Recording

on = partial(arms.on, joints=3)
recorded = partial(arms.recorded, nominal=SHORT)
diagnose = partial(arms.diagnose, model=SHORT)
RATIO = {"ratio_error": {"relative": on(2, 0.01)}}


def _along(curve: Callable[[Array], Array], effects: dict[str, dict[str, Any]]) -> Recording:
    """An arm whose second joint follows the third along a curve [rad]."""
    made = recorded(effects, 25.0, size=1.6)
    third = made.series["gearbox_states"].position[:, 2] * SHORT.arm.ratio[2]
    position = made.series["joint_states"].position.copy()
    position[:, 1] += curve(third)
    return reshaped(made, "joint_states", position=position)


def _found(recording: Recording) -> dict[str, Finding]:
    return {finding.effect: finding for finding in diagnose(of_the_wires(recording)).findings}


@pytest.mark.long
@pytest.mark.parametrize(
    ("curve", "effects"),
    [
        (lambda q: 0.03 * np.sin(2.0 * q), RATIO),
        (lambda q: 0.02 * q**2, {}),
        (lambda q: 0.01 * np.exp(-(((q - 0.1) / 0.15) ** 2)), {}),
    ],
)
def test_a_curve_of_another_joint_has_its_name_and_nothing_else_stands_in_for_it(
    curve: Callable[[Array], Array], effects: dict[str, dict[str, Any]]
) -> None:
    found = _found(_along(curve, effects))
    assert set(found) == {"coupling_curve", *effects}
    named = found["coupling_curve"]
    assert (named.joints, named.depends_on) == (["joint_2"], ["joint_3"])
    assert named.confidence > 0.9


@pytest.mark.long
def test_a_curve_ahead_of_the_friction_is_told_from_one_behind_it() -> None:
    """Where the joint's own dead band is wide, what the guides of others do to its wire goes through it."""
    knots = np.array([0.05, 0.02, 0.0, -0.01, -0.01, 0.0, 0.02, 0.05])
    values = {f"weight_1_{k}": on(2, float(v)) for k, v in enumerate(knots, start=1)}
    values |= {"low_1": on(2, -0.6), "high_1": on(2, 0.6), "source": ["", "joint_3", ""]}
    for form in ("behind", "guides"):
        made = recorded({"coupling_curve": values | {"form": form}}, 25.0, size=1.6)
        result = diagnose(of_the_wires(made))
        assert {f.effect for f in result.findings} == {"coupling_curve"}
        assert result.model.effects["coupling_curve"]["form"] == form


def test_a_straight_coupling_is_not_bent() -> None:
    assert set(_found(_along(lambda q: 0.02 * q, {}))) == {"joint_coupling"}
