"""Dead bands that the model has wider than the arm, on one joint alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_wires, recorded
from trunk_ros.model import Model


@pytest.mark.parametrize(("times", "less"), [(2.0, 0.5), (1.25, 0.2)])
def test_a_dead_band_that_is_told_too_wide_on_one_joint_is_no_creep(times: float, less: float) -> None:
    """Creep before the friction, of nothing and under friction alone, had let the wire play less."""
    told = SHORT.arm.dead_band * np.where(np.arange(len(SHORT.arm.joints)) == 1, times, 1.0)
    result = diagnose(
        [of_the_wires(recorded({}, nominal=SHORT))], model=Model(replace(SHORT.arm, dead_band=told))
    )
    (found,) = result.findings
    assert (found.effect, found.joints, result.verdict) == ("narrow_band", [SHORT.arm.joints[1]], "explained")
    assert found.parameters[found.joints[0]]["less"]["value"] == pytest.approx(less, abs=0.05)
