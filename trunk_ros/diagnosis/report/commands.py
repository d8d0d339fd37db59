"""Commands that the page prints, with the arguments of the diagnosis: they run in the folder where it ran."""

from __future__ import annotations

import shlex
from math import ceil
from pathlib import Path
from typing import Any

from trunk_ros.diagnosis.verdict.answer import NOMINAL, Answer
from trunk_ros.errors import ArgumentError
from trunk_ros.recording.time_range import time_range

NEW = "decisive"  # the recording of an experiment
SIMULATED = "simulated"  # behind its name: what a simulator made of the same motion
SETTLED = "settled"
SPANS = ("from_time", "until")
OTHERS = ("namespace", "settle")
USUAL = "trunk"  # the model that needs no naming


def motions(result: Answer) -> dict[str, str]:
    """The recording of each experiment's motion, by the motion's file."""
    files = dict.fromkeys(e["trajectory"] for e in result.experiments if e.get("trajectory"))
    return {file: _numbered(NEW, i, len(files)) for i, file in enumerate(files, 1)}


def diagnose_again(result: Answer) -> list[str]:
    """All recordings and those of the experiments together, with the options that the diagnosis had. Another
    simulator is compared on the same motion: then each experiment by itself, beside its simulation.
    """
    new, given = list(motions(result).values()), _given(result)
    named = [("-m", given.get("model")), ("--urdf", given.get("urdf"))]
    others = [(_flag(key), given.get(key)) for key in OTHERS]
    if with_simulator(result):
        options = [(*named, ("--against", f"{name}_{SIMULATED}"), *others) for name in new]
        return [
            _command("diagnose", name, *_options(*each), "-o", _numbered(SETTLED, i, len(new)))
            for i, (name, each) in enumerate(zip(new, options, strict=True), 1)
        ]
    bags = map(str, result.provenance.get("bags", ["run1"]))
    spans = [(_flag(key), given[key]) for key in _fitting(result)]
    options_of_all = _options(*named, *spans, *others)
    return [_command("diagnose", *bags, *new, *options_of_all, "-o", SETTLED)] if new else []


def play(result: Answer, file: str) -> str:
    """Play an experiment's motion on the arm that was recorded, and record it: with the nominal arm, so that
    nothing is compensated that was found.
    """
    motion = result.trajectories.get(file)
    model = beside(result, NOMINAL) if result.described else nominal(result)
    first = _command("bringup", "--without", "servo_driver", "wire_elasticity")
    rest = [("-m", None if model == USUAL else model), ("--trajectory", beside(result, file))]
    rest += [("-o", motions(result)[file]), ("--seconds", f"{ceil(motion.duration) + 1}" if motion else "S")]
    return f"{first} \\\n    {shlex.join([*_options(*rest), *_within(result, ['--ros-args'])])}"


def evaluate(result: Answer, model: str) -> str:
    """Score a model on another recording."""
    space = _given(result).get("namespace")
    return _command("evaluate", "another_run", *_options(("-m", model), ("--namespace", space)))


def compensate(result: Answer) -> str:
    """Run the compensator with what was found."""
    ros = ["--ros-args", "--params-file", beside(result, "model.yaml")]
    return _command("compensator", *(_within(result, ros) or ros))


def export(result: Answer) -> str:
    """Write what was found into a simulator's file."""
    model = beside(result, "model.yaml")
    return _command("export", model, "--to", "mjcf", "--into", "arm.xml", "-o", "arm_real.xml")


def with_simulator(result: Answer) -> bool:
    """Whether another simulator's recording was compared, which is of the same motion."""
    return bool(result.simulation) or "against" in _given(result)


def nominal(result: Answer) -> str:
    """The nominal arm as --model takes it: where nothing was found, that of a URDF is in the model that was
    written.
    """
    model = str(result.provenance.get("model", USUAL))
    return beside(result, "model.yaml") if result.described else model


def beside(result: Answer, file: str) -> str:
    """A file in the folder of the page."""
    return str(Path(_given(result).get("output", ""), file))


def cut(result: Answer, fitting: bool = True) -> list[str]:
    """The options that hold for every recording, also for a new one; or those that do not fit it, and are
    left out. None where the new one is diagnosed by itself.
    """
    given = _given(result)
    keys = [] if with_simulator(result) else [key for key in SPANS if key in given]
    return [f"{_flag(key)} {given[key]}" for key in keys if (key in _fitting(result)) == fitting]


def _fitting(result: Answer) -> tuple[str, ...]:
    """The given of ``from_time`` and ``until`` that leave something of every motion."""
    given = {key: at for key, at in _given(result).items() if key in SPANS}
    for motion in (result.trajectories.get(file) for file in motions(result)):
        try:
            if motion:
                time_range(motion.duration, given.get("from_time"), given.get("until"))
        except ArgumentError:
            given.pop("from_time", None)  # a motion that ends before --until is taken whole
    return tuple(key for key in SPANS if key in given)


def _within(result: Answer, ros: list[str]) -> list[str]:
    """Arguments of ROS with the namespace of the arm; none where it has none."""
    space = str(_given(result).get("namespace", "")).strip("/")
    return [*ros, "-r", f"__ns:=/{space}"] if space else []


def _numbered(name: str, number: int, of: int) -> str:
    return f"{name}_{number}" if of > 1 else name


def _given(result: Answer) -> dict[str, Any]:
    return dict(result.provenance.get("arguments", {}))


def _flag(key: str) -> str:
    return f"--{key.replace('_', '-')}"


def _options(*pairs: tuple[str, Any]) -> list[str]:
    return [word for flag, value in pairs if value is not None for word in (flag, str(value))]


def _command(*words: str) -> str:
    return shlex.join(["trunk_ros", *words])
