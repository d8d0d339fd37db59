"""What people would use instead of the tool, on the same recordings, split and score; kept beside the marks.

Each fits the first recording and is judged on the second. They do not know the package: what they gave is
kept under a hash of the plants and of themselves, and stays when the diagnosis changes.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from test.concealed.boosted import Boosted
from test.concealed.codes import others_code
from test.concealed.echo import Echo
from test.concealed.nominal import Array
from test.concealed.refit import Refit, refitted_servo
from test.concealed.seen import Seen, look_at
from test.concealed.symbolic import Symbolic
from test.concealed.whole import write_whole

Marks = dict[str, Any]
METHODS: dict[str, Callable[[Seen], Any]] = {
    "refit": Refit, "boosting": Boosted, "sindy": Symbolic, "echo": Echo,
}  # fmt: skip


def compared(runs: tuple[Path, Path], source: str, clean: Array, noise: float) -> Marks:
    """Errors, rad rms, of every method on the fitted run and on the other, before and after, and s taken.

    clean: noise-free joint angle (n, 5) rad of the second run; noise rad rms is taken off the error on the
    first.
    """
    first, second = (look_at(run, source) for run in runs)
    before = {
        "fitted_before": first.error(first.nominal, None, noise),
        "before": second.error(second.nominal, clean, noise),
    }
    out: Marks = {}
    for name, method in METHODS.items():
        began = time.perf_counter()
        seen = (first, second)
        if name == "refit" and source == "setpoints":
            own = refitted_servo(runs[0])
            seen = (look_at(runs[0], source, own), look_at(runs[1], source, own))
        with threadpool_limits(1):  # a case has one core: more threads only wait for each other
            after = _after(method, seen, clean, noise)
        out[name] = {**before, **after, "seconds": time.perf_counter() - began}
    return out


def _after(method: Callable[[Seen], Any], seen: tuple[Seen, Seen], clean: Array, noise: float) -> Marks:
    try:
        fitted = method(seen[0])
        said = [one.nominal + fitted.residual(one) for one in seen]
    except Exception as error:  # their failure is told, and does not end the proof
        return {"failed": str(error)}
    return {
        "fitted_after": seen[0].error(said[0], None, noise),
        "after": seen[1].error(said[1], clean, noise),
    }


def known(kept: Path) -> Marks | None:
    """Results from before, of the same plants and methods."""
    if not kept.exists():
        return None
    whole: Marks = json.loads(kept.read_text())
    return whole["methods"] if whole["code"] == others_code() else None


def keep(kept: Path, methods: Marks) -> Marks:
    """Writes them down."""
    write_whole(kept, {"code": others_code(), "methods": methods})
    return methods
