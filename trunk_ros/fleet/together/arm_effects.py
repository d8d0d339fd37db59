"""Which effects an arm has, from what was found in its recordings one by one.

A recording alone may call the same physics by another of the names that it cannot tell apart, and may add
one that is not there. What is the arm's own comes back.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trunk_ros.effect_values import Values
from trunk_ros.effects import effect, registry
from trunk_ros.fleet.run.outcome import Row

LEAST = 2  # recordings that show an effect of the arm, where there are so many
SHARE = 0.1  # of them
MOST_ARMS = 0.5  # arms of a type with an effect, from which on it is followed on all of them
EVENTS = ("wire_slip",)  # happen at a moment: what follows is another effect's


@dataclass
class Claim:
    """An effect on some joint (or ``arm``, where it is shared) with what the recordings say of it."""

    effect: str
    joint: str
    support: dict[str, float] = field(default_factory=dict)
    """Confidence by recording."""
    values: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    words: Counter[tuple[str, str]] = field(default_factory=Counter)
    forms: Counter[str] = field(default_factory=Counter)
    rivals: Counter[str] = field(default_factory=Counter)

    @property
    def weight(self) -> float:
        """Recordings that show it, by confidence."""
        return sum(self.support.values())


Claims = dict[tuple[str, str], Claim]


def claims(findings: Iterable[Row]) -> Claims:
    """What the findings of one arm claim, by effect and joint; curves without a name claim nothing."""
    out: Claims = {}
    for row in findings:
        name, joint = row["effect"], row["joint"]
        if name not in registry() or not effect(name).named or name in EVENTS or row["stage"] == "arm":
            continue
        claim = out.setdefault((name, joint), Claim(name, joint))
        claim.support[row["path"]] = row["confidence"]
        claim.forms[row["form"] or ""] += 1
        claim.rivals.update(row["equivalents"] or ())
        if row["word"] is not None:
            claim.words[row["parameter"], row["word"]] += 1
        elif row["value"] is not None:
            claim.values[row["parameter"]].append(row["value"])
    return out


def chosen(claimed: Claims, recordings: int) -> Claims:
    """Those that are the arm's: often enough, and none beside a better one that it stands in for."""
    least = min(max(LEAST, math.ceil(SHARE * recordings)), recordings)
    out: Claims = {}
    for key, claim in sorted(claimed.items(), key=lambda item: -item[1].weight):
        if any(_same(claim, other) for other in out.values()):
            continue
        if len(claim.support) >= least:
            out[key] = claim
    return out


def _same(one: Claim, better: Claim) -> bool:
    """Whether a claim is another name for what a better one says."""
    if one.effect == better.effect:
        return False
    if "arm" not in (one.joint, better.joint) and one.joint != better.joint:
        return False
    if better.effect in effect(one.effect).replaces or one.effect in effect(better.effect).replaces:
        return True
    confused = better.effect in one.rivals or one.effect in better.rivals
    together = len(one.support.keys() & better.support.keys())
    return confused and together < len(one.support) / 2


Followed = dict[str, dict[str, Any]]
"""Effects with where a fit of them starts: values by joint, a float where they are shared, and a form."""


def followed(claimed: Claims) -> Followed:
    """The effects that are claimed, each at the median of what was found."""
    out: Followed = {}
    for name, on in _by_effect(claimed).items():
        kind = effect(name)
        forms: Counter[str] = sum((claim.forms for claim in on.values()), Counter())
        form = forms.most_common(1)[0][0]
        values: dict[str, Any] = {"form": form} if len(kind.forms) > 1 else {}
        for p in kind.own_parameters(form):
            given = {joint: claim.values[p.name] for joint, claim in on.items() if claim.values.get(p.name)}
            if given and p.shared:
                values[p.name] = float(np.median(np.concatenate(list(given.values()))))
            elif given:
                values[p.name] = {joint: float(np.median(numbers)) for joint, numbers in given.items()}
        for text in kind.texts:
            words = {joint: word for joint, claim in on.items() if (word := _word(claim, text))}
            values |= {text: words} if words else {}
        out[name] = values
    return out


def on_joints(effects: Followed, joints: tuple[str, ...]) -> dict[str, Values]:
    """The effects as a model of these joints holds them."""

    def spread(name: str, key: str, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        if key in effect(name).texts:
            return [value.get(joint, "") for joint in joints]
        null = effect(name).parameter(key).null
        return np.array([value.get(joint, null) for joint in joints])

    return {
        name: {key: spread(name, key, value) for key, value in values.items()}
        for name, values in effects.items()
    }


def places(effects: Followed) -> dict[str, dict[str, Any]]:
    """What is followed where, without the values that a fit starts from: what results depend on."""

    def place(value: Any) -> Any:
        return sorted(value) if isinstance(value, dict) else value if isinstance(value, str) else "shared"

    return {name: {key: place(value) for key, value in values.items()} for name, values in effects.items()}


def _word(claim: Claim, text: str) -> str:
    said = [(count, word) for (name, word), count in claim.words.items() if name == text]
    return max(said)[1] if said else ""


def _by_effect(claimed: Claims) -> dict[str, dict[str, Claim]]:
    out: dict[str, dict[str, Claim]] = defaultdict(dict)
    for claim in claimed.values():
        out[claim.effect][claim.joint] = claim
    return out


def of_all(findings: Iterable[Row], recordings: dict[str, int]) -> dict[str, Claims]:
    """The effects of each arm; what most arms of the type have is followed on all of them.

    ``recordings``: how many there are of each arm.
    """
    by_arm: dict[str, list[Row]] = {arm: [] for arm in recordings}
    for row in findings:
        by_arm[row["arm"]].append(row)
    own = {arm: chosen(claims(rows), recordings[arm]) for arm, rows in by_arm.items()}
    for key, claim in _of_most(own):
        for mine in own.values():
            if key not in mine and not any(_same(claim, other) for other in mine.values()):
                mine[key] = claim
    return own


def _of_most(own: dict[str, Claims]) -> Iterator[tuple[tuple[str, str], Claim]]:
    counts = Counter(key for mine in own.values() for key in mine)
    for key, count in counts.items():
        if count > MOST_ARMS * len(own) and len(own) > 1:
            yield key, next(mine[key] for mine in own.values() if key in mine)
