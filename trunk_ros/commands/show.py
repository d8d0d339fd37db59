"""``show``: a recording beside a model, in 3D and over time, in the viewer Rerun."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from trunk_ros.commands.arguments import Parser, add_namespace
from trunk_ros.commands.console import say
from trunk_ros.errors import ArgumentError


def parser() -> Parser:
    """Arguments of ``show``."""
    made = Parser(
        "show",
        "Show a recording in Rerun: the arm in 3D as measured, with nominal and fitted ghosts; joints,\n"
        "residuals and findings on the time line. Findings come from diagnosis.json beside MODEL.yaml.",
        ["run1 -m verdict/model.yaml", "run1 -m verdict/model.yaml --save run1.rrd"],
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
    made.add_argument("--save", metavar="FILE.rrd", help="write a file for Rerun in place of opening it")
    made.add_argument("--overwrite", action="store_true", help="replace FILE.rrd if it exists")
    return made


def main(argv: list[str]) -> int:
    """The command."""
    asked = parser().parse_args(argv)
    from trunk_ros.arm.urdf import urdf
    from trunk_ros.diagnosis.data.sensor_faults import without_wild
    from trunk_ros.model import load_model
    from trunk_ros.recording.output import prepare_output
    from trunk_ros.recording.read import read_recording
    from trunk_ros.show.scene import diagnosis_beside, scene
    from trunk_ros.show.viewer import log, the_viewer

    rr = the_viewer()
    target = None if asked.save is None else prepare_output(asked.save, asked.overwrite)
    if target is None:
        _refuse_without_a_screen()
    model = load_model(asked.model)
    recording = without_wild(read_recording(asked.bag, namespace=asked.namespace))
    shown = scene(recording, model, diagnosis_beside(asked.model))
    arm = model.for_joints(shown.joints).arm
    recorded = None if arm.description is not None else recording.description
    description = _text(asked.urdf) if asked.urdf else recorded or urdf(arm)
    stream = rr.RecordingStream("trunk_ros", recording_id=f"{Path(asked.bag).name}-{model.hash()[:8]}")
    if target is None:
        stream.spawn()
    drawn = description == urdf(arm) and arm.description is None
    log(rr, stream, shown, description, float(arm.link_length.sum()) if drawn else 0.0)
    if target is not None:
        _save(stream, target)
        say(
            f"{target}: {len(shown.stamp)} samples of {', '.join(shown.joints)}; open it with: rerun {target}"
        )
    return 0


def _save(stream: object, target: Path) -> None:
    """Whole or not at all."""
    draft = target.with_name(f".{target.name}.part")
    try:
        target.absolute().parent.mkdir(parents=True, exist_ok=True)
        stream.save(draft)  # type: ignore[attr-defined]
        stream.flush()  # type: ignore[attr-defined]
        stream.disconnect()  # type: ignore[attr-defined]
        os.replace(draft, target)
    finally:
        draft.unlink(missing_ok=True)


def _refuse_without_a_screen() -> None:
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise ArgumentError("show: no screen here; --save FILE.rrd writes a file that `rerun FILE.rrd` opens")


def _text(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ArgumentError(f"show: {path} cannot be read: {error}") from None
