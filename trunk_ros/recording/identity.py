"""What tells one recording from another: when it began, how long it is, and a digest of a few samples."""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import blake2b

import numpy as np

from trunk_ros.recording.series import JointSeries

SAMPLES = 64  # spread over the whole
ORDER = ("joint_states", "gearbox_states", "setpoints", "reference")  # the first that is there is read
PLACES = 6  # decimals of s and rad: a conversion may round what is behind them
MARK = "#"  # before the digest; files of earlier versions have none


def digest(series: Mapping[str, JointSeries]) -> str:
    """Eight hex digits of stamps and positions, in whatever order joints come; "" where there are none."""
    shown = next((series[key] for key in ORDER if key in series and len(series[key].stamp)), None)
    if shown is None:
        return ""
    rows = np.unique(np.linspace(0, len(shown.stamp) - 1, SAMPLES).round().astype(int))
    columns = np.argsort(np.array(shown.joints), kind="stable")
    read = np.column_stack([shown.stamp[rows], shown.position[rows][:, columns]])
    text = " ".join(f"{value:.{PLACES}f}" for value in (np.round(read, PLACES) + 0.0).ravel().tolist())
    return blake2b(f"{','.join(sorted(shown.joints))} {text}".encode(), digest_size=4).hexdigest()


def identity(start_ns: int, duration: float, content: str) -> str:
    """As ``recording.of`` of a model has it."""
    when = f"{start_ns}+{round(duration * 1e9)}"
    return f"{when}{MARK}{content}" if content else when


def is_one_of(own: str, others: tuple[str, ...]) -> bool:
    """Whether a recording is one of others; of those without a digest by start and length alone."""
    return own in others or own.partition(MARK)[0] in others
