"""From recordings to a diagnosis: align, search each stage, judge, say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from trunk_ros.data.put_right import put_right
from trunk_ros.data.quality import strangers
from trunk_ros.diagnosis.diagnoser import Diagnoser, Progress
from trunk_ros.diagnosis.nominal_model import described
from trunk_ros.diagnosis.resources.cores import one_thread
from trunk_ros.diagnosis.servos.nominal_servo import Servos
from trunk_ros.diagnosis.simulators.against import identified, nominal_for
from trunk_ros.diagnosis.simulators.other_simulator import completed, sides_told
from trunk_ros.diagnosis.verdict.differences import told_as_differences
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.errors import ModelError
from trunk_ros.heap import give_back, keep_what_is_freed
from trunk_ros.model import Model
from trunk_ros.recording.read import read_parts, read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.time_range import part_of
from trunk_ros.start import SETTLE


@one_thread
def diagnose(
    recordings: Recording | str | Path | Sequence[Recording | str | Path],
    model: Model | str | Path | None = None,
    against: Recording | str | Path | None = None,
    from_time: str | None = None,
    until: str | None = None,
    progress: Progress = lambda _: None,
    namespace: str | None = None,
    urdf: str = "",
    settle: float = SETTLE,
    servos: Servos | None = None,
    experiments: bool = True,
    doubts: Progress = lambda _: None,
) -> Diagnosis:
    """Compare recordings of one arm with a model, and find what the model leaves out.

    ``recordings``: one or several, each a path or in memory. ``model``: in memory, a file, or a name in
    config/; by default the nominal arm, or ``direct`` where the recordings are of another. ``from_time``,
    ``until``: "12.5" (s) or "70%" of each recording. ``progress`` is told each step. ``urdf``: text of the
    URDF that has the links; without, a model for any joints takes the recorded ``robot_description``.
    ``against``: a simulator's recording of the same motion; what it does is found from it first, by default
    from an ideal transmission, and takes the place of the model.
    ``namespace``: of the arm, where recordings hold several. ``settle``: seconds of measured joint angles
    that tell how the wires lay where a recording that stops to measure begins; 0: none.
    ``servos``: of the arm, found in other recordings where the model says nothing of them. ``experiments``:
    whether motions are designed that tell findings from their equivalents, up to a third of the time.
    ``doubts`` is told, before the search begins, in a line each which joints are left out under names that
    the model has not.
    Raises RecordingError or ModelError in one line.
    """
    keep_what_is_freed()
    give_back(libraries=True)
    several = [recordings] if isinstance(recordings, (Recording, str, Path)) else recordings
    read = [part for r in several for part in _read(r, from_time, until, namespace)]
    give_back()
    other = (
        None if against is None else against if isinstance(against, Recording) else read_recording(against)
    )
    read = [completed(r, other) for r in read]
    if model is None and other is not None and not urdf:
        model = nominal_for(read[0].joints)
    read = read if other is None else [sides_told(r, other) for r in read]
    nominal, read = described(model, read, urdf)
    give_back()
    read, mixed = put_right(read, nominal)
    shared = [recording for recording in read if {*nominal.arm.joints} & {*recording.joints}]  # else refused
    for doubt in dict.fromkeys(line for recording in shared for line in strangers(recording, nominal)):
        doubts(doubt)
    give_back()
    if other is None:
        return Diagnoser(read, nominal, None, progress, mixed, experiments, settle, servos).run()
    if nominal.arm.coupling is not None:
        raise ModelError("wire.coupling goes without --against so far: compare the two models instead")
    progress("what the simulation has itself")
    simulator = identified(
        other, read, nominal, lambda r, m: Diagnoser([r], m, None, progress, experiments=False).run()
    )
    own = replace(simulator.model, setpoints=nominal.setpoints)  # those of a table are no simulator's doing
    result = Diagnoser(read, own, simulator, progress, mixed, experiments, settle).run()
    return told_as_differences(result, simulator.model, simulator.found)


def _read(
    recording: Recording | str | Path, from_time: str | None, until: str | None, namespace: str | None
) -> list[Recording]:
    """The recordings that one is: two where its clock was set."""
    if isinstance(recording, Recording):
        return [part_of(recording, from_time, until)]
    return read_parts(recording, from_time, until, namespace)


__all__ = ["Diagnosis", "Finding", "diagnose"]
