"""What gives way without end under weight, such as oil that leaks past a piston, is no curve over time."""

from functools import partial

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import SHORT, of_the_wires
from trunk_ros.simulate import simulate


def test_a_joint_that_sinks_under_its_load_is_found_and_predicts_another_run() -> None:
    flow = {"form": "flow", "flow": arms.on(2, 0.02, joints=3), "upstream": 1.0}
    recorded = partial(arms.recorded, {"viscoelastic_creep": flow}, nominal=SHORT)
    result = arms.diagnose([of_the_wires(recorded())], model=SHORT)
    (found,) = result.findings
    assert (found.effect, found.joints, found.evidence["form"]) == ("viscoelastic_creep", ["joint_2"], "flow")
    assert found.parameters["joint_2"]["flow"]["value"] == pytest.approx(0.02, rel=0.05)
    other = recorded(seed=7, noise=0.0)
    seen, bare, shown = (
        run.series["joint_states"].position[500:, 1]
        for run in (other, simulate(other, SHORT), simulate(other, result.model))
    )
    assert np.std(shown - seen) < 0.05 * np.std(bare - seen)
