"""What happened at moments of a recording: where findings begin, grow, and end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from trunk_ros.diagnosis.levels import SURE
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.effects import effect, registry
from trunk_ros.parameter import FROM, GROWN, UNTIL

TOGETHER = 0.5  # s, or surely not apart by their spreads: joints on which the same begins
ARM = "arm"
BEGINS, ENDS, GROWS = FROM.name, UNTIL.name, GROWN.name
WORDS = {BEGINS: "begins at", ENDS: "ends at", GROWS: "has its full size at"}
CARRIED = {BEGINS: "is taken up at", ENDS: "is put down at"}

Times = dict[str, tuple[float, float | None]]
"""By moment: when [s], and its standard deviation."""


@dataclass(frozen=True)
class Event:
    """Where a finding begins or ends, s since the recording's first sample; ``std`` of the first moment."""

    effect: str
    joints: list[str]
    begin: float | None
    until: float | None
    grown: float | None
    std: float | None
    statement: str

    def to_json(self) -> dict[str, Any]:
        """As in ``diagnosis.json``."""
        own = {BEGINS: self.begin, ENDS: self.until, GROWS: self.grown}
        return {
            "effect": self.effect, "joints": self.joints, **own, "std": self.std, "statement": self.statement
        }  # fmt: skip


def events(findings: Sequence[Finding]) -> list[Event]:
    """In the order of time."""
    found = [event for finding in findings for event in _of(finding)]
    return sorted(found, key=lambda e: min(t for t in (e.begin, e.until, e.grown) if t is not None))


def _of(finding: Finding) -> list[Event]:
    if finding.effect not in registry():
        return []
    kind = effect(finding.effect)
    out = []
    for what in ("", *(f"{p.name}_" for p in kind.carried())):
        by_joint: dict[str, Times] = {}
        for owner, values in finding.parameters.items():
            times = {
                name: (values[what + name]["value"], values[what + name]["std"])
                for name in WORDS
                if what + name in values
            }
            moments = [p.name for p in kind.parameters if p.moment and p.name in values and not what]
            for name in moments:
                times[BEGINS] = values[name]["value"], values[name]["std"]
            if times:
                by_joint[owner] = times
        out += [_event(finding, what, joints, by_joint[joints[0]]) for joints in _together(by_joint)]
    return out


def _together(by_joint: dict[str, Times]) -> list[list[str]]:
    """Joints on which the same happens at the same time."""
    groups: list[list[str]] = []
    for joint, times in by_joint.items():
        same = next((g for g in groups if _same(by_joint[g[0]], times)), None)
        if same is None:
            groups.append([joint])
        else:
            same.append(joint)
    return groups


def _same(one: Times, other: Times) -> bool:
    return one.keys() == other.keys() and all(
        abs(one[name][0] - other[name][0])
        <= max(TOGETHER, SURE * (one[name][1] or 0.0), SURE * (other[name][1] or 0.0))
        for name in one
    )


def _event(finding: Finding, what: str, owners: list[str], times: Times) -> Event:
    joints = list(finding.joints) if owners == [ARM] else owners
    words = CARRIED if what else WORDS
    said = " and ".join(f"{words[name]} {_time(*times[name])}" for name in words if name in times)
    subject = f"{', '.join(joints)}: {finding.effect.replace('_', ' ')}"
    if what:
        mass = finding.parameters[ARM][what.rstrip("_")]["value"]
        subject = f"tip: {what.rstrip('_')} of {mass:.3g} kg"
    begin, until, grown = (times.get(name, (None, None))[0] for name in (BEGINS, ENDS, GROWS))
    std = next(times[name][1] for name in WORDS if name in times)
    return Event(finding.effect, joints, begin, until, grown, std, f"{subject} {said}.")


def _time(at: float, std: float | None) -> str:
    return f"{at:.2f} s" if std is None else f"{at:.2f} s ± {std:.2g} s"
