"""The table: rms of measured less predicted, a row for each recording, joint and model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from test.real.features import Array, Run, ends, run_of
from test.real.peers import PEERS
from test.real.sets import RealSet
from trunk_ros.diagnosis import diagnose
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import Recording
from trunk_ros.simulate import simulate
from trunk_ros.start import SETTLE

HERE, NOMINAL = "here", "nominal"
WITHIN = 1.05  # of the best peer


@dataclass(frozen=True)
class Row:
    """One recording and joint: rms by model, in the joint's unit."""

    recording: str
    joint: str
    rms: dict[str, float]

    @property
    def best(self) -> float:
        """The least of the peers, doing nothing included."""
        return min(value for name, value in self.rms.items() if name != HERE)

    @property
    def reached(self) -> bool:
        """Whether this project is near enough to the best of the others."""
        return self.rms[HERE] <= WITHIN * self.best


def compared(real: RealSet, home: Path, peers: Sequence[str], every: bool = False) -> list[Row]:
    """All rows of one set; ``every``: the first seconds count as well, and what was not seen as 0, as the
    published tables have it.
    """
    read = {name: real.read(home, name) for name in (*real.fitted, *real.judged)}
    model = diagnose(
        [read[name] for name in real.fitted], model="direct", until=f"{100 * real.share:g}%"
    ).model
    first = read[real.fitted[0]]
    own = [first.require(ends(first)[0]).joints.index(joint) for joint in real.joints]
    servo = ends(first)[0] == "setpoints"
    seen = [_head(run_of(read[name], real.joints), real.share) for name in real.fitted]
    seen = [replace(run, angles=run.angles - _nothing(run, own)) for run in seen] if servo else seen
    fitted = {name: PEERS[name](seen, own) for name in peers}
    out = []
    for name, rest in real.rows():
        run = run_of(read[name], real.joints)
        begin = real.share * run.stamp[-1] if rest else run.stamp[0] + SETTLE
        rows = run.stamp > (begin if rest or not every else -np.inf)
        said = {
            HERE: _simulated(read[name], model, real),
            NOMINAL: _nothing(run, own) if servo else _simulated(read[name], load_model("direct"), real),
        }
        asked = _nothing(run, own) if servo else 0.0  # what peers predict of a servo is how far off it is
        said |= {peer: asked + predict(run) for peer, predict in fitted.items()}
        seen_there = np.nan_to_num(run.angles) if every else run.angles
        errors = {m: np.sqrt(np.nanmean((p - seen_there)[rows] ** 2, axis=0)) for m, p in said.items()}
        label = f"{name}, last {100 * (1 - real.share):.0f} %" if rest else name
        out += [
            Row(label, joint, {m: float(e[j]) for m, e in errors.items()})
            for j, joint in enumerate(real.joints)
        ]
    return out


def _nothing(run: Run, own: list[int]) -> Array:
    """A servo that is where it was asked to be."""
    return run.commands[:, own]


def _simulated(recording: Recording, model: Model, real: RealSet) -> Array:
    source, topic = ends(recording)
    predicted = simulate(recording, model, source).series[topic]
    shown = recording.require(topic).stamp
    there = predicted.select(real.joints).position
    if len(predicted.stamp) == len(shown):
        return there
    return np.column_stack([np.interp(shown, predicted.stamp, column) for column in there.T])


def _head(run: Run, share: float) -> Run:
    return run.part(0, int(np.searchsorted(run.stamp, share * run.stamp[-1], side="right")))


def written(real: RealSet, rows: list[Row]) -> str:
    """A table of one set, in thousandths of the joints' unit; * where this project is not near the best."""
    names = list(rows[0].rms)
    lines = [f"| {real.folder} | joint | {' | '.join(names)} |", "|---|---|" + "---|" * len(names)]
    for row in rows:
        values = [f"{1e3 * row.rms[n]:.3g}" + ("" if n != HERE or row.reached else " *") for n in names]
        lines.append(f"| {row.recording} | {row.joint} | {' | '.join(values)} |")
    return "\n".join(lines)
