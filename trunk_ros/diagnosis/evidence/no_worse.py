"""What was found on a joint stays only where all of it together is no worse than nothing; what has no name
only where it is better.
"""

from __future__ import annotations

from trunk_ros.diagnosis.evidence.cross_validation import Error, held_out
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.effects import effect


def no_worse(state: Fit) -> tuple[Fit, dict[int, Error]]:
    """Without what was found on joints that are surely further off with it, on blocks that the fit has not
    seen, than the model that was given, and without what has no name where joints are not nearer with it; and
    the errors of each joint. Noise that remembers for long may let every name pass by itself.
    """
    errors = held_out(state)
    while idle := {c: names for c, e in errors.items() if (names := _of_no_use(state, c, e))}:
        out = state.hypothesis
        for column, names in idle.items():
            out = out.less(names, column)
        state = refit(state.context, out)
        errors = held_out(state)
    return state, errors


def _of_no_use(state: Fit, column: int, error: Error) -> list[str]:
    """What goes from a column. A curve without a name is no physics, and says nothing of another motion where
    it does not of other blocks of this one: in time it can follow anything.
    """
    found = _found(state, column)
    if _is_worse(error):
        return found
    return [name for name in found if not effect(name).named] if error.after >= error.before else []


def _is_worse(error: Error) -> bool:
    """In the mean for sure, and usually: a fit to half of the blocks may know nothing of another one."""
    return min(error.after - error.after_std, error.usual) > error.before + error.before_std


def _found(state: Fit, column: int) -> list[str]:
    """What the model that was given does not have on a joint."""
    return [term.effect for term in state.hypothesis.on(column) if term.effect not in state.context.known]
