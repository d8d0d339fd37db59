"""On concealed arms the found model takes the error down to about the encoder's resolution."""

import numpy as np
import pytest

from test.concealed.demo_runs import Arm, drive, followed, other_motion
from test.concealed.nominal import COUNTS_PER_REV
from test.diagnosis.arms import diagnose
from test.nodes.graph import needs_ros

COUNT = 2 * np.pi / COUNTS_PER_REV  # rad

pytestmark = needs_ros


def error(bag):
    """Rms of true joint angle less reference [rad]."""
    wanted, true = followed(bag)
    return np.sqrt(np.mean((true - wanted) ** 2))


@pytest.mark.timeout(400)
@pytest.mark.parametrize(
    ("seed", "effects"),
    [(41_003, "backlash,ratio_error,joint_coupling"), (42_011, "tension_error,zero_offset")],
)
def test_with_the_found_model_the_true_error_is_near_the_encoders_resolution(tmp_path, seed, effects):
    arm = Arm(seed, effects)
    drive(arm, tmp_path / "run", 15, 1)
    diagnose([tmp_path / "run"]).save(tmp_path / "found")
    other_motion(tmp_path / "motion.yaml", 5, 8)
    motion = ("--trajectory", tmp_path / "motion.yaml")
    drive(arm, tmp_path / "before", 8, 2, *motion)
    drive(arm, tmp_path / "after", 8, 3, *motion, "--model", tmp_path / "found" / "model.yaml")
    assert error(tmp_path / "before") > 10 * COUNT
    assert error(tmp_path / "after") < 3 * COUNT
