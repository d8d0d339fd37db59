"""Rows of errors for recordings, models and simulators."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from trunk_ros.data.put_right import as_diagnosed, said_of
from trunk_ros.data.quality import strangers
from trunk_ros.data.sensing import readings_put_right
from trunk_ros.diagnosis.simulators.against import nominal_for
from trunk_ros.errors import ArgumentError
from trunk_ros.evaluate.score import Row, score
from trunk_ros.evaluate.source import Prediction, of_model, of_simulator
from trunk_ros.evaluate.speeds import too_slow
from trunk_ros.model import Model, load_model
from trunk_ros.own_time import doubtful_curves
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.transmission import by_joint
from trunk_ros.words import significant

FAILED = 3
STAGES = ("servo", "wire", "arm")


def evaluated(arguments: argparse.Namespace) -> list[Row]:
    """All rows, recording by recording, of the readings that ``diagnose`` compares with the same model.
    Raises TrunkError in one line.
    """
    models = [(name, load_model(name)) for name in arguments.model]
    rows: list[Row] = []
    said: list[str] = []
    names = called(arguments.bag)
    with Console(stderr=True).status("reading") as status:
        shared = shared_out(arguments.bag, arguments.against)
        for bag, called_so, simulators in zip(arguments.bag, names, shared, strict=True):
            status.update(f"{bag}")
            recording = read_recording(bag, namespace=arguments.namespace)
            predictions, notes = _of_models(recording, models)
            if simulators:
                others, more = _of_simulators(recording, simulators, models)
                predictions, notes = predictions + others, notes + more
            said += [f"{called_so}: {note}" for note in dict.fromkeys(notes)]
            rows += score(called_so, predictions, arguments.settle)
    kept = [row for row in rows if row.stage in (arguments.stage or STAGES)]
    for line in [*said, *_unstated(models, kept)]:
        print(f"trunk_ros: {line}", file=sys.stderr)
    if not kept:
        raise ArgumentError("evaluate: none of the recordings has a signal of these stages to compare")
    return kept


def _unstated(models: Sequence[tuple[str, Model]], rows: Sequence[Row]) -> list[str]:
    """Of models without a servo: their servo's errors are those of numbers that nobody gave."""
    judged = {row.model for row in rows if row.stage == "servo"}
    return [
        f"{name} has no servo section, so its servo rows are those of trunk's servo: compare the wire rows, "
        "or give the servo that diagnose found (section servo of its model.yaml)"
        for name, model in models
        if name in judged and not model.arm.servo_stated
    ]


def _of_models(
    recording: Recording, models: Sequence[tuple[str, Model]]
) -> tuple[list[Prediction], list[str]]:
    """Predictions of models, each for the readings as its own arm puts them right, and what to say."""
    predictions, notes, read = [], [], dict[str, Recording]()
    for name, model in models:
        arm = replace(model, effects={}, recordings=()).hash()
        read[arm] = right = read.get(arm) or as_diagnosed(recording, model)
        doubts = [*strangers(by_joint(recording, model.arm), model), *doubtful_curves(recording, model)]
        doubts += too_slow(right, model)
        notes += [*said_of(right), *(f"{doubt} ({name})" for doubt in doubts)]
        predictions.append(of_model(right, name, model))
    return predictions, notes


def _of_simulators(
    recording: Recording, paths: Sequence[str], models: Sequence[tuple[str, Model]]
) -> tuple[list[Prediction], list[str]]:
    """Those of simulators, whose turns are counted on as well; by the first model's arm, else that which
    ``diagnose --against`` takes.
    """
    model = models[0][1] if models else nominal_for(recording.joints)
    right = as_diagnosed(recording, model)
    read = [readings_put_right(read_recording(path), model) for path in paths]
    predictions = [of_simulator(right, path, one, read[0]) for path, one in zip(paths, read, strict=True)]
    return predictions, said_of(right)


def called(bags: Sequence[str]) -> list[str]:
    """What the bags are called: the names of their folders or files, whole paths where these are the same."""
    short = [Path(bag).name for bag in bags]
    return [bag if short.count(name) > 1 else name for bag, name in zip(bags, short, strict=True)]


def shared_out(bags: Sequence[str], simulators: Sequence[str]) -> list[list[str]]:
    """The simulator's recordings of each bag's motion: one after the other, as the bags are given."""
    if len(simulators) % len(bags):
        raise ArgumentError(
            f"evaluate: {len(bags)} recordings and {len(simulators)} of --against: give each simulator's "
            "recordings of the same motions, in the same order"
        )
    return [list(simulators[k :: len(bags)]) for k in range(len(bags))]


def compared_with(bags: Sequence[str], simulators: Sequence[str]) -> list[str]:
    """The first simulator's recordings, where there are others: what these are compared with."""
    return list(simulators[: len(bags)]) if len(simulators) > len(bags) else []


def verdict(rows: Sequence[Row], most: float | None, left_out: Collection[str] = ()) -> int:
    """3, and a line on stderr, where an rms error is more than ``most`` times the noise; of models and
    simulators that are not named ``left_out``.
    """
    rows = [row for row in rows if row.model not in left_out]
    above = [row for row in rows if most is not None and not row.in_noise <= most]
    if not above:
        return 0
    worst = max(above, key=lambda row: row.in_noise)
    noise = f": {significant(worst.in_noise)}" if worst.has_noise else ", which has no noise"
    print(
        f"trunk_ros: {len(above)} of {len(rows)} signals err by more than {most:g} times the noise, "
        f"most of all {worst.stage} {worst.joint} of {worst.recording} ({worst.model}){noise}",
        file=sys.stderr,
    )
    return FAILED
