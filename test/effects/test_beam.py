"""A link that bends: its tip swings, by more or less than the link is sent."""

from __future__ import annotations

import numpy as np

from test.diagnosis.arms import diagnose
from trunk_ros.chain import Chain
from trunk_ros.effects.swing import stops
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import Recording

STAMP = np.arange(0.0, 20.0, 0.01)
MOVES = 0.3 * np.sin(3.7 * STAMP) + 0.1 * np.sin(4.3 * STAMP)
BEGINS = np.minimum(STAMP / 2.0, 1.0)
SENT = BEGINS**3 * (10.0 - 15.0 * BEGINS + 6.0 * BEGINS**2) * MOVES
ARM = load_model("direct").for_joints(("link",)).arm


def chain(share: float) -> Chain:
    values = {"form": "beam", "frequency": [3.4], "damping": [0.01], "share": [share]}
    return Chain(Model(ARM, {"link_resonance": values}), "wire")


def test_the_ringing_of_a_tip_that_swings_further_than_it_is_sent_is_undone_in_a_stable_way() -> None:
    asked, _ = chain(1.44).invert(SENT[:, None], STAMP)
    assert np.abs(asked).max() < 2.0 * np.abs(SENT).max()
    late = STAMP > 2.0
    off = [np.std(chain(1.44).run(u, STAMP)[0][late, 0] - SENT[late]) for u in (asked, SENT[:, None])]
    assert off[0] < 0.5 * off[1]


def test_a_beam_whose_tip_swings_further_is_found_on_a_motor_that_never_stands() -> None:
    sent = np.minimum(STAMP, 1.0) ** 3 * MOVES  # its speed jumps once, and the tip rings after it
    assert not len(stops(STAMP, sent))
    tip, _ = chain(1.44).run(sent[:, None], STAMP)
    tip += np.random.default_rng(0).normal(0.0, 1e-3, tip.shape)
    made = Recording.from_arrays(STAMP, sent[:, None], tip, joints=["link"])
    (found,) = diagnose(made, model="direct").findings
    assert (found.effect, found.evidence["form"]) == ("link_resonance", "beam")
    assert abs(found.parameters["link"]["share"]["value"] - 1.44) < 0.05
