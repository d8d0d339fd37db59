"""What a motor without an integral part pulls: the weight, and the friction of the wire."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import TRUNK, diagnose, of_the_servos, recorded


def test_friction_is_found_where_the_weight_alone_explains_next_to_nothing() -> None:
    hidden = {"gain": 0.02, "friction": np.full(5, 0.5), "form": "weight_and_friction"}
    (found,) = diagnose([of_the_servos(recorded({"load_droop": hidden}))], TRUNK).findings
    assert found.effect == "load_droop"
    assert found.parameters["arm"]["gain"]["value"] == pytest.approx(0.02, rel=0.05)
    for joint in found.joints:
        assert found.parameters[joint]["friction"]["value"] == pytest.approx(0.5, rel=0.1)
