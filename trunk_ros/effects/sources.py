"""Joints that another joint's effect goes by, as a model names them."""

from __future__ import annotations

from collections.abc import Sequence

from trunk_ros.errors import ModelError

STANDS = 0.03  # of the motion of the joint that moves most: a source that moves less


def check_source(name: str, text: str, joint: str, word: str, choice: Sequence[str]) -> None:
    """Raise ModelError where ``word``, the effect's ``text`` of a joint, is none of those it may be."""
    if word not in choice:
        raise ModelError(
            f"effects.{name}.{text} of {joint} is {word!r}: "
            f"choose from {', '.join(choice) or 'nothing: there is no other joint'}"
        )


def others(joints: tuple[str, ...], joint: str) -> list[str]:
    """All joints but one."""
    return [other for other in joints if other != joint]
