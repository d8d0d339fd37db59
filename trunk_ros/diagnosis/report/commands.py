"""Commands that the page prints, with the arguments of the diagnosis: they run in the folder where it ran."""

from __future__ import annotations

import shlex
from math import ceil
from pathlib import Path
from typing import Any

from trunk_ros.diagnosis.verdict.answer import Answer

NEW = "decisive"  # the recording of an experiment
SPANS = ("from_time", "until")
OTHERS = ("against", *SPANS, "namespace", "settle")
FROM_URDF = "robot_description"  # what stood for the model where a recorded URDF did
USUAL = "trunk"  # the model that needs no naming


def diagnose_again(result: Answer) -> str:
    """All recordings and that of an experiment together, with the options that the diagnosis had."""
    given = _given(result)
    model = given.get("model")
    named = (("-m", model), ("--urdf", given.get("urdf")), *((_flag(key), given.get(key)) for key in OTHERS))
    bags = map(str, result.provenance.get("bags", ["run1"]))
    return _command("diagnose", *bags, NEW, *_options(*named), "-o", "settled")


def play(result: Answer, file: str) -> str:
    """Play an experiment's motion on the arm that was recorded, and record it."""
    motion = result.trajectories.get(file)
    model = nominal(result)
    first = _command("bringup", "--without", "servo_driver", "wire_elasticity")
    rest = [("-m", None if model == USUAL else model), ("--trajectory", beside(result, file)), ("-o", NEW)]
    seconds = f"{ceil(motion.duration) + 1}" if motion else "S"
    return f"{first} \\\n    {shlex.join([*_options(*rest), '--seconds', seconds])}"


def evaluate(result: Answer, model: str) -> str:
    """Score a model on another recording."""
    space = _given(result).get("namespace")
    return _command("evaluate", "another_run", *_options(("-m", model), ("--namespace", space)))


def compensate(result: Answer) -> str:
    """Run the compensator with what was found."""
    return _command("compensator", "--ros-args", "--params-file", beside(result, "model.yaml"))


def export(result: Answer) -> str:
    """Write what was found into a simulator's file."""
    model = beside(result, "model.yaml")
    return _command("export", model, "--to", "mjcf", "--into", "arm.xml", "-o", "arm_real.xml")


def nominal(result: Answer) -> str:
    """The nominal arm as --model takes it: that of a URDF is in the model that was written."""
    model = str(result.provenance.get("model", USUAL))
    return beside(result, "model.yaml") if "urdf" in _given(result) or model == FROM_URDF else model


def beside(result: Answer, file: str) -> str:
    """A file in the folder of the page."""
    return str(Path(_given(result).get("output", ""), file))


def cut(result: Answer) -> list[str]:
    """The options that hold for every recording, also for a new one."""
    given = _given(result)
    return [f"{_flag(key)} {given[key]}" for key in SPANS if key in given]


def _given(result: Answer) -> dict[str, Any]:
    return dict(result.provenance.get("arguments", {}))


def _flag(key: str) -> str:
    return f"--{key.replace('_', '-')}"


def _options(*pairs: tuple[str, Any]) -> list[str]:
    return [word for flag, value in pairs if value is not None for word in (flag, str(value))]


def _command(*words: str) -> str:
    return shlex.join(["trunk_ros", *words])
