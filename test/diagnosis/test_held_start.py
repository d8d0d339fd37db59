"""Where a joint lies at first is told by all that is read while its friction holds it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from test.diagnosis.arms import NOISE, TRUNK, setpoints_of
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.disturbances.stood import Read, _lies, _middle
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import hypothesis_of
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.wire.presliding_hysteresis import PreslidingHysteresis
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries, Recording

STEPS, BEGIN, RESTS = 4000, 1000, slice(1000, 2500)
RESTING = 3
SOFT = {"load_elasticity": {"compliance": np.full(5, 0.01)}}


def left(effects: dict[str, Any], seed: int) -> Array:
    """What the truth leaves of a joint that rests somewhere in its dead band, while the others move and so
    change its load.
    """
    stamp = 0.01 * np.arange(STEPS)
    phi = setpoints_of(0.01 * STEPS, 5, seed)
    phi[RESTS.start - 100 : RESTS.stop, RESTING] = phi[RESTS.start - 100, RESTING]
    phi[RESTS.stop :, RESTING] += phi[RESTS.stop - 1, RESTING] - phi[RESTS.stop, RESTING]
    theta, _ = Chain(Model(TRUNK.arm, effects), "wire").run(phi, stamp)
    read = theta + NOISE * np.random.default_rng(seed).normal(size=theta.shape)
    series = {
        "gearbox_states": JointSeries(stamp[BEGIN:] - stamp[BEGIN], TRUNK.arm.joints, phi[BEGIN:]),
        "joint_states": JointSeries(stamp[BEGIN:] - stamp[BEGIN], TRUNK.arm.joints, read[BEGIN:]),
    }
    recording = Recording("made", 0, float(stamp[-1] - stamp[BEGIN]), series)
    context = first_look(WireStage([wire_span(recording, TRUNK)], TRUNK))
    truth = hypothesis_of(effects, "wire", 5)
    seen = replace(context, look=context.look + 1).seen_with(truth)
    rests = slice(0, RESTS.stop - BEGIN - 1)
    return np.asarray(seen.views[0].span.target[rests, RESTING] - seen.predict(0, truth, RESTING)[rests])


@pytest.mark.parametrize("upstream", [0.0, 1.0])
def test_it_lies_where_it_was_read_whatever_pulls_meanwhile(upstream: float) -> None:
    for seed in range(3):
        off = left({"load_elasticity": {**SOFT["load_elasticity"], "upstream": upstream}}, seed)
        assert abs(off.mean()) < 0.2 * NOISE
        assert off.std() == pytest.approx(NOISE, rel=0.1)


@pytest.mark.parametrize("form", [form for form in PreslidingHysteresis.forms if form != "bristles"])
def test_a_rounded_friction_lies_where_it_was_read(form: str) -> None:
    """What had led it there is further away: it comes back by a part of the way at once."""
    values: dict[str, Any] = {"form": form, "width": np.full(5, 1.5e-3)}
    if form == "compliant":
        values["through"] = np.full(5, 0.2)
    off = left({"presliding_hysteresis": values}, 1)
    assert abs(off.mean()) < 0.2 * NOISE


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=40))
def test_the_middle_of_a_few_values_is_their_median(values: list[float]) -> None:
    assert _middle(np.array([*values, 9.0]), len(values)) == pytest.approx(np.median(values), abs=1e-15)


def test_what_was_read_is_told_until_each_moment_and_since_the_one_before() -> None:
    read = Read.of(np.array([1.0, 3.0, 2.0, 9.0]), np.array([1, 3, 4]), np.array([0, 1, 3]))
    assert read.until.tolist() == [1.0, 2.0, 2.5]
    assert read.since.tolist() == [1.0, 2.5, 9.0]


@pytest.mark.parametrize("sharp", [True, False])
def test_a_joint_lies_as_it_was_read_while_its_play_holds_it(sharp: bool) -> None:
    """What comes to it moves early, by less than a sharp play is wide: all readings tell where it lies then,
    and else those until it moved.
    """
    width, lies, soon = np.full((1, 1), 1e-3), 4e-4, 5e-4
    u = np.where(np.arange(21) > 2, 4e-4, 0.0)[:, None]
    shown, until, since, off = np.zeros((21, 1)), np.full(21, soon), np.full(21, lies), np.empty(1)
    _lies(u, width, shown, shown, until, since, sharp, off)
    assert off[0] == pytest.approx(lies if sharp else soon, abs=1e-12)
    _lies(u, width, shown, shown, until + 0.01, since, sharp, off)  # beyond its play: nothing holds it there
    assert off[0] == pytest.approx(soon + 0.01, abs=1e-12)
