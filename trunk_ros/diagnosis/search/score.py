"""What a fit is worth: squared residuals, a price for each effect. A move of the search has to lower it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from math import log

import numpy as np

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.disturbances.thrown import rests, room, throws
from trunk_ros.diagnosis.hypothesis import Free, Hypothesis, Term
from trunk_ros.diagnosis.search.candidates import another_law
from trunk_ros.diagnosis.search.credible import unshown
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.formed import FORMULAS, off_by
from trunk_ros.diagnosis.stages.stage import STANDING
from trunk_ros.effects import effect, registry
from trunk_ros.effects.curve import Curve
from trunk_ros.guards import ROUNDED
from trunk_ros.levels import HALF, PART, SLIGHT, SOME, TOGETHER

SIGNIFICANT = 60.0
"""Gain in squared unit-noise residuals below which chance and small misfits are not ruled out."""
RELEVANT = 0.02
"""Share of the noise power that an effect must remove from a joint, however long the recording is."""
SLICE = 0.15
"""Share of a rest as strong as the noise that each value of what will be said must explain."""
FURTHER = SIGNIFICANT / 3.0
"""Price of each further value of an effect, in white noise."""
CURVE = 2.5
"""Price of a curve without a name, in effects."""
BETTER = 2.0
"""Squared unit-noise residuals by which a change has to be better."""
UNSHOWN = 1.0 / ROUNDED
"""Price of an effect on a joint whose motion cannot show it: more than any residual."""


def score(fit: Fit) -> float:
    """Squared residuals and prices: every change of a hypothesis has to lower it."""
    return priced(fit) + UNSHOWN * unshown(fit.context, fit.hypothesis)


def priced(fit: Fit) -> float:
    """The same, whether the motion can show it or not."""
    if not fit.priced:  # asked for again with each trial that it is compared with
        names = sum(price(fit, term) for term in fit.hypothesis.values())
        fit.priced.append(fit.total + names + _throws(fit) + _swings(fit))
    return fit.priced[0]


def prices(context: Context, hypothesis: Hypothesis) -> float:
    """What a hypothesis costs that leaves nothing."""
    return priced(Fit(hypothesis, {}, context))


def beats(trial: Fit, best: Fit) -> bool:
    """Whether a fit is better by more than rounding."""
    return score(trial) < score(best) - BETTER


def need(context: Context, column: int, rest: float = 0.0) -> float:
    """The gain on a column below which nothing is claimed there; ``rest``: what is left above the noise.

    The encoders' steps are an error that stands still with the joint, so they are no noise to be averaged: of
    those of its own, which the other noise shakes loose, a PART is left.
    """
    if column not in context.least_needs:
        context.least_needs[column] = _least_need(context, column)
    return max(context.least_needs[column], SLIGHT * rest)


def needed(fit: Fit, columns: Iterable[int]) -> float:
    """The gain on some columns below which nothing is said there: it is also what the model's own laws may be
    off by. What a loop is off by goes with its lag, and is no measure for names of other shapes.
    """
    context, wire = fit.context, fit.context.stage.name == "wire"
    return sum(max(need(context, c, fit.rest(c)), off_by(context, c) if wire else 0.0) for c in columns)


def _least_need(context: Context, column: int) -> float:
    stage, noise = context.stage, context.noise[column]
    steps, own = context.resolution[column] / noise.std, stage.steps[column] / noise.std
    least = context.count(column) * max(RELEVANT, STANDING * steps**2, PART * own**2)
    formulas = FORMULAS * context.formed_misfit.get(column, 0.0)
    return max(SIGNIFICANT * chance(context, column), least, formulas)


def choice(among: int) -> float:
    """Price of choosing one of so many: what chance gains by it, the logarithm twice."""
    return 2.0 * log(max(among, 1))


@cache
def naming(stage: str) -> float:
    """Price of a name among those of a stage; on several joints it is chosen once."""
    return choice(sum(kind.stage == stage and kind.named and kind.tried for kind in registry().values()))


def chance(context: Context, column: int) -> float:
    """How many times more chance gains on a column than by white noise: as long as a reading stays the same
    it counts once, but chance gains no more than all that steps leave; and of coloured noise the colour is
    known only roughly.
    """
    stage, noise = context.stage, context.noise[column]
    still = stage.own_steps(column) / noise.std
    all_steps = STANDING * context.count(column) / SIGNIFICANT
    return (1.0 + noise.remembers) * max(min(stage.stands[column], all_steps) * still**2, 1.0)


def price(fit: Fit, term: Term) -> float:
    """What a term must gain, over all its joints; a further source counts as a further effect, and so does
    each moment at which it begins or ends.

    What the model has already costs nothing, what it gets besides does.
    """
    context, kind = fit.context, effect(term.effect)
    name, source = naming(kind.stage), choice(len(context.joints) - 1)
    known = context.known.get(term.effect, Term(term.effect))
    more = _besides(term, known) if term.effect in context.known else term
    asked = context.judged(term)
    columns = [c for c in asked if c not in known.own]
    new = [c for c in asked if c in columns or more.own[c] or c in more.words]
    needs = {c: need(context, c, fit.rest(c)) for c in new}
    if not kind.named:
        return sum(_curve(fit, term, c, needs[c]) for c in columns)
    if not asked or not (new or more.shared):
        return 0.0
    free = Hypothesis({term.effect: more}).free(list(term.columns))
    had = {c: len(known.words.get(c, {})) or c in columns for c in new}
    words = sum(needs[c] * max(len(term.words.get(c, {})) - had[c], 0) for c in new)
    words += source * sum(len(more.words.get(c, {})) for c in new)
    moments = _moments(fit, more, needs)
    if not columns:
        lost = sum(len(known.own[c].keys() - term.own[c].keys()) for c in asked)
        return words + moments + _further(context, free, asked, lost + len(known.shared.keys() - term.shared))
    if kind.everywhere:
        usual, says = _usual(fit), 1 + bool(kind.replaces)  # what a law includes, and what it has besides
        each = _further(context, free, columns, 1) - name * len(columns)
        if any(term.moments(c) for c in columns):  # what begins on some joints is each one's own
            usual = sum(needs[c] for c in columns)
            each = _further(context, free, columns, len(columns))
        return says * name + max(says * usual + each, _slice(fit, columns, HALF)) + moments
    values = {c: max(sum(f.column == c for f in free), 1) for c in columns}
    further = _further(context, [f for f in free if f.column is not None], columns, len(columns))
    parts = (max(needs[c], n * _slice(fit, [c], SLICE)) for c, n in values.items())
    return name + sum(parts) + words + further + moments


def _besides(term: Term, known: Term) -> Term:
    """What a term has that the model has not."""
    own = {c: {n: v for n, v in own.items() if n not in known.own.get(c, {})} for c, own in term.own.items()}
    words = {c: set(said.items()) - known.words.get(c, {}).items() for c, said in term.words.items()}
    shared = {n: v for n, v in term.shared.items() if n not in known.shared}
    return replace(term, own=own, shared=shared, words={c: dict(w) for c, w in words.items() if w})


def price_of_change(fit: Fit, name: str) -> float:
    """Of what is said to differ from the model in an effect that it has: of the name once, of each joint, of
    each value that joints share, of another law, and of what that has besides as of further values.
    """
    columns, known, now = fit.context.columns, fit.context.known[name], fit.hypothesis[name]
    more, moments = _besides(now, known), {m.name for m in effect(name).moments()}
    kept = {
        c: {n: v for n, v in own.items() if n in moments or n not in more.own[c]}
        for c, own in now.own.items()
    }
    own = [c for c in known.own.keys() | kept.keys() if known.own.get(c, {}) != kept.get(c, {})]
    shared, here = known.shared.items() ^ now.shared.items(), [c for c in own if c in columns]
    price = FURTHER * sum(len(own.keys() - moments) for own in more.own.values()) + needed(fit, here)
    if elsewhere := len(own) - len(here) + len({n for n, _ in shared}) + another_law(known, now):
        price += elsewhere * float(np.median([needed(fit, [c]) for c in columns]))
    return price + (naming(effect(name).stage) if price else 0.0)


def _further(context: Context, free: list[Free], columns: list[int], paid: int) -> float:
    """Of all values but so many of the cheapest, which are ``paid`` for: each by the chance on its own joint,
    one of all joints by the worst of theirs. So a further joint makes none of the others cheaper.
    """
    most = max((chance(context, c) for c in columns), default=1.0)
    each = [most if f.column is None else chance(context, f.column) for f in free]
    return FURTHER * sum(sorted(each)[paid:])


def by_values(fit: Fit) -> float:
    """Squared residuals, names and values: in these alone accounts differ that say something of the same
    joints.
    """
    context, named = fit.context, [t for t in fit.hypothesis.values() if effect(t.effect).named]
    free = fit.hypothesis.free(context.columns, context.columns)
    return fit.total + naming(context.stage.name) * len(named) + _further(context, free, context.columns, 0)


def with_curves_at_least(now: Fit, bare: Hypothesis, columns: list[int]) -> float:
    """The score that a hypothesis has with curves on some joints which leave nothing there."""
    context, cost = now.context, now.cost | dict.fromkeys(columns, 0.0)
    new = [c for c in columns if c not in context.known.curved]
    least = [CURVE * max(need(context, c), FORMULAS * context.misfit.get(c, 0.0)) for c in new]
    return priced(replace(now, hypothesis=bare, cost=cost)) + sum(least)


def _curve(fit: Fit, term: Term, column: int, need: float) -> float:
    """Of a curve: more than of an effect, and as much as it leaves beyond what the noise is known to, so that
    one that leaves most of a misfit does not stand for it; what moves slowly is imitated by any curve over
    time.
    """
    kind = effect(term.effect)
    over = kind.leaves(term.words.get(column, {})) if issubclass(kind, Curve) else 1.0
    left = fit.beyond_noise(column)
    return max(CURVE * need, CURVE * FORMULAS * fit.context.misfit.get(column, 0.0), left * (1 / over - 1))


def _moments(fit: Fit, term: Term, needs: dict[int, float]) -> float:
    """Of the times at which a term begins and ends: each is a claim of its own, or of several joints at once;
    and as what comes and goes with time imitates much, none is made where what is left is known to be
    incomplete.
    """
    kind, context = effect(term.effect), fit.context
    left = {c: for_a_time(context, c, fit.cost.get(c, 0.0)) for c in needs}
    names = sorted({name for c in needs for name in term.moments(c)})
    times = [[(term.own[c][name], n) for c, n in needs.items() if name in term.own[c]] for name in names]
    own = sum(map(_apart, times)) + sum(left[c] for c in needs if term.moments(c))
    shared = sum(m.moment and m.name in term.shared for m in kind.moments())
    if not shared:
        return own
    return own + _usual(fit) * shared + sum(left.values())


def _usual(fit: Fit) -> float:
    """What is needed of all joints together: what the middle one needs, and what formulas are off by in the
    mean, each joint counting by what is to explain of it: what explains one joint is not cheaper on all.
    """
    context = fit.context
    misfits = np.array([context.formed_misfit.get(c, 0.0) for c in context.columns])
    most = float(misfits @ misfits) / max(float(misfits.sum()), ROUNDED)
    usual = float(np.median([need(context, c, fit.rest(c)) for c in context.columns]))
    return max(usual, FORMULAS * most)


def _throws(fit: Fit) -> float:
    """Of how far joints that rest were thrown: each is a value that was fitted, and one more for each small
    part of the dead band, as what shakes an arm moves them little; none costs more than it gains.
    """
    context, total = fit.context, 0.0
    for c in (c for c, left in fit.cost.items() if left > 0.0):
        part, likely = PART * room(context.arm, c), chance(context, c)
        for index, view in enumerate(context.views):
            if len(found := rests(view, fit.hypothesis, c)):  # no work of the search, see credible._jumps
                predicted = context.stage.predict(context, index, fit.hypothesis, c)
                for throw in throws(view, c, found, predicted):
                    gain = throw.seen * (throw.far / context.noise[c].std) ** 2 / likely
                    total += min(gain, FURTHER * likely * (1.0 + abs(throw.far) / part))
    return total


def _swings(fit: Fit) -> float:
    """Of free swings that nothing foretold: two values each, and none costs more than it gains."""
    context, total = fit.context, 0.0
    for c in (c for c, left in fit.cost.items() if left > 0.0):
        likely = chance(context, c)
        for index in range(len(context.views)):  # no work of the search, see credible._jumps
            gains = context.stage.swings(context, index, fit.hypothesis, c) / context.noise[c].std ** 2
            total += float(np.sum(np.minimum(gains / likely, 2.0 * FURTHER * likely)))
    return total


def _apart(times: list[tuple[float, float]]) -> float:
    """Of times [s] on several joints, each with its price: what happens on several at once is one event, of
    which one joint tells the others: that which asks most.
    """
    total, first, most = 0.0, -np.inf, 0.0
    for at, price in sorted(times):
        if at - first > TOGETHER:
            total, first, most = total + most, at, 0.0
        most = max(most, price)
    return total + most


def for_a_time(context: Context, column: int, left: float) -> float:
    """What is charged on a column for what does not always act, beside squared residuals so far ``left``."""
    return (1 / SOME - 1) * max(left - 2.0 * context.count(column), 0.0)


def may_be_for_a_time(context: Context, left: dict[int, float], gain: float) -> bool:
    """Whether what does not always act may pay where so much is ``left`` of columns' squared residuals, if it
    has a ``gain`` there.
    """
    stays = max(1.0 - gain / max(sum(left.values()), gain), 0.0)
    return sum(for_a_time(context, c, stays * before) for c, before in left.items()) < gain


def _slice(fit: Fit, columns: list[int], share: float) -> float:
    """A share of what is left on columns where that is as strong as the noise: a hypothesis is known to be
    incomplete there, and what will be said has to explain so much.
    """
    rest = sum(map(fit.rest, columns))
    strong = fit.context.claims and rest > sum(map(fit.context.count, columns))
    return share * rest if strong else 0.0
