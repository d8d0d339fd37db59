"""What a joint does not tell of an effect is as on the joint that tells it best: values that do not matter in
one recording may matter in the next.
"""

from __future__ import annotations

from trunk_ros.diagnosis.evidence.spreads import Spreads
from trunk_ros.diagnosis.search.credible import unshown
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.diagnosis.search.moves.like import Alike, effects_of_several
from trunk_ros.diagnosis.search.score import FURTHER, chance
from trunk_ros.effects import effect


def as_the_surest(state: Fit, std: Spreads) -> Fit:
    """With values near those of the joint that shows an effect most, on joints of which one value is as
    uncertain as it is large: as long as they are no worse off by more than a further value has to gain.
    """
    for one in effects_of_several(state):
        for column in [c for c in one.columns if _is_untold(state, one, c, std)]:
            there = one.on(column, state.hypothesis)
            if there is None:
                continue
            trial = refit_column(state, there, column)
            shown = unshown(state.context, trial.hypothesis) <= unshown(state.context, state.hypothesis)
            if shown and trial.cost[column] < state.cost[column] + FURTHER * chance(state.context, column):
                state = trial
    return state


def _is_untold(state: Fit, one: Alike, column: int, std: Spreads) -> bool:
    own = state.hypothesis[one.name].own[column]
    sizes = {n: abs(own[n] - effect(one.name).parameter(n).absent) for n in one.names if n in own}
    return any(std.get((one.name, n, column), 0.0) > size for n, size in sizes.items())
