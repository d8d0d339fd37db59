"""What a model predicts by itself. A fit lets the effects of a stage see what was measured; a simulation has
nothing but its own prediction to show them.
"""

from __future__ import annotations

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis


def free_run(context: Context, hypothesis: Hypothesis) -> Context:
    """The context in which a hypothesis is judged as ``simulate`` runs it: its effects see what it predicts.
    The same one where that makes no difference.
    """
    views = context.stage.free(context, hypothesis)
    if views is context.views:
        return context
    return context.viewing(views)
