"""Joints that another joint's effect goes by, as a model names them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError

STANDS = 0.03  # of the motion of the joint that moves most: a source that moves less


def check_source(name: str, text: str, joint: str, word: str, choice: Sequence[str]) -> None:
    """Raise ModelError where ``word``, the effect's ``text`` of a joint, is none of those it may be."""
    if word not in choice:
        raise ModelError(
            f"effects.{name}.{text} of {joint} is {word!r}: "
            f"choose from {', '.join(choice) or 'nothing: there is no other joint'}"
        )


def check_sources(
    name: str,
    pairs: Iterable[tuple[str, str]],
    values: Mapping[str, Array],
    words: Mapping[str, tuple[str, ...]],
    joints: tuple[str, ...],
) -> None:
    """Raise ModelError where a joint has a gain, and its source is none of the other ``joints``; ``pairs``:
    names of each gain and of the text that says its source.
    """
    for gain, text in pairs:
        sources = words.get(text, ("",) * len(joints))
        for joint, value, source in zip(joints, values[gain], sources, strict=True):
            if value != 0.0:
                check_source(name, text, joint, source, others(joints, joint))


def others(joints: tuple[str, ...], joint: str) -> list[str]:
    """All joints but one."""
    return [other for other in joints if other != joint]
