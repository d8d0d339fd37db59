"""Wires that creep before the friction, as a rope in its conduit does, in more than one time."""

from functools import partial

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import SHORT, of_the_wires
from trunk_ros.simulate import simulate


@pytest.mark.long
def test_a_wire_that_creeps_before_the_friction_in_two_times_is_found_and_predicts_another_run() -> None:
    """Two times behind the friction would leave 4 % of it on another run."""
    sizes = {"gain": 0.04, "share_2": 0.5, "rubbing": 0.3}
    each = {name: arms.on(2, size, joints=3) for name, size in sizes.items()}
    creep = {"form": "upstream_two_modes", **each, "time_constant": 6.0, "time_constant_2": 0.7}
    recorded = partial(arms.recorded, {"viscoelastic_creep": creep}, nominal=SHORT, seconds=60.0)
    result = arms.diagnose([of_the_wires(recorded())], model=SHORT)
    (found,) = result.findings
    assert (found.effect, found.joints) == ("viscoelastic_creep", ["joint_2"])
    assert found.evidence["form"] == "upstream_two_modes"
    shared = found.parameters["arm"]
    times = sorted(shared[name]["value"] for name in ("time_constant", "time_constant_2"))
    assert times == pytest.approx([0.7, 6.0], rel=0.2)
    other = recorded(seed=7, noise=0.0)
    seen, bare, shown = (
        run.series["joint_states"].position[500:, 1]
        for run in (other, simulate(other, SHORT), simulate(other, result.model))
    )
    assert np.std(shown - seen) < 0.01 * np.std(bare - seen)
