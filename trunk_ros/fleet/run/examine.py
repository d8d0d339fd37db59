"""The first task: a recording is diagnosed, and what is found becomes rows."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros import __version__
from trunk_ros.diagnosis.diagnose import diagnose
from trunk_ros.diagnosis.servos.nominal_servo import Servos
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.errors import TrunkError, one_line
from trunk_ros.fleet.inputs.files import here
from trunk_ros.fleet.run.outcome import Row, unread
from trunk_ros.model import Model
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording

STEP = 0.1  # s between the angles that travel is summed over: the noise of an encoder is no travel
Files = dict[str, str]


def examine(path: str, model: Model, report: bool, servos: Servos | None = None) -> tuple[Row, Files]:
    """The outcome of a recording, and with ``report`` the files of its diagnosis. ``servos``: the arm's.

    A recording that cannot be diagnosed is an outcome with a reason. Raises OSError where it cannot be
    fetched, which is worth another try.
    """
    with here(path) as local:
        return told(local, path, lambda: _examined(local, path, model, report, servos))


def told(local: Path, path: str, work: Callable[[], tuple[Row, Files]]) -> tuple[Row, Files]:
    """Do the work on a recording; what goes wrong becomes its reason."""
    begun = time.process_time()
    try:
        row, files = work()
    except TrunkError as error:
        row, files = unread(str(error).replace(str(local), path)), {}
    except Exception as error:
        row, files = unread(one_line(f"a fault of ours: {type(error).__name__}: {error}")), {}
    return row | {"cpu": time.process_time() - begun}, files


def _examined(local: Path, path: str, model: Model, report: bool, servos: Servos | None) -> tuple[Row, Files]:
    recording = read_recording(local)
    result = diagnose([recording], model, servos=servos, experiments=report)
    result.provenance = {"trunk_ros": __version__, "model_hash": model.hash(), "bags": [path]}
    row = {
        "reason": "",
        "time": recording.start_ns * 1e-9,
        "findings": [entry for finding in result.findings for entry in entries(finding)],
        "errors": list(_errors(result)),
        "travel": travel(recording, result.model),
    }
    return row, _files(result) if report else {}


def entries(finding: Finding) -> Iterator[dict[str, Any]]:
    """A finding as entries, one per joint and parameter; one per joint where a curve is all that there is."""
    base = {
        "stage": finding.stage, "effect": finding.effect, "confidence": finding.confidence,
        "form": str(finding.evidence.get("form") or ""),
        "equivalents": [one for one in finding.equivalents if isinstance(one, str)],
    }  # fmt: skip
    for joint, values in finding.parameters.items():
        for parameter, said in values.items():
            yield base | {"joint": joint, "parameter": parameter, **_number(said)}
    if not finding.parameters:
        nothing = {"parameter": None, "value": None, "std": None, "unit": None, "word": None}
        for joint in finding.joints or ["arm"]:
            yield base | {"joint": joint, **nothing}


def _number(said: dict[str, Any]) -> dict[str, Any]:
    value = said["value"]
    word = value if isinstance(value, str) else None
    number = None if word is not None or not math.isfinite(value) else float(value)
    return {"value": number, "std": said["std"], "unit": said["unit"], "word": word}


def _errors(result: Diagnosis) -> Iterator[dict[str, Any]]:
    for stage, compared in result.stages.items():
        signals = compared.get("joints", {}) | compared.get("tip", {})
        for joint, error in signals.items():
            numbers = {key: float(error[key]) for key in ("rmse_before", "rmse_after", "noise_floor")}
            yield {
                "stage": stage, "joint": joint, "unit": error["unit"], "verdict": result.verdict, **numbers
            }  # fmt: skip


def travel(recording: Recording, model: Model) -> list[dict[str, Any]]:
    """Metres that the wire of each joint has run over its wheel; none where the wheels are not known."""
    gearbox, wire = recording.series.get("gearbox_states"), model.arm.wire
    if gearbox is None or wire is None:
        return []
    rows = np.searchsorted(gearbox.stamp, np.arange(gearbox.stamp[0], gearbox.stamp[-1] + STEP, STEP))
    angles = gearbox.position[np.unique(np.minimum(rows, len(gearbox.stamp) - 1))]
    turned = np.nansum(np.abs(np.diff(angles, axis=0)), axis=0)
    arm = model.arm
    known = {joint: k for k, joint in enumerate(arm.joints)}
    radius = np.broadcast_to(wire.cylinder_radius * np.abs(arm.ratio), len(arm.joints))
    return [
        {"joint": joint, "metres": float(turn * radius[known[joint]])}
        for joint, turn in zip(gearbox.joints, turned, strict=True)
        if joint in known
    ]


def _files(result: Diagnosis) -> Files:
    """Texts of ``diagnosis.json``, ``model.yaml`` and ``report.html`` by name."""
    import tempfile

    from trunk_ros.diagnosis.report import write

    with tempfile.TemporaryDirectory(prefix="trunk_ros_") as name:
        folder = Path(name)
        result.save(folder)
        write(result, folder / "report.html")
        return {file.name: file.read_text(encoding="utf-8") for file in folder.iterdir() if file.is_file()}
