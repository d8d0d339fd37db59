"""A simulated arm that goes on by another model: its joints stay where they are."""

from dataclasses import replace

import numpy as np
import pytest

from trunk_ros.model import load_model
from trunk_ros.nodes.arm.wire import Wire

NOMINAL = load_model("trunk")
SOFT = {
    "load_elasticity": {"compliance": np.full(5, 3e-3), "upstream": 1.0},
    "zero_offset": {"offset": np.array([0.0, 5e-3, 0.0, 0.0, 0.0])},
}


def model(width):
    return replace(NOMINAL, effects=SOFT | {"backlash": {"half_width": np.full(5, width)}})


@pytest.mark.parametrize(("before", "after"), [(1e-3, 4e-3), (4e-3, 4e-3)])
def test_a_joint_that_hangs_on_its_wire_does_not_move_when_its_backlash_grows(before, after):
    wire, stamp = Wire(model(before)), 0
    for angle in np.linspace(0.0, 0.3, 50):
        stamp += 10**7
        last = wire.update(stamp, np.full(5, angle)).joints
    wire.swap(model(after))
    np.testing.assert_allclose(wire.update(stamp + 10**7, np.full(5, 0.3)).joints, last, atol=1e-6)
