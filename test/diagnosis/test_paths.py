"""Loops that change with the posture follow a joint that is dragged, and lead back to where it came from."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import on, recorded
from test.effects.example import arm_of
from trunk_ros.chain import Chain
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.discrepancy.memory import drawn, redrawn_banks, sources
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.bank import PATH_OF
from trunk_ros.effects.wire.unknown_loops import UnknownLoops
from trunk_ros.model import Model, load_model

T = np.arange(0.0, 40.0, 0.05)
MOTION = np.column_stack([0.3 * np.sin(0.4 * T) + 0.1 * np.sin(1.7 * T), 0.4 * np.sin(0.9 * T)]) / 0.625
COUPLED = {"joint_coupling": {"gain": np.array([0.3, 0.0]), "source": ["joint_2", ""]}}
WEIGHTS = np.zeros(UnknownLoops.weights)
WEIGHTS[[4, 12 + 4 * 7]] = 5e-3, -3e-3  # rad: one contact, and how it changes with the posture


def loops(columns: int, at: int, word: str) -> dict[str, object]:
    """Loops of one joint, as a model holds them."""
    own = {f"weight_1_{i}": on(at + 1, float(w))[:columns] for i, w in enumerate(WEIGHTS, start=1) if w}
    words = [word if k == at else "" for k in range(columns)]
    return own | {"low_1": np.full(columns, -0.6), "high_1": np.full(columns, 0.6), "source": words}


def run(word: str, coupled: bool = True) -> tuple[Chain, np.ndarray]:
    """The chain and its joints' angles; joint 1 has loops over a word."""
    effects = {"unknown_loops": loops(2, 0, word)} if word else {}
    chain = Chain(Model(arm_of(2), {**effects, **(COUPLED if coupled else {})}), "wire")
    return chain, chain.run(MOTION, T)[0]


def test_a_path_is_where_the_effects_before_take_the_joint() -> None:
    plain, dragged = run("")[1][:, 0], run(PATH_OF + "joint_1")[1][:, 0]
    added = UnknownLoops.shapes(plain, -0.6, 0.6) @ WEIGHTS
    np.testing.assert_allclose(dragged, plain + added, atol=1e-12)
    assert np.abs(dragged - run("joint_1")[1][:, 0]).max() > 1e-3


def test_the_motors_that_a_path_needs_are_found() -> None:
    chain, shown = run(PATH_OF + "joint_1")
    led = chain.invert(shown, T)[0]
    np.testing.assert_allclose(chain.run(led, T)[0], shown, atol=2e-5)


@pytest.mark.parametrize("coupled", [True, False])
def test_loops_are_over_the_path_of_a_joint_that_is_dragged(coupled: bool) -> None:
    word = PATH_OF + "joint_4" if coupled else "joint_4"
    names = {"joint_coupling": {"gain": on(4, 0.3), "source": ["", "", "", "joint_2", ""]}} if coupled else {}
    nominal = load_model("trunk")
    context = begun(
        first_look(
            WireStage([wire_span(recorded({**names, "unknown_loops": loops(5, 3, word)}), nominal)], nominal)
        )
    ).context
    bare = Hypothesis()
    if coupled:
        bare["joint_coupling"] = Term(
            "joint_coupling", own={3: {"gain": 0.3}}, words={3: {"source": "joint_2"}}
        )
    found = [source for source in sources(context, 3) if source.kind is UnknownLoops]
    out = drawn(context, bare, 3, found)
    assert out.get_words("unknown_loops", 3) == (word,)
    before, after = (float(np.mean(context.whitened(h, 3) ** 2)) for h in (bare, out))
    assert after < 0.1 * before
    again = redrawn_banks(context, bare, 3, out)
    assert again.get_words("unknown_loops", 3) == (word,)
    assert float(np.mean(context.whitened(again, 3) ** 2)) == pytest.approx(after, rel=0.2)
