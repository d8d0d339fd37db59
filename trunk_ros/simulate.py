"""``simulate``: run a model over a recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from trunk_ros import __version__
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.align import SAME, common_joints, joint_grid, resample
from trunk_ros.model import Model, load_model
from trunk_ros.recording.arguments import Parser
from trunk_ros.recording.encoder import between_counts
from trunk_ros.recording.fill import fill
from trunk_ros.recording.gaps import GAP, bridged, missing
from trunk_ros.recording.output import prepare_output
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording
from trunk_ros.resistance import resistance

LOST = 3.0  # s: who falls silent for longer has stopped, and messages were not lost
SOURCES = ("gearbox_states", "setpoints")


def simulate(recording: Recording, model: Model, source: str = "gearbox_states") -> Recording:
    """What a model predicts for a recording's gearbox angles or setpoints; recorded joint angles are
    never read.

    Stamps are those of the recorded ``joint_states``, else of the source. A model with effects is run on
    gearbox angles between the encoder's counts. Raises RecordingError where the
    source is missing.
    """
    given = recording.require(source)
    joints = common_joints(recording, model, given)
    given, model = given.select(joints), model.for_joints(joints)
    measured = recording.series.get("joint_states")
    shown_at = given.stamp if measured is None else measured.stamp
    series: dict[str, JointSeries] = {}
    if source == "setpoints":
        wanted = recording.series.get("gearbox_states", given).stamp
        at = np.union1d(wanted, _between(wanted, shown_at))
        given = _gearbox(_without_gaps(given, recording.series.get("reference"), model), at, model)
        there = np.searchsorted(given.stamp, wanted)
        series["gearbox_states"] = JointSeries(wanted, joints, given.position[there])
    else:
        given = _as_driven(recording, given, model)
    series["joint_states"] = _joints(given, shown_at, model)
    return Recording(recording.name, recording.start_ns, recording.duration, series, units=recording.units)


def _as_driven(recording: Recording, gearbox: JointSeries, model: Model) -> JointSeries:
    """Gearbox angles between the encoder's counts, and with lost ones as the servo follows the setpoints.

    A model without effects stays the formula of the counts.
    """
    if model.effects:
        gearbox = between_counts(gearbox)
    setpoints = recording.series.get("setpoints")
    if setpoints is None or not set(gearbox.joints) <= set(setpoints.joints):
        return bridged(gearbox, longest=LOST)
    lost = missing(gearbox.stamp, end=float(setpoints.stamp[-1]))
    if not len(lost):
        return gearbox
    setpoints = _without_gaps(setpoints.select(gearbox.joints), recording.series.get("reference"), model)
    return bridged(gearbox, _gearbox(setpoints, np.union1d(gearbox.stamp, lost), model))


def _without_gaps(setpoints: JointSeries, reference: JointSeries | None, model: Model) -> JointSeries:
    """Setpoints with those that were lost on the way to the bag; they move as the reference does."""
    if reference is None or not set(setpoints.joints) <= set(reference.joints):
        return bridged(setpoints, longest=LOST)
    asked = bridged(reference.select(setpoints.joints), longest=LOST)
    guide = JointSeries(asked.stamp, asked.joints, asked.position / model.only(asked.joints).arm.ratio)
    return bridged(setpoints, guide, LOST)


def _joints(gearbox: JointSeries, shown_at: Array, model: Model) -> JointSeries:
    grid, rows, kept = joint_grid(gearbox.stamp, shown_at, beyond=True)
    phi, velocity = resample(gearbox, grid)
    model = model.only(gearbox.joints)
    known = resistance(model.arm, gearbox, grid, phi)
    theta, _ = Chain(model, "wire").run(phi, grid, velocity=velocity, resistance=known)
    return JointSeries(shown_at[kept], gearbox.joints, theta[rows])


def _between(stamp: Array, shown_at: Array) -> Array:
    """Those of ``shown_at`` (m,) that lie in gaps of ``stamp`` (n,): there the gearbox is not guessed."""
    usual = GAP * float(np.median(np.diff(stamp))) if len(stamp) > 1 else 0.0
    after = np.clip(np.searchsorted(stamp, shown_at), 1, max(len(stamp) - 1, 1))
    inside = (shown_at > stamp[0]) & (shown_at < stamp[-1])
    return shown_at[inside & (np.diff(stamp)[after - 1] > usual)] if len(stamp) > 1 else shown_at[:0]


def _gearbox(setpoints: JointSeries, wanted: Array, model: Model) -> JointSeries:
    grid, rows, kept = joint_grid(setpoints.stamp, wanted, fine=False, beyond=True)
    last = np.clip(np.searchsorted(setpoints.stamp, grid + SAME, side="right") - 1, 0, None)
    phi, _ = Chain(model.only(setpoints.joints), "servo").run(fill(setpoints.position)[last], grid)
    return JointSeries(wanted[kept], setpoints.joints, phi[rows])


def main(argv: list[str]) -> int:
    """The command."""
    parser = Parser(
        "simulate",
        description="Run a model over a recording: the bag OUT_BAG holds the predicted joint_states.",
    )
    parser.add_argument("bag", metavar="BAG")
    parser.add_argument("--model", required=True, metavar="MODEL.yaml", help="a file, or trunk or direct")
    parser.add_argument("--output", required=True, metavar="OUT_BAG")
    parser.add_argument("--from", dest="source", choices=SOURCES, default="gearbox_states")
    parser.add_argument("--overwrite", action="store_true")
    arguments = parser.parse_args(argv)
    prepare_output(arguments.output, arguments.overwrite)
    model = load_model(arguments.model)
    predicted = simulate(read_recording(arguments.bag), model, arguments.source)
    custom = {"trunk_ros": __version__, "model": model.hash(), "from": arguments.source}
    write_recording(Path(arguments.output), predicted, overwrite=arguments.overwrite, custom=custom)
    said = predicted.series["joint_states"]
    print(f"{arguments.output}: {len(said.stamp)} predictions of {', '.join(said.joints)}")
    return 0
