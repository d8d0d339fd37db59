"""What to do with a diagnosis, the most useful first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil
from typing import Any

from trunk_ros.diagnosis.report import commands
from trunk_ros.diagnosis.report.signals import judged, mixed_up
from trunk_ros.diagnosis.report.units import spoken
from trunk_ros.diagnosis.verdict.answer import Answer
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.effects import registry
from trunk_ros.recording.topics import COMPARED, TOPICS
from trunk_ros.words import listed

BETWEEN = {"servo": "the servos", "wire": "the transmission", "arm": "the tip"}


@dataclass(frozen=True)
class Step:
    """``do`` in bold, ``why`` beside it, ``commands`` to paste."""

    do: str
    why: str = ""
    commands: tuple[str, ...] = ()


def next_steps(result: Answer) -> list[Step]:
    """Put the data right, use the model, record what decides, measure what is missing, look at the rest."""
    return [
        *_nothing(result),
        *_mixed_up(result),
        *_use(result),
        *_record(result),
        *_topics(result),
        *_move(result),
        *_rest(result),
    ]


def _nothing(result: Answer) -> Iterator[Step]:
    if result.verdict == "no_mismatch" and judged(result):
        check = commands.evaluate(result, commands.nominal(result))
        yield Step("Nothing to change.", "Check the simulation on another motion:", (check,))


def _mixed_up(result: Answer) -> Iterator[Step]:
    for statement in dict.fromkeys(one.rstrip(".") for said in mixed_up(result).values() for one in said):
        yield Step("Put the data right and diagnose again.", f"{statement}.")


def _use(result: Answer) -> Iterator[Step]:
    if not result.simulation and any(_compensated(f) for f in result.findings):
        yield Step(
            "Compensate with this model",
            "(model.yaml, beside this page), and score it on a recording that the fit did not see:",
            (commands.compensate(result), commands.evaluate(result, commands.beside(result, "model.yaml"))),
        )
    if result.findings:
        yield Step(
            "Put what was found into your simulator.",
            "Formats: MJCF, URDF, SDF; arm.xml is your simulator's own file.",
            (commands.export(result),),
        )


def _compensated(finding: Finding) -> bool:
    """Whether there is anything to compensate: where only a reading is late, the joint is not."""
    kind = registry().get(finding.effect)
    return finding.stage != "arm" and not (kind is not None and kind.delays_readings)


def _record(result: Answer) -> Iterator[Step]:
    pairs: dict[str, list[list[Any]]] = {}
    for one in result.experiments:
        if one.get("trajectory"):
            pairs.setdefault(one["trajectory"], []).append(one.get("separates", []))
    for file, separated in pairs.items():
        motion = result.trajectories.get(file)
        long = f", {ceil(motion.duration)} s" if motion else ""
        told = listed([" from ".join(spoken(name) for name in pair) for pair in separated if pair])
        yield Step(
            f"Record this motion: {file}{long}.", f"It tells {told}; see “Decisive motion”." if told else ""
        )


def _topics(result: Answer) -> Iterator[Step]:
    seen = {key for held in result.quality.values() for key in held.get("topics", {})}
    lost: dict[str, list[str]] = {}
    for stage, keys in COMPARED.items():
        absent = [TOPICS[key] for key in keys if key not in seen]
        if seen and absent and not result.stages.get(stage, {}).get("compared"):
            lost.setdefault(listed(absent), []).append(BETWEEN[stage])
    for topics, what in lost.items():
        yield Step(f"Record {topics} too.", f"Without it {listed(what)} cannot be judged.")


def _move(result: Answer) -> Iterator[Step]:
    for stage, said in result.stages.items():
        if said.get("compared") and said.get("silent"):
            still = said["silent"]
            yield Step(
                f"Move {listed(still)} further.", f"Nothing can be said of {stage} there: too little motion."
            )


def _rest(result: Answer) -> Iterator[Step]:
    nameless = any(not f.named for f in result.findings)
    told = {statement for said in mixed_up(result).values() for statement in said}
    joints = dict.fromkeys(
        joint for rest in result.unexplained if rest.statement not in told for joint in rest.joints
    )
    if joints or nameless:
        where = f" of {listed(list(joints))}" if joints else ""
        yield Step(
            f"Look at the residual{where} under “Over time”.",
            "An effect that the library lacks is one file: docs/adding-an-effect.md.",
        )
