"""What was found on a joint stays only where all of it together is no worse than nothing."""

from __future__ import annotations

from trunk_ros.diagnosis.evidence.cross_validation import Error, held_out
from trunk_ros.diagnosis.search.fit import Fit, refit


def no_worse(state: Fit) -> tuple[Fit, dict[int, Error]]:
    """Without what was found on joints that are surely further off with it, on blocks that the fit has not
    seen, than the model that was given; and the errors of each joint. Noise that remembers for long may let
    every name pass by itself.
    """
    errors = held_out(state)
    while columns := [c for c, e in errors.items() if _is_worse(e) and _found(state, c)]:
        out = state.hypothesis
        for column in columns:
            out = out.less(_found(state, column), column)
        state = refit(state.context, out)
        errors = held_out(state)
    return state, errors


def _is_worse(error: Error) -> bool:
    """In the mean for sure, and usually: a fit to half of the blocks may know nothing of another one."""
    return min(error.after - error.after_std, error.usual) > error.before + error.before_std


def _found(state: Fit, column: int) -> list[str]:
    """What the model that was given does not have on a joint."""
    return [term.effect for term in state.hypothesis.on(column) if term.effect not in state.context.known]
