"""What the plots of a stage hold."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.free_run import free_run
from trunk_ros.diagnosis.hypothesis import Hypothesis


def drawn(context: Context, hypothesis: Hypothesis) -> dict[tuple[str, str], dict[str, Any]]:
    """By stage and joint, of the first span: (n,) s, where it counts, and in single precision what was
    measured, its errors before and after, and what the motor did; and how loud the noise is.
    """
    span, out = context.views[0].span, dict[tuple[str, str], dict[str, Any]]()
    before, after = (free_run(context, one) for one in (context.known, hypothesis))
    for c in context.columns:
        target = span.target[:, c]
        out[context.stage.name, context.joints[c]] = {
            "stamp": span.stamp,
            "valid": span.valid[:, c].copy(),
            "noise": context.noise[c].std,
            "measured": _single(target),
            "error_before": _single(target - before.predict(0, context.known, c)),
            "error_after": _single(target - after.predict(0, hypothesis, c)),
            "gearbox": _single(span.measured(span.gearbox[:, c])),
            "velocity": _single(span.measured(span.velocity[:, c])),
        }
    return out


def _single(values: Array) -> np.ndarray:
    return values.astype(np.float32)
