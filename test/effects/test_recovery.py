"""Every effect's own parameters come back from its noisy signal by plain least squares."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from test.effects.example import CASES, arm_of, model_of
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects import registry
from trunk_ros.model import Model
from trunk_ros.motion import named_trajectory
from trunk_ros.parameter import Parameter

JOINTS = 2
NOISE = 2e-5  # rad, or m at the tip
OFF = 0.05  # share of its size by which each parameter is wrong at the start
KNOWN = {"low", "high", "friction"}
TIED = {
    ("unknown_cycle", "value_23"),  # the end of a period is its beginning
    ("unknown_waves", "value_23"),
    ("load_droop", "as_torque"),  # the excitation asks for no more than the top speed
    ("integral_action", "windup"),  # likewise
    ("link_offset_error", "across_2"),  # along parallel axes the shifts of all joints are one
}

# Sizes of a zone are tried, as the motion hardly changes smoothly with it; levels hide within the dead band.
TRIED = {"unknown_dead_zone", "unknown_slips"}

ABLE = {  # below that its loop swings on after each of these moves, and its profile falls behind them
    "acceleration_limit": {"acceleration": 5.0},
    "setpoint_profile": {"acceleration": 5.0},
}


@dataclass(frozen=True)
class Fitted:
    """A number that a fit moves: a parameter of one joint, or a shared one."""

    parameter: Parameter
    joint: int | None

    def read(self, values: dict[str, Any]) -> float:
        """Its value, as logarithm where it spans decades."""
        raw = values[self.parameter.name]
        value = float(raw if self.joint is None else raw[self.joint])
        return float(np.log(value)) if self.parameter.scale == "log" else value

    def write(self, values: dict[str, Any], x: float) -> None:
        """Put a value into a copy of the model's values."""
        value = float(np.exp(x)) if self.parameter.scale == "log" else x
        if self.joint is None:
            values[self.parameter.name] = value
        else:
            values[self.parameter.name] = values[self.parameter.name].copy()
            values[self.parameter.name][self.joint] = value

    @property
    def size(self) -> float:
        """What counts as a usual step of it."""
        if self.parameter.name == "onset":
            return 0.1
        return 1.0 if self.parameter.scale == "log" else abs(self.parameter.typical)


@cache
def excitation(stage: str) -> tuple[Array, Array]:
    """Stamps at 100 Hz and what goes into a stage: sweeps, fast moves, reversals and holds."""
    arm = arm_of(JOINTS)
    stamp = np.arange(4000) * 0.01
    theta = named_trajectory("default", arm, 40.0).sample(stamp)[0]
    return stamp, theta if stage == "arm" else theta / arm.ratio


def free(name: str, form: str, values: dict[str, Any]) -> list[Fitted]:
    """All numbers of an effect that its own signal determines."""
    found: list[Fitted] = []
    for parameter in registry()[name].own_parameters(form):
        told = parameter.name in KNOWN or (name, parameter.name) in TIED or parameter.measured
        if parameter.name in values and not told:
            joints = [None] if parameter.shared else range(JOINTS)
            found += [Fitted(parameter, joint) for joint in joints]
    return found


@pytest.mark.parametrize(("name", "form"), [case for case in CASES if case[0] not in TRIED])
def test_its_parameters_come_back_within_four_standard_deviations(name: str, form: str) -> None:
    kind = registry()[name]
    stamp, x = excitation(kind.stage)
    truth = model_of(name, form, JOINTS).effects[name]
    truth |= {key: value + 0.0 * truth[key] for key, value in ABLE.get(name, {}).items()}
    numbers = free(name, form, truth)
    size = np.array([number.size for number in numbers])
    rng = np.random.default_rng(zlib.crc32(f"{name}/{form}".encode()))

    def simulated(p: Array) -> Array:
        values = dict(truth)
        for number, value in zip(numbers, p * size, strict=True):
            number.write(values, float(value))
        return Chain(Model(arm_of(JOINTS), {name: values}), kind.stage).run(x, stamp)[0]

    right = np.array([number.read(truth) for number in numbers]) / size
    measured = simulated(right) + NOISE * rng.normal(size=simulated(right).shape)
    start = right + OFF * rng.choice([-1.0, 1.0], size=len(right))
    fit = least_squares(
        lambda p: (simulated(p) - measured).ravel() / NOISE, start, diff_step=1e-4, x_scale="jac"
    )
    std = np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)))
    assert np.abs(fit.x - right) / std == pytest.approx(0.0, abs=4.0)
    assert np.sqrt(np.mean(fit.fun**2)) == pytest.approx(1.0, abs=0.05)
