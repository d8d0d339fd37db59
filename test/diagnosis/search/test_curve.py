"""When a curve without a name takes the place of names."""

from __future__ import annotations

import numpy as np

from test.diagnosis.arms import NOISE, TRUNK, recorded, reshaped
from test.diagnosis.search.looks import best_of
from trunk_ros.chain import Chain
from trunk_ros.diagnosis.data.align import wire_span
from trunk_ros.diagnosis.discrepancy.memory import in_banks, source_of
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import LITTLE
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.moves import CURVE
from trunk_ros.diagnosis.wire import WireStage
from trunk_ros.effects.bank import WEIGHTS
from trunk_ros.effects.wire.coupling_curve import CouplingCurve
from trunk_ros.recording.recording import Recording


def _worn() -> Recording:
    """The encoder disc of joint 4 has waves, and joint 3 moves nearly as joint 4 does."""
    made = recorded(seconds=40.0, size=1.6)
    gearbox, stamp = made.series["gearbox_states"].position.copy(), made.series["gearbox_states"].stamp
    gearbox[:, 2] = 0.1 * gearbox[:, 1] - 1.3 * gearbox[:, 3]
    angles = Chain(TRUNK, "wire").run(gearbox, stamp)[0]
    angles[:, 3] += 1.2e-3 * np.sin(5.0 * angles[:, 3]) + 0.7e-3 * np.sin(11.0 * angles[:, 3] + 1.0)
    angles += NOISE * np.random.default_rng(2).standard_normal(angles.shape)
    made = reshaped(made, "gearbox_states", position=gearbox, velocity=np.gradient(gearbox, stamp, axis=0))
    return reshaped(made, "joint_states", position=angles)


def test_a_curve_of_the_joint_itself_wins_over_one_of_a_joint_that_moves_nearly_alike() -> None:
    """Neither has a form to be off by: what explains more is said."""
    first = begun(first_look(WireStage([wire_span(_worn(), TRUNK)], TRUNK)))
    source = source_of(first.context, 3, CouplingCurve, "joint_3")
    assert source is not None
    bent = in_banks(Hypothesis(), 3, [source], [np.zeros(WEIGHTS)])
    bent["coupling_curve"].given = frozenset()
    now = refit(first.context, bent)
    assert now.rest(3) < LITTLE * now.context.misfit[3]
    drawn = best_of(CURVE, now)
    assert drawn is not None
    assert drawn.hypothesis["unknown"].words == {3: {"on": "position"}}
