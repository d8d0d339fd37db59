"""``show``: a recording beside a model, in 3D and over time, in Rerun or Foxglove."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from trunk_ros.console.arguments import Parser, add_namespace
from trunk_ros.console.console import say
from trunk_ros.errors import ArgumentError


def parser() -> Parser:
    """Arguments of ``show``."""
    made = Parser(
        "show",
        "Show a recording in Rerun: the arm in 3D as measured, with nominal and fitted ghosts; joints,\n"
        "residuals and findings on the time line. Findings come from diagnosis.json beside MODEL.yaml.\n"
        "--save FILE.mcap writes the same for Foxglove or Lichtblick, with its layout beside it.",
        [
            "run1 -m verdict/model.yaml",
            "run1 -m verdict/model.yaml --save run1.rrd",
            "run1 -m verdict/model.yaml --save run1.mcap",
        ],
    )
    made.add_argument("bag", metavar="BAG", help="recording to show")
    made.add_argument(
        "--model", required=True, metavar="MODEL.yaml", help="the fitted model: a file, or trunk"
    )
    made.add_argument(
        "--urdf",
        metavar="FILE",
        help="the arm's look (default: the model's or recording's URDF, else links as the model has them)",
    )
    add_namespace(made)
    made.add_argument(
        "--save", metavar="FILE", help="write FILE.rrd for Rerun, or FILE.mcap for Foxglove; open nothing"
    )
    made.add_argument("--overwrite", action="store_true", help="replace what --save writes if it exists")
    return made


def main(argv: list[str]) -> int:
    """The command."""
    asked = parser().parse_args(argv)
    from trunk_ros.arm.urdf import urdf
    from trunk_ros.data.sensor_faults import without_wild
    from trunk_ros.model import load_model
    from trunk_ros.recording.read import read_recording
    from trunk_ros.show.scene import diagnosis_beside, scene

    targets = _targets(asked.save, asked.overwrite)
    foxglove = len(targets) == 2
    rr = None if foxglove else _viewer(bool(targets))
    model = load_model(asked.model)
    recording = without_wild(read_recording(asked.bag, namespace=asked.namespace))
    shown = scene(recording, model, diagnosis_beside(asked.model))
    arm = model.for_joints(shown.joints).arm
    recorded = None if arm.description is not None else recording.description
    description = _text(asked.urdf) if asked.urdf else recorded or urdf(arm)
    drawn = description == urdf(arm) and arm.description is None
    reach = float(arm.link_length.sum()) if drawn else 0.0
    if foxglove:
        _save_foxglove(targets, shown, description, reach, recording.start_ns)
    else:
        name = f"{Path(asked.bag).name}-{model.hash()[:8]}"
        _to_rerun(rr, targets, name, shown, description, reach)
    for opened in targets[:1]:
        where = (
            f"Foxglove or Lichtblick, with the layout {targets[1]}" if foxglove else f"Rerun: rerun {opened}"
        )
        say(f"{opened}: {len(shown.stamp)} samples of {', '.join(shown.joints)}; open it in {where}")
    return 0


def _targets(save: str | None, overwrite: bool) -> list[Path]:
    """The files to write: none, Rerun's, or Foxglove's and its layout."""
    from trunk_ros.recording.output import prepare_output

    if save is None:
        return []
    path = Path(save)
    if path.suffix not in (".rrd", ".mcap"):
        raise ArgumentError(f"show: --save {save}: give FILE.rrd for Rerun or FILE.mcap for Foxglove")
    names = [path] if path.suffix == ".rrd" else [path, path.with_suffix(".layout.json")]
    return [prepare_output(name, overwrite) for name in names]


def _viewer(saves: bool) -> Any:
    from trunk_ros.show.viewer import the_viewer

    rr = the_viewer()
    if not saves:
        _refuse_without_a_screen()
    return rr


def _to_rerun(rr: Any, targets: list[Path], name: str, shown: Any, urdf: str, reach: float) -> None:
    """Open the viewer, or write its file, whole or not at all."""
    from trunk_ros.recording.output import new_file
    from trunk_ros.show.viewer import log

    stream = rr.RecordingStream("trunk_ros", recording_id=name)
    if not targets:
        stream.spawn()
        log(rr, stream, shown, urdf, reach)
        return
    log(rr, stream, shown, urdf, reach)
    with new_file(targets[0], overwrite=True) as draft:
        stream.save(draft)
        stream.flush()
        stream.disconnect()


def _save_foxglove(targets: list[Path], shown: Any, urdf: str, reach: float, start_ns: int) -> None:
    from trunk_ros.recording.output import new_file
    from trunk_ros.show.foxglove import save_foxglove

    mcap, layout = targets
    with new_file(layout, overwrite=True) as beside, new_file(mcap, overwrite=True) as draft:
        save_foxglove(draft, beside, shown, urdf, reach, start_ns)


def _refuse_without_a_screen() -> None:
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise ArgumentError("show: no screen here; --save FILE.rrd or FILE.mcap writes a file")


def _text(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ArgumentError(f"show: {path} cannot be read: {error}") from None
