"""Rows of errors for recordings, models and simulators."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection, Sequence
from pathlib import Path

from rich.console import Console

from trunk_ros.diagnosis.data.quality import strangers
from trunk_ros.diagnosis.data.sensor_faults import without_faults
from trunk_ros.diagnosis.words import significant
from trunk_ros.errors import ArgumentError
from trunk_ros.evaluate.score import Row, score
from trunk_ros.evaluate.source import of_model, of_simulator
from trunk_ros.model import load_model
from trunk_ros.own_time import doubtful_curves
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.transmission import by_joint

FAILED = 3
STAGES = ("servo", "wire", "arm")


def evaluated(arguments: argparse.Namespace) -> list[Row]:
    """All rows, recording by recording, without readings that a sensor never made. Raises TrunkError in one
    line.
    """
    models = [(name, load_model(name)) for name in arguments.model]
    rows: list[Row] = []
    left_out: list[str] = []
    names = called(arguments.bag)
    with Console(stderr=True).status("reading") as status:
        shared = shared_out(arguments.bag, arguments.against)
        for bag, called_so, simulators in zip(arguments.bag, names, shared, strict=True):
            status.update(f"{bag}")
            recording = without_faults(read_recording(bag, namespace=arguments.namespace))
            left_out += [f"{called_so}: {note}" for note in recording.notes]
            predictions = [of_model(recording, name, model) for name, model in models]
            read: list[Recording] = [read_recording(path) for path in simulators]
            for name, model in models:
                notes = strangers(by_joint(recording, model.arm), model)
                left_out += [
                    f"{called_so}: {note} ({name})" for note in [*notes, *doubtful_curves(recording, model)]
                ]
            predictions += [
                of_simulator(recording, str(path), one, read[0])
                for path, one in zip(simulators, read, strict=True)
            ]
            rows += score(called_so, predictions, arguments.settle)
    for line in left_out:
        print(f"trunk_ros: {line}", file=sys.stderr)
    kept = [row for row in rows if row.stage in (arguments.stage or STAGES)]
    if not kept:
        raise ArgumentError("evaluate: none of the recordings has a signal of these stages to compare")
    return kept


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
