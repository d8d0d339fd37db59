"""Before the first task: the servos of each arm, where the model says nothing of them, once for all of its
recordings. Found in each anew, a servo that wears would be another nominal every time.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Any

from trunk_ros.arm.arm import SERVO_OF_EACH
from trunk_ros.data.put_right import put_right
from trunk_ros.diagnosis.diagnoser import Diagnoser
from trunk_ros.diagnosis.nominal_model import described
from trunk_ros.diagnosis.servos.nominal_servo import Servos
from trunk_ros.diagnosis.simulators.against import SERVO
from trunk_ros.errors import TrunkError
from trunk_ros.fleet.inputs.files import here
from trunk_ros.fleet.inputs.listing import Job
from trunk_ros.fleet.run.cluster import each
from trunk_ros.model import Model
from trunk_ros.recording.output import new_file
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording

FIRST = 3  # recordings of an arm that its servos are found in: what comes later is compared with them
MOST = 10  # that are looked at for them: others may have no setpoints
FILE = "servos.json"
Shown = Callable[[str, int], AbstractContextManager[Callable[[], None]]]


@contextmanager
def untold(what: str, count: int) -> Iterator[Callable[[], None]]:
    """Says nothing of how far it is."""
    yield lambda: None


def servos(
    client: Any, folder: Path, jobs: list[Job], model: Model, shown: Shown = untold
) -> dict[str, Servos]:
    """By arm; empty where the model says what they are. Kept in the folder: they stay what they were when
    recordings come. ``shown``: how far it is, by a name and the number of arms.
    """
    if model.says_its_servos:
        return {}
    file, setting = folder / FILE, model.hash()
    told = _kept(file, setting)
    paths: dict[str, list[str]] = {}
    for job in sorted(jobs, key=lambda job: (math.inf if math.isnan(job.time) else job.time, job.path)):
        paths.setdefault(job.arm, []).append(job.path)
    tasks = [(arm, (some[:MOST], model)) for arm, some in paths.items() if arm not in told]
    with shown("servos of arms", len(tasks)) as tick:
        for arm, found in each(client, found_in, tasks):
            if isinstance(found, Servos) and found.numbers:
                told[arm] = found
                _keep(file, setting, told)
            tick()
    return told


def _keep(file: Path, setting: str, told: dict[str, Servos]) -> None:
    """All that were found so far: a run that is stopped here does not begin anew."""
    arms = {arm: asdict(found) for arm, found in told.items()}
    with new_file(file, overwrite=True) as draft:
        draft.write_text(json.dumps({"model": setting, "arms": arms}, indent=1) + "\n")


def _kept(file: Path, setting: str) -> dict[str, Servos]:
    """What was found before by the same model."""
    try:
        known = json.loads(file.read_text())
        if known["model"] != setting:
            return {}
        if any(
            len(n) != len(SERVO_OF_EACH) for each in known["arms"].values() for n in each["numbers"].values()
        ):
            return {}
        return {
            arm: Servos({joint: tuple(n) for joint, n in each["numbers"].items()}, each["setpoints"])
            for arm, each in known["arms"].items()
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def found_in(paths: list[str], model: Model) -> Servos | None:
    """The servos that some recordings of an arm show together; None where they show none.

    Raises OSError where one cannot be fetched.
    """
    with ExitStack() as open_files:
        driven = (_driven(open_files.enter_context(here(path))) for path in paths)
        read = list(islice((r for r in driven if r is not None), FIRST))
        for some in (read, read[:1]):
            try:
                return _together(some, model)
            except TrunkError:  # such as recordings of different joints
                continue
    return None


def _driven(local: Path) -> Recording | None:
    try:
        recording = read_recording(local)
    except TrunkError:
        return None
    return recording if set(recording.series) >= SERVO else None


def _together(read: list[Recording], model: Model) -> Servos | None:
    if not read:
        return None
    nominal, read = described(model, read, "")
    read, mixed = put_right(read, nominal)
    return Diagnoser(read, nominal, None, lambda _: None, mixed).found_servos()
