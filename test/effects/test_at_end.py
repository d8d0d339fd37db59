"""A model as it is at the end of its recording does what the model did then."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from test.effects.example import arm_of, motion, stamps
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects import effect
from trunk_ros.errors import ModelError
from trunk_ros.model import Model

STAMP = stamps(20, 200)
PHI = motion(STAMP, 3) / 0.625
LATE = STAMP > 15.0

WIRE: dict[str, dict[str, Any]] = {
    "load_elasticity": {"compliance": np.full(3, 0.02)},
    "backlash": {"half_width": np.full(3, 2e-3)},
    "tension_error": {"factor": 3.0},
    "ratio_error": {"relative": np.full(3, 0.02)},
    "load_dependent_friction": {"gain": np.full(3, 0.01)},
    "joint_coupling": {
        "gain": np.full(3, 0.01), "gain_2": np.full(3, 0.02),
        "source": ["joint_2", "joint_1", "joint_1"], "source_2": ["joint_3", "joint_3", "joint_2"],
    },
    "wire_slack": {"compliance": np.full(3, 0.03), "threshold": np.full(3, 0.05), "form": "sharp"},
    "wire_stiffening": {"compliance": np.full(3, 0.03), "moment": np.full(3, 0.1)},
    "wire_slip": {"step": np.full(3, 2e-3), "onset": np.full(3, 5.0)},
    "hard_stop": {"upper": np.full(3, 0.2)},
    "sensor_delay": {"delay": 0.02},
    "viscous_lag": {"time_constant": np.full(3, 0.03)},
}  # fmt: skip
SERVO: dict[str, dict[str, Any]] = {
    "servo_delay": {"delay": 0.02},
    "servo_bandwidth": {"relative": -0.2},
    "load_droop": {"gain": 0.02, "form": "weight"},
    "velocity_saturation": {"v_max": 1.0},
    "cogging": {"amplitude": 2e-3, "cycles_per_rev": 24.0, "phase": np.full(3, 0.5)},
}


def ends_alike(stage: str, name: str, values: dict[str, Any], times: float) -> None:
    """With another size since 8 s the model at its end runs as the model does then."""
    shared = effect(name).moments()[0].shared
    moments = {"from_2": 8.0, "times_2": times}
    again = {k: v if shared else np.full(3, v) for k, v in moments.items()}
    model = Model(arm_of(3, 1e-3), {name: {**values, **again}}, duration=20.0)
    ran, ends, nominal = (_run(stage, m) for m in (model, model.at_end(), Model(arm_of(3, 1e-3), {})))
    far = np.abs(ran - nominal)[LATE].max()
    assert np.abs(ran - ends)[LATE].max() <= 0.02 * far + 1e-9
    assert far > 0.0 or name == "velocity_saturation"  # at half of it the nominal one is not reached


def _run(stage: str, model: Model) -> Array:
    return Chain(model, stage).run(PHI, STAMP)[0]


@pytest.mark.parametrize("times", [2.0, 0.5])
@pytest.mark.parametrize("name", WIRE)
def test_a_wire_ends_as_it_ran(name: str, times: float) -> None:
    ends_alike("wire", name, WIRE[name], times)


@pytest.mark.parametrize("times", [2.0, 0.5])
@pytest.mark.parametrize("name", SERVO)
def test_a_servo_ends_as_it_ran(name: str, times: float) -> None:
    ends_alike("servo", name, SERVO[name], times)


def test_values_of_each_joint_end_as_they_ran() -> None:
    ends_alike("servo", "servo_delay", {"delay": np.full(3, 0.02), "form": "apart"}, 2.0)


def test_a_coupling_that_turns_round_does_so_with_all_of_its_sources() -> None:
    ends_alike("wire", "joint_coupling", WIRE["joint_coupling"], -1.0)


def test_a_size_without_a_moment_is_refused() -> None:
    with pytest.raises(ModelError, match="times_2 needs from_2"):
        Model.from_parameters(
            {"arm.joints": ["a"], "effects.backlash.half_width": [1e-3], "effects.backlash.times_2": [2.0]}
        )
