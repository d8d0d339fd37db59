"""Readings that wander: noise of a sensor so slow that it looks like physics, and goes with nothing that the
arm does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from trunk_ros.data.noise import Noise
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.candidates import open_kinds
from trunk_ros.diagnosis.search.descent import Desk, descend
from trunk_ros.diagnosis.search.fit import Fit, costed_on, refit, refit_column
from trunk_ros.diagnosis.search.moves import DROP, SWAP, SWAP_ALL
from trunk_ros.diagnosis.search.of_the_arm import of_the_arm, untimed
from trunk_ros.diagnosis.search.score import need
from trunk_ros.diagnosis.search.slow_noise import (
    is_plain,
    likelier,
    likeliest_noise,
    told,
    unlikely,
    wandering_in,
)
from trunk_ros.diagnosis.search.trial import looks
from trunk_ros.levels import REFITTED, SEVERAL
from trunk_ros.recording.signal.resample import SLOW


def steadied(now: Fit) -> Fit:
    """Without what only follows the readings about, where a noise that wanders explains it as well, and with
    names that hold in that noise. In such noise what moves slowly costs next to nothing: so where what is
    left is not that noise any more, it was none.
    """
    context, found, bare = now.context, dict[int, Noise](), dict[int, Hypothesis]()
    if context.step >= SLOW:
        return now
    again = context.work.besides()
    on_top = now.working(again)
    for column in context.columns:
        less = bare[column] = _bare(on_top, column)
        timed = less is not now.hypothesis
        if column in context.wanders and not timed:
            continue
        if timed or not is_plain(context, context.noise[column], less, column):
            likely = likelier(context, less, now.hypothesis, column)
            if likely is None or (not timed and told(context, less, column)):
                continue
            if of_the_arm(context, less, column, likely[0]):
                continue
            if likely[1] > need(context, column) * len(less.new_on(column, now.hypothesis)):
                found[column] = likely[0]
    while both := found | _of_the_others(context, now.hypothesis, {**context.wanders, **found}):
        done = _held(on_top, both, {c: bare[c] for c in found})
        wrong = [c for c in found if not is_plain(done.context, done.context.noise[c], done.hypothesis, c)]
        if not wrong:
            context.work.took(again)
            return done.working(context.work)
        found = {c: one for c, one in found.items() if c not in wrong}
    context.work.took(Work(done=again.done))  # no search ended early by it
    return now


def _bare(now: Fit, column: int) -> Hypothesis:
    """Without what only follows the readings of a column about. It may have held what has a name, such as a
    constant: with that, where it always acts and the noise that is left is likelier by the price of a name.
    """
    context, less = now.context, untimed(now.hypothesis, column)
    if less is now.hypothesis or context.work.over:
        return less
    plain = costed_on(now, less, column)
    kinds = [kind for kind in open_kinds(context, less, column) if kind.regime != "time"]
    able = (
        look
        for look in looks(context, less, column, kinds)
        if not any(term.moments(column) for term in look.hypothesis.new_on(column, less))
    )
    best = sorted(able, key=lambda look: -look.gain)[:REFITTED]
    trials = [refit_column(plain, there, column) for there in (less, *(look.hypothesis for look in best))]
    costs = [likeliest_noise(context, trial.hypothesis, column)[1] for trial in trials]
    costs[0] -= need(context, column)
    chosen = costs.index(min(costs))
    return trials[chosen].hypothesis if chosen else less


def _held(now: Fit, noise: dict[int, Noise], bare: Mapping[int, Hypothesis]) -> Fit:
    """With noises of joints, with those that are ``bare`` of curves over time, and with names that hold
    then.
    """
    steady = replace(wandering_in(now.context, noise), claims=True)
    return descend(refit(steady, _put_together(now.hypothesis, bare)), (DROP, SWAP_ALL, SWAP), Desk())


def _put_together(found: Hypothesis, bare: Mapping[int, Hypothesis]) -> Hypothesis:
    """Without the curves over time on joints that are ``bare`` of them, with what these have in their place,
    as far as other joints have it in the same form.
    """
    out = found.copy()
    for column, there in bare.items():
        out = untimed(out, column)
        for term in there.new_on(column, out):
            if term.effect not in out or out[term.effect].form == term.form:
                out.have(column, term)
    return out


def _of_the_others(context: Context, hypothesis: Hypothesis, found: dict[int, Noise]) -> dict[int, Noise]:
    """The middle one of several noises that were ``found``, on joints that show more than their own, where it
    is likelier by more than the price of a name: sensors of one unit are alike.
    """
    out = {}
    for column in [c for c in context.columns if c not in found]:
        donors = [noise for c, noise in found.items() if context.stage.unit(c) == context.stage.unit(column)]
        known = context.noise[column]
        if len(donors) < SEVERAL or is_plain(context, known, hypothesis, column):
            continue
        usual = sorted(donors, key=lambda noise: noise.std)[(len(donors) - 1) // 2]
        gain = unlikely(context, known, hypothesis, column) - unlikely(context, usual, hypothesis, column)
        if gain > need(context, column) and not of_the_arm(context, hypothesis, column, usual):
            out[column] = usual
    return out
