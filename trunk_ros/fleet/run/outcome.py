"""What one recording gives: a row of the store, with its findings and errors inside."""

from __future__ import annotations

from typing import Any, TypeAlias

import pyarrow as pa

Row: TypeAlias = dict[str, Any]

FINDING = pa.struct(
    [
        ("stage", pa.string()), ("joint", pa.string()), ("effect", pa.string()), ("parameter", pa.string()),
        ("value", pa.float64()), ("std", pa.float64()), ("unit", pa.string()), ("confidence", pa.float64()),
        ("word", pa.string()), ("form", pa.string()), ("equivalents", pa.list_(pa.string())),
    ]
)  # fmt: skip
"""One value of a finding; ``word``: a value that is none, such as the source of a coupling."""
ERROR = pa.struct(
    [
        ("stage", pa.string()), ("joint", pa.string()), ("unit", pa.string()), ("rmse_before", pa.float64()),
        ("rmse_after", pa.float64()), ("noise_floor", pa.float64()), ("verdict", pa.string()),
    ]
)  # fmt: skip
TRAVEL = pa.struct([("joint", pa.string()), ("metres", pa.float64())])
OUTCOME = pa.schema(
    [
        ("arm", pa.string()), ("time", pa.float64()), ("recording", pa.string()), ("path", pa.string()),
        ("content", pa.string()), ("setting", pa.string()), ("reason", pa.string()), ("cpu", pa.float64()),
        ("findings", pa.list_(FINDING)), ("errors", pa.list_(ERROR)), ("travel", pa.list_(TRAVEL)),
    ]
)  # fmt: skip
"""``reason``: why there is no result, "" where there is one; ``cpu``: s that it took."""
WHICH = ("arm", "time", "recording", "path")
FINDINGS = (*WHICH, "stage", "joint", "effect", "parameter", "value", "std", "unit", "confidence")
ERRORS = (
    *WHICH, "stage", "joint", "unit", "rmse_before", "rmse_after", "noise_floor", "verdict",
)  # fmt: skip


def unread(reason: str) -> Row:
    """The outcome of a recording that gave nothing."""
    return {"reason": reason, "cpu": 0.0, "findings": [], "errors": [], "travel": []}
