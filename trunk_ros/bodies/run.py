"""From recordings to bodies."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from trunk_ros.bodies.fit import fitted
from trunk_ros.bodies.found import UNITS, Bodies
from trunk_ros.bodies.rows import rows_of
from trunk_ros.bodies.signals import motion_of, usual_cutoff
from trunk_ros.data.sensor_faults import without_wild
from trunk_ros.errors import ModelError
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording

NONE = {"unit": "-", "before": float("nan"), "after": float("nan")}


def bodies_of(recordings: list[Recording], model: Model, cutoff: float | None = None) -> Bodies:
    """Friction, damping and armature of each joint, mass and centre of the last link, from recorded torque.

    ``cutoff`` [Hz]: what is faster in the motion is left out; by default five times the frequency below which
    95 % of the speed's power lies. Raises TrunkError in one line for recordings and models that will not do.
    """
    if model.any_joints:
        raise ModelError("bodies wants a model with joints and masses: `direct` has none")
    recordings = [without_wild(recording) for recording in recordings]
    cutoff = cutoff or usual_cutoff(recordings, model)
    arm = model.loaded_arm()
    rows = rows_of([motion_of(recording, model, cutoff) for recording in recordings], arm, cutoff)
    return fitted(rows, arm, tuple(recording.name for recording in recordings))


def show(bodies: Bodies, console: Console) -> None:
    """A row for each joint, what the last link is, and what was not seen."""
    table = Table("joint", box=None, pad_edge=False)
    for head in ("unit", *UNITS, "torque error", "on unseen blocks"):
        table.add_column(head, justify="left" if head == "unit" else "right")
    for joint, own in bodies.joints.items():
        left = bodies.held_out.get(joint, NONE)
        values = [f"{own[name].value:.4g} ± {own[name].std:.1g}" if name in own else "-" for name in UNITS]
        table.add_row(joint, left["unit"], *values, f"{left['before']:.3g}", f"{left['after']:.3g}")
    console.print(table)
    if bodies.mass is not None:
        console.print(f"last link ({bodies.last}): mass {bodies.mass.value:.4g} ± {bodies.mass.std:.1g} kg")
    if bodies.centre is not None:
        places = [
            f"{axis} {1e3 * value:.2f}" + (" (the model's)" if std is None else f" ± {1e3 * std:.1g}")
            for axis, value, std in zip("xyz", bodies.centre.value, bodies.centre.std, strict=True)
        ]
        console.print(f"last link ({bodies.last}): centre of mass {', '.join(places)} mm from its joint")
    for sentence in bodies.not_seen:
        console.print(sentence)
