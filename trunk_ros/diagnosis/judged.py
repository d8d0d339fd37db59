"""One stage searched, and what was found judged on what the fit did not see."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.from_the_start import from_the_start
from trunk_ros.diagnosis.evidence.as_given import as_given
from trunk_ros.diagnosis.evidence.cross_validation import Error
from trunk_ros.diagnosis.evidence.evidence import Evidence, as_unseen, banks_evidence
from trunk_ros.diagnosis.evidence.no_worse import no_worse
from trunk_ros.diagnosis.evidence.one_arm import contradiction
from trunk_ros.diagnosis.evidence.spreads import Spreads, spreads
from trunk_ros.diagnosis.evidence.untold import as_the_surest
from trunk_ros.diagnosis.evidence.veto import believed, harmless
from trunk_ros.diagnosis.evidence.wandering import steadied
from trunk_ros.diagnosis.evidence.without_options import with_likelier_options
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.search.fit import Fit, costed, refit
from trunk_ros.diagnosis.search.long import searched
from trunk_ros.diagnosis.stages.stage import Stage
from trunk_ros.errors import RecordingError
from trunk_ros.heap import give_back


@dataclass(frozen=True)
class Judged:
    """The best hypothesis of a stage with all that speaks for it."""

    state: Fit
    part: Fit
    """The same on what rivals are fitted to: of long recordings an excerpt."""
    found: dict[str, Evidence]
    std: Spreads
    errors: dict[int, Error]
    early: bool
    """Whether the work that was granted ended before the search did, or the evidence was whole."""

    @property
    def context(self) -> Context:
        """What it is judged in."""
        return self.state.context

    def told(self) -> dict[str, Any]:
        """The stage in ``diagnosis.json``."""
        context, joints = self.context, self.context.stage.joints
        return {
            "compared": True,
            "joints": {joints[c]: self._told_of(c, error) for c, error in self.errors.items()},
            "silent": [joint for c, joint in enumerate(joints) if c not in context.columns],
            "search": {"joint_steps": context.work.done, "ended_early": self.early},
        }

    def _told_of(self, column: int, error: Error) -> dict[str, Any]:
        return {
            "unit": self.context.stage.unit(column),
            "rmse_before": error.before,
            "rmse_after": error.after,
            "noise_floor": error.noise_floor,
            "resolution": self.context.steps(column),
            "rmse_before_std": error.before_std,
            "rmse_after_std": error.after_std,
        }


def judged(stage: Stage, settle: float, say: Callable[[str], None]) -> Judged | None:
    """Search, veto, evidence, errors; None where no joint can be judged. Raises RecordingError where
    recordings are not of one arm.
    """
    context = first_look(stage)
    if not context.columns:
        return None
    wrong = contradiction(context, say)
    if wrong is not None:
        raise RecordingError(wrong.statement())
    done = searched(context, say)
    say("evidence")
    context.forget()
    del context  # what it knows of all angles is as much again as what is left of them
    give_back()
    state = as_given(harmless(steadied(done.state)))
    part = state if done.part is done.state else refit(done.part.context, state.hypothesis)
    give_back()
    state, part, found = believed(state, part)
    early = done.early or state.context.work.over
    state = from_the_start(state, settle)
    std = spreads(state)
    hinted = with_likelier_options(state, {name: told.untold for name, told in found.items()})
    surer = as_the_surest(hinted, std)
    kept, errors = no_worse(surer)
    if kept is not state:
        part = kept if part is state else costed(part.context, kept.hypothesis)
        found = {name: told for name, told in found.items() if name in kept.hypothesis}
        std, state = spreads(kept), kept
    found = as_unseen(state, found | banks_evidence(state, found), errors)
    return Judged(state, part, found, std, errors, early)
