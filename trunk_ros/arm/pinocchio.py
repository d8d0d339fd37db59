"""Pinocchio, imported when the first load or tip is asked for."""

from __future__ import annotations

from functools import cache
from typing import Any

from trunk_ros.errors import TrunkError


@cache
def library() -> Any:
    """The module. Raises TrunkError where it is not installed."""
    try:
        import pinocchio
    except ImportError as error:
        raise TrunkError(
            f"load and tip of an arm are computed by Pinocchio, which cannot be imported ({error}): "
            "pip install pin, on Windows conda install -c conda-forge pinocchio"
        ) from None
    return pinocchio
