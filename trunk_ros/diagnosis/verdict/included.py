"""Effects that are part of another one's form, such as the swing of links on wires that stretch: one law says
both, and both are told.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from trunk_ros.diagnosis.evidence.determined import determined
from trunk_ros.diagnosis.evidence.evidence import Evidence, apart, doubt, likely
from trunk_ros.diagnosis.evidence.spreads import Spreads
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term, bind_column, payload_of
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.fit import Fit, costed_on, refit
from trunk_ros.diagnosis.search.score import SIGNIFICANT, chance, need, needed, score
from trunk_ros.diagnosis.verdict.changes import MODEL, changes
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.diagnosis.verdict.findings import findings
from trunk_ros.effects import effect
from trunk_ros.effects.bank import Bank


def all_findings(state: Fit, found: dict[str, Evidence], std: Spreads, who: str = MODEL) -> list[Finding]:
    """One finding per effect of a hypothesis, and per effect that is part of one, but for what ``who`` has
    already.
    """
    parts, proof, spread = included(state, found, std)
    whole, std = Hypothesis({**state.hypothesis, **parts}), std | spread
    every = findings(state.context, _but_for_the_models(state, whole), found | proof, std, determined(state))
    return changes(state.context, whole, every, std, who)


def names_said(hypothesis: Hypothesis, told: Iterable[Finding]) -> set[str]:
    """The effects of a hypothesis of which something is said, if only of a part of their form."""
    said = {f.effect for f in told}
    return said | {n for n, term in hypothesis.items() if effect(n).includes.get(term.form) in said}


def _but_for_the_models(state: Fit, whole: Hypothesis) -> Hypothesis:
    """Without curves and banks on joints on which the model has the same."""
    out = whole
    for name, known in state.context.known.items():
        if name in whole and (not effect(name).named or issubclass(effect(name), Bank)):
            for column in _kept(state, known):
                out = out.without(name, column)
    return out


def _kept(state: Fit, known: Term) -> list[int]:
    """The joints on which a curve is as the model has it: with the model's own no more is left than chance
    explains, or than is left anyway.
    """
    context, kept = state.context, []
    for c in [c for c in context.judged(known) if c in state.hypothesis[known.effect].own]:
        there = state.hypothesis.copy()
        there.have(c, known)
        lost = costed_on(state, there, c).cost[c] - state.cost[c]
        if lost < max(SIGNIFICANT * chance(context, c), state.rest(c)):
            kept.append(c)
    return kept


def included(
    state: Fit, by: Mapping[str, Evidence], std: Spreads
) -> tuple[Hypothesis, dict[str, Evidence], Spreads]:
    """What the forms of a hypothesis' effects include, on the joints where it shows and where the recordings
    ask for it: the same effect without it is refitted. With its evidence, which is no surer than what speaks
    for the effect that it is part of (``by``), and standard deviations.
    """
    terms, found, spreads = Hypothesis(), dict[str, Evidence](), Spreads()
    before = {effect(name).includes.get(term.form) for name, term in state.context.known.items()}
    for name, term in state.hypothesis.items():
        part = effect(name).includes.get(term.form)
        if part is None or part in state.hypothesis or part in before:
            continue
        without = min((refit(state.context, h) for h in _without(state, name)), key=score)
        gain = {c: without.cost[c] - cost for c, cost in state.cost.items() if c in term.columns}
        told = _told(state, term, part)
        dropped = hidden(state.context, told)
        gain = {
            c: g for c, g in gain.items() if g > need(state.context, c, state.rest(c)) and c not in dropped
        }
        if not gain:
            continue
        terms[part] = Term(part, told.form, own={c: told.own[c] for c in gain})
        sure = min(likely(doubt(state, gain), sum(gain.values()), []), by[name].confidence)
        found[part] = Evidence(gain, needed(state, gain), apart(state, without, gain), confidence=sure)
        spreads |= {key: s for key, s in _spread(state, term, part, std).items() if key[2] in gain}
    return terms, found, spreads


def _without(state: Fit, name: str) -> list[Hypothesis]:
    """The effect in its first form, in each way in which that is looked for."""
    kind, out = effect(name), []
    for option in kind.options(kind.forms[0]):
        plain = state.hypothesis.copy()
        plain[name].reform(kind.forms[0])
        plain[name].shared |= option
        out.append(plain)
    return out


def _told(state: Fit, term: Term, part: str) -> Term:
    """The effect that a term includes, with its values on each joint."""
    form = term.form if term.form in effect(part).forms else ""
    return Term(part, form, own={c: _values(state, term, c) for c in state.context.judged(term)})


def _values(state: Fit, term: Term, column: int) -> dict[str, float]:
    now = state.context.now(0, column, payload_of(state.hypothesis))
    return {name: float(v[0]) for name, v in bind_column(term, column).included(now).items()}


def _spread(state: Fit, term: Term, part: str, std: Spreads) -> Spreads:
    """Standard deviations, from those of the term's own values."""
    out: Spreads = {}
    for c in state.context.judged(term):
        best = _values(state, term, c)
        squares = dict.fromkeys(best, 0.0)
        for name in term.own[c]:
            moved = term.copy()
            moved.own[c][name] += std.get((term.effect, name, c), 0.0)  # or given
            for said, value in _values(state, moved, c).items():
                squares[said] += (value - best[said]) ** 2
        out |= {(part, said, c): float(np.sqrt(square)) for said, square in squares.items()}
    return out
