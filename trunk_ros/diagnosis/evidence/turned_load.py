"""Load cells whose sign looks turned: their joints give way against the load."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups import MixUp
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.cross_validation import BLOCKS
from trunk_ros.diagnosis.hypothesis import Term
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.score import need
from trunk_ros.effects import effect
from trunk_ros.levels import PART, SURE
from trunk_ros.recording.topics import TOPICS
from trunk_ros.words import significant


def turned_loads(state: Fit, cells: Collection[str]) -> list[MixUp]:
    """A remark for each joint with a load cell (``cells``) that goes by its load the wrong way round, beside
    the names that do not go by it: a wire yields to a load. What has no name may stand for that.
    """
    context, found = state.context, []
    for c in (c for c in context.columns if context.joints[c] in cells):
        names = [t.effect for t in state.hypothesis.on(c) if t.effect not in context.known and _may_stand(t)]
        bare = refit(context, state.hypothesis.less(names, c)) if names else state
        if size := _against(bare, c):
            found.append(_remark(context.joints[c], size, context.stage.unit(c)))
    return found


def _may_stand(term: Term) -> bool:
    """Whether a term may stand for what goes by the load the wrong way round."""
    kind = effect(term.effect)
    return not kind.named or kind.bears(term.form)


def _remark(joint: str, size: float, unit: str) -> MixUp:
    said = (
        f"effort of {TOPICS['joint_states']} of {joint} looks as if its sign were turned: the joint gives "
        f"way against it, by {significant(size, 2)} {unit}/(N*m). A load is positive where it tends to "
        'increase the angle. Turn it in the driver or the mapping ({expr: "0 - column"}), and diagnose again'
    )
    return MixUp("sign", "wire", (joint,), said, certain=False)


def _against(state: Fit, column: int) -> float:
    """How much a column goes against its load [unit/(N m)]; 0 where that is not sure, or hardly any of what
    is left. What goes by its own posture, direction and speed is taken for that.
    """
    context = state.context
    rest = context.whitened(state.hypothesis, column)
    load, *others = (context.whiten_change(parts, column) for parts in _followed(context, column))
    beside = np.column_stack(others)
    load, rest = (each - beside @ np.linalg.lstsq(beside, each, rcond=None)[0] for each in (load, rest))
    power = float(load @ load)
    if power == 0.0:
        return 0.0
    size = float(load @ rest) / power
    left = rest - size * load
    pulled = np.array([part.sum() for part in np.array_split(load * left, BLOCKS)])
    std = float(np.sqrt(BLOCKS / (BLOCKS - 1) * pulled @ pulled)) / power
    gain = size**2 * power
    clear = gain > max(need(context, column), PART * float(rest @ rest))
    return -size if clear and size < -SURE * std else 0.0


def _followed(context: Context, column: int) -> list[list[Array]]:
    """The load by span (n,), and what else it may stand for."""
    out: list[list[Array]] = [[] for _ in range(7)]
    for view in context.views:
        angle, speed = view.angles[:, column], view.speeds[:, column]
        posture = angle, np.sin(angle), np.cos(angle)
        courses = view.load[:, column], np.ones_like(angle), *posture, speed, np.sign(speed)
        for some, course in zip(out, courses, strict=True):
            some.append(view.span.measured(course))
    return out
