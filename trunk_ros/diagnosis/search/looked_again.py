"""The arm looked at again, in the angles, the noise and the clocks that a hypothesis leads to."""

from __future__ import annotations

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.disturbances.arrivals import arrived
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.pace import differ, paced, with_unseen_skew
from trunk_ros.diagnosis.search.fit import Fit, costed, refit
from trunk_ros.diagnosis.search.score import naming, need, score
from trunk_ros.effects import imitated
from trunk_ros.levels import TURNS


def renewed(now: Fit) -> Fit:
    """In the angles and the noise that it leads to, fitted there; in turns with how drives came to their
    stops, where only these were recorded, and with the pace of clocks that differ.
    """
    for _ in range(TURNS):
        looked = now.context.seen_with(now.hypothesis)
        context = paced(arrived(looked, now.hypothesis), now.hypothesis)
        now = _settled(context.weighed(now.hypothesis), now.hypothesis)
        if context is looked:
            break
    return now


def relooked(now: Fit) -> Fit:
    """In the angles that it leads to; what joints share is fitted anew, as a trial on one joint left it."""
    context = now.context.seen_with(now.hypothesis)
    if any(set(term.shared) - term.given for term in now.hypothesis.values()):
        return _settled(context, now.hypothesis)
    return now if context is now.context else costed(context, now.hypothesis)


def _settled(context: Context, hypothesis: Hypothesis) -> Fit:
    """Fitted in a context, or as it is where a fit would lead to values that the motion cannot show."""
    return min(refit(context, hypothesis), costed(context, hypothesis), key=score)


def told_from_clocks(now: Fit) -> Fit:
    """With a skew of two clocks that did not show before the physics was known, also without the effects that
    it looks like or without those that come and go with time, where that scores better by the price of an
    effect, or leaves as little without them: the best of these. What the model has already stays.
    """
    known = now.hypothesis
    new = known.keys() - now.context.known.keys()
    price = naming(now.context.stage.name) + max(need(now.context, c) for c in now.cost)
    like = frozenset(new.intersection(imitated("skew")))
    timed = frozenset(n for n in new if any(map(known[n].moments, (None, *known[n].own))))
    found: list[tuple[float, Fit]] = []
    for gone in dict.fromkeys((timed | like, like, timed, frozenset[str]())):
        hypothesis = Hypothesis({name: term for name, term in known.items() if name not in gone})
        context = with_unseen_skew(now.context, hypothesis)
        if context is None or context.work.over:
            break
        trial = renewed(refit(context, hypothesis))
        alike = costed(trial.context.in_noise(now.context.noise), trial.hypothesis)
        pays = score(alike) + price < score(now) or (gone and alike.total < now.total)
        if pays and differ(trial.context, trial.hypothesis):
            found.append((score(alike), trial))
    return min(found, key=lambda one: one[0], default=(0.0, now))[1]
