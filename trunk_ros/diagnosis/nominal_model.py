"""Which arm recordings are of, where the model leaves that open: by its URDF."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import Recording

NOMINAL, ANY = "trunk", "direct"


def described(
    model: Model | str | Path | None, recordings: list[Recording], urdf: str
) -> tuple[Model, list[Recording]]:
    """The model with the links of a URDF, given or recorded, and the recordings with its joints' units.

    Raises ModelError where a given URDF is of another arm; with a recorded one that is only noted.
    """
    nominal = model if isinstance(model, Model) else load_model(model or _default(recordings, urdf))
    recorded = _recorded(recordings)
    if urdf:
        nominal = nominal.with_urdf(urdf, recorded)
    elif nominal.any_joints and (texts := [r.description for r in recordings if r.description]):
        try:
            nominal = nominal.with_urdf(texts[0], recorded)
        except ModelError as error:
            note = f"robot_description is not used: {error}"
            recordings = [replace(recordings[0], notes=(*recordings[0].notes, note)), *recordings[1:]]
    units = nominal.arm.units
    return nominal, [replace(r, units={**units, **r.units}) for r in recordings]


def _default(recordings: list[Recording], urdf: str) -> str:
    """The nominal arm unless the recordings are of another that is known."""
    known = set(load_model(NOMINAL).arm.joints)
    other = not known.intersection(_recorded(recordings)) and any(r.description for r in recordings)
    return ANY if urdf or other else NOMINAL


def _recorded(recordings: list[Recording]) -> tuple[str, ...]:
    """Joints that all topics of joints in all recordings have."""
    topics = [each.joints for r in recordings for key, each in r.series.items() if key != "wire_states"]
    return tuple(joint for joint in recordings[0].joints if all(joint in joints for joints in topics))
