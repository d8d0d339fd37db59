"""A scene as a Rerun recording."""

from __future__ import annotations

import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError, TrunkError
from trunk_ros.show.ghosts import GHOSTS, ghost
from trunk_ros.show.scene import Scene, Spell

TIME = "time"
COLOURS = {"measured": (235, 150, 40), "nominal": (138, 147, 157), "fitted": (60, 165, 215)}
NEVER = ""  # ends a state


def the_viewer() -> Any:
    """The module ``rerun``. Raises TrunkError where it is not installed."""
    try:
        import rerun
        import rerun.blueprint
        import rerun.urdf
    except ImportError:
        raise TrunkError("rerun is not installed: pip install 'trunk_ros[show]' (or rerun-sdk)") from None
    return rerun


def log(rr: Any, stream: Any, scene: Scene, urdf: str, reach: float = 0.0) -> None:
    """Everything of a scene into a recording stream; ``urdf`` names the joints as the scene does. ``reach`` m
    of an arm that stands upright, for the first view of it; 0 where it is not known.
    """
    for kind in GHOSTS:
        _arm(rr, stream, scene, kind, urdf)
    for c, joint in enumerate(scene.joints):
        _joint(rr, stream, scene, c, joint)
    for number, spell in enumerate(scene.spells):
        _spell(rr, stream, scene, spell, number)
    stream.log("findings", rr.TextDocument(scene.statement, media_type="text/markdown"), static=True)
    stream.send_blueprint(blueprint(rr, scene, reach))


def _arm(rr: Any, stream: Any, scene: Scene, kind: str, urdf: str) -> None:
    """The arm in 3D, moved by one kind of angles."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "arm.urdf"
        file.write_text(ghost(urdf, GHOSTS[kind]), encoding="utf-8")
        tree = rr.urdf.UrdfTree.from_file_path(
            file, kind, frame_prefix=f"{kind}/", static_transform_entity_path=f"{kind}/static"
        )
        tree.log_urdf_to_recording(stream)
    if missing := set(scene.joints) - {joint.name for joint in tree.joints()}:
        raise ModelError(f"the URDF has no joint {sorted(missing)[0]!r}, which the recording has")
    root = f"{kind}/{tree.root_link().name}"
    stream.log(f"{kind}/root", rr.Transform3D(parent_frame="tf#/", child_frame=root), static=True)
    for found in tree.joints():
        angle = _angle(scene, kind, found)
        if angle is None:
            continue
        known = np.isfinite(angle)
        with warnings.catch_warnings():  # a measured angle may lie beyond a limit, and is shown there
            warnings.simplefilter("ignore", UserWarning)
            moved = found.compute_transform_columns(angle[known].tolist(), clamp=False)
        stream.send_columns(f"{kind}/joints/{found.name}", [_time(rr, scene.stamp[known])], moved)


def _angle(scene: Scene, kind: str, joint: Any) -> Array | None:
    """(n,) of a joint of the URDF: the scene's own, or one that mimics it. None for one that stands still."""
    name = joint.name if joint.mimic is None else joint.mimic.joint
    if name not in scene.joints:
        return None
    angle: Array = getattr(scene, kind)[:, scene.joints.index(name)]
    return angle if joint.mimic is None else joint.mimic.multiplier * angle + joint.mimic.offset


def _joint(rr: Any, stream: Any, scene: Scene, column: int, joint: str) -> None:
    """Curves of a joint, and its residuals in thousandths."""
    unit, measured = scene.units[joint], scene.measured[:, column]
    for kind, colour in COLOURS.items():
        values = getattr(scene, kind)[:, column]
        _curve(rr, stream, f"joints/{joint}/{kind}", scene.stamp, values, f"{kind} / {unit}", colour)
        if kind != "measured":
            path, name = f"residuals/{joint}/{kind}", f"{joint} {kind} / m{unit}"
            _curve(rr, stream, path, scene.stamp, 1e3 * (measured - values), name, colour)


def _curve(
    rr: Any, stream: Any, path: str, stamp: Array, values: Array, name: str, colour: tuple[int, int, int]
) -> None:
    stream.log(path, rr.SeriesLines(colors=[colour], names=[name], widths=[1.5]), static=True)
    known = np.isfinite(values)
    stream.send_columns(path, [_time(rr, stamp[known])], rr.Scalars.columns(scalars=values[known]))


def _spell(rr: Any, stream: Any, scene: Scene, spell: Spell, number: int) -> None:
    """A lane on the time line that says when a finding's regime holds."""
    spans = spell.spans or [(float(scene.stamp[0]), float(scene.stamp[-1]))]
    times = np.array([t for span in spans for t in span])
    states = [s for _ in spans for s in (spell.regime.replace("_", " "), NEVER)]
    path = f"regimes/{spell.joint}/{spell.effect.replace(' ', '_')}_{number}"
    stream.send_columns(path, [_time(rr, times)], rr.StateChange.columns(state=states))


def _time(rr: Any, stamp: Array) -> Any:
    return rr.TimeColumn(TIME, duration=np.asarray(stamp, dtype=float))


def blueprint(rr: Any, scene: Scene, reach: float) -> Any:
    """3D and findings on the left, a tab for each joint and the lanes of the regimes on the right."""
    b = rr.blueprint
    joints = [
        b.Vertical(
            b.TimeSeriesView(origin=f"joints/{joint}", name=f"{joint}: angle"),
            b.TimeSeriesView(origin=f"residuals/{joint}", name=f"{joint}: residual"),
            name=joint,
        )
        for joint in scene.joints
    ]
    eye = (
        b.EyeControls3D(position=(2.0 * reach, 0.0, 0.8 * reach), look_target=(0.0, 0.0, 0.5 * reach))
        if reach > 0.0
        else None
    )
    every = b.TimeSeriesView(
        origin="residuals", name="all residuals", plot_legend=b.PlotLegend(visible=False)
    )
    left = b.Vertical(
        b.Spatial3DView(
            origin="/", contents=[f"/{kind}/**" for kind in GHOSTS], name="arm", eye_controls=eye
        ),
        b.TextDocumentView(origin="findings", name="findings"),
        row_shares=[3, 1],
    )
    lanes = [b.StateTimelineView(origin="regimes", name="when each finding shows")] if scene.spells else []
    right = b.Vertical(b.Tabs(every, *joints, active_tab=0), *lanes, row_shares=[3, 1][: 1 + len(lanes)])
    return b.Blueprint(b.Horizontal(left, right, column_shares=[2, 3]), collapse_panels=True)
