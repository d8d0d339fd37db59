"""What a wire still creeps by from before a recording is as far as was measured, and no effect that ends."""

from __future__ import annotations

import numpy as np
import pytest

from test.data.test_align import kept
from test.diagnosis.arms import TRUNK, diagnose, recorded
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.swing import Decays
from trunk_ros.recording.recording import Recording

JOINT, GAIN, CONSTANT, CUT = 1, 0.03, 8.0, 9.0


@pytest.fixture(scope="module")
def cut() -> Recording:
    """An arm that had moved for 9 s, far from where it is then, as the recording begins."""
    gain = np.zeros(5)
    gain[JOINT] = GAIN
    whole = recorded(
        {"viscoelastic_creep": {"gain": gain, "time_constant": CONSTANT}}, seconds=49.0, size=2.0
    )
    return kept(whole, {name: series.stamp > CUT for name, series in whole.series.items()})


@pytest.mark.long
def test_a_creep_that_began_before_the_recording_is_all_that_is_found(cut: Recording) -> None:
    (found,) = diagnose(cut).findings
    assert (found.effect, list(found.joints)) == ("viscoelastic_creep", ["joint_2"])
    assert found.parameters["joint_2"]["gain"]["value"] == pytest.approx(GAIN, rel=0.05)


def test_what_is_left_of_it_goes_no_further_than_motion_like_this_leads_to(cut: Recording) -> None:
    context = first_look(WireStage([wire_span(cut, TRUNK)], TRUNK))
    noise, squares = context.noise[JOINT].std ** 2, []
    for gain in (GAIN, 1e-5):
        term = Term("viscoelastic_creep", "one_mode", {"time_constant": CONSTANT}, {JOINT: {"gain": gain}})
        squares += context.stage.swings(context, 0, Hypothesis({"viscoelastic_creep": term}), JOINT).tolist()
    assert squares[0] > 100.0 * noise
    assert squares[1] < 0.01 * squares[0]


def test_what_dies_away_is_known_by_its_time_constants() -> None:
    stamp = np.array([2.0, 3.0, 5.0])
    ways = Decays(stamp[:1], np.array([2.0, 0.5]), np.array([1.0])).ways(stamp)
    np.testing.assert_allclose(ways, np.exp(-np.array([[0.0, 0.0], [0.5, 2.0], [1.5, 6.0]])))
