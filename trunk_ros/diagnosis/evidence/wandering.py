"""Readings that wander: noise of a sensor so slow that it looks like physics, and goes with nothing that the
arm does.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.noise import Noise
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import SEVERAL
from trunk_ros.diagnosis.search.descent import Desk, descend
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.moves import DROP, SWAP, SWAP_ALL
from trunk_ros.diagnosis.search.score import need
from trunk_ros.diagnosis.search.slow_noise import (
    is_plain,
    likelier,
    told,
    unlikely,
    untimed,
    wandering_in,
)
from trunk_ros.diagnosis.work import Work
from trunk_ros.recording.signal.resample import SLOW


def steadied(now: Fit) -> Fit:
    """Without what only follows the readings about, where a noise that wanders explains it as well, and with
    names that hold in that noise. In such noise what moves slowly costs next to nothing: so where what is
    left is not that noise any more, it was none.
    """
    context, found = now.context, dict[int, Noise]()
    if context.step >= SLOW:
        return now
    for column in context.columns:
        less = untimed(now.hypothesis, column)
        timed = less is not now.hypothesis
        if column in context.wanders and not timed:
            continue
        if timed or not is_plain(context, context.noise[column], less, column):
            likely = likelier(context, less, now.hypothesis, column)
            if likely is not None and (timed or not told(context, less, column)):
                found[column] = likely[0]
    again = context.work.besides()
    while both := found | _of_the_others(context, now.hypothesis, {**context.wanders, **found}):
        done = _held(replace(now, context=replace(context, work=again)), both, found)
        wrong = [c for c in found if not is_plain(done.context, done.context.noise[c], done.hypothesis, c)]
        if not wrong:
            context.work.took(again)
            return replace(done, context=replace(done.context, work=context.work))
        found = {c: one for c, one in found.items() if c not in wrong}
    context.work.took(Work(done=again.done))  # no search ended early by it
    return now


def _held(now: Fit, noise: dict[int, Noise], timed: Iterable[int]) -> Fit:
    """With noises of joints, without what only follows the readings of some of them about, and with names
    that hold then.
    """
    bare = now.hypothesis
    for column in timed:
        bare = untimed(bare, column)
    steady = replace(wandering_in(now.context, noise), claims=True)
    return descend(refit(steady, bare), (DROP, SWAP_ALL, SWAP), Desk())


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
        if gain > need(context, column):
            out[column] = usual
    return out
