"""What happened at moments of a recording: where findings begin, grow, change their size, and end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.effects import effect, registry
from trunk_ros.levels import PART, SURE, TOGETHER
from trunk_ros.parameter import FROM, GROWN, SPELL_NAMES, UNTIL

ARM = "arm"
BEGINS, ENDS, GROWS = FROM.name, UNTIL.name, GROWN.name
WORDS = {BEGINS: "begins at", ENDS: "ends at", GROWS: "has its full size at"}
CARRIED = {BEGINS: "is taken up at", ENDS: "is put down at"}
AGAIN = {BEGINS: "comes back at", ENDS: "ends at"}
CHANGED = {BEGINS: "is {:.3g} times as large from", ENDS: "ends at"}
RESTORED = {BEGINS: "is as large as at first from", ENDS: "ends at"}
CARRIED_AGAIN = {BEGINS: "is carried from", ENDS: "is put down at"}
SIZE = "times"

Times = dict[str, tuple[float, float | None]]
"""By moment: when [s], and its standard deviation."""


@dataclass(frozen=True)
class Event:
    """Where a finding begins or ends, s since the recording's first sample; ``std`` of the first moment.

    ``times``: how many times its first size it has from then on, where it is not the first.
    """

    effect: str
    joints: list[str]
    begin: float | None
    until: float | None
    grown: float | None
    times: float | None
    std: float | None
    statement: str

    def to_json(self) -> dict[str, Any]:
        """As in ``diagnosis.json``."""
        own = {BEGINS: self.begin, ENDS: self.until, GROWS: self.grown, SIZE: self.times}
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
    out = []
    for what in ("", *(f"{p.name}_" for p in effect(finding.effect).carried())):
        for number in range(len(SPELL_NAMES)):
            by_joint = {owner: _times(finding, owner, what, number) for owner in finding.parameters}
            by_joint = {owner: times for owner, times in by_joint.items() if times}
            for joints in _together(by_joint):
                goes_on = number > 0 and ENDS not in _times(finding, joints[0], what, number - 1)
                out.append(_event(finding, what, number, joints, by_joint[joints[0]], goes_on))
    return out


def _times(finding: Finding, owner: str, what: str, number: int) -> Times:
    """The moments of a joint or of all, and of later ones how much of the first size is there then."""
    kind, values = effect(finding.effect), finding.parameters[owner]
    begins, ends, times = (f"{what}{name}" for name in SPELL_NAMES[number])
    names = {BEGINS: begins, ENDS: ends} | ({SIZE: times} if number else {GROWS: what + GROWS})
    onset = next((p.name for p in kind.parameters if p.moment and p.name in values), None)
    if onset and not number and not what:
        names[BEGINS] = onset
    if what and not _there(values.get(what.rstrip("_"))):
        return {}
    found = {
        name: (values[said]["value"], values[said]["std"]) for name, said in names.items() if said in values
    }
    return found if found.keys() - {SIZE} else {}


def _there(held: dict[str, Any] | None) -> bool:
    """Whether something is carried at all: of what may weigh nothing no event is told."""
    return held is not None and bool(abs(held["value"]) > SURE * (held["std"] or 0.0))


def _together(by_joint: dict[str, Times]) -> list[list[str]]:
    """Joints on which the same happens at the same time, or surely not apart by their spreads."""
    groups: list[list[str]] = []
    for joint, times in by_joint.items():
        same = next((g for g in groups if _same(by_joint[g[0]], times)), None)
        if same is None:
            groups.append([joint])
        else:
            same.append(joint)
    return groups


def _same(one: Times, other: Times) -> bool:
    alike = {SIZE: PART} | dict.fromkeys(WORDS, TOGETHER)
    return one.keys() == other.keys() and all(
        abs(one[name][0] - other[name][0])
        <= max(alike[name], SURE * (one[name][1] or 0.0), SURE * (other[name][1] or 0.0))
        for name in one
    )


def _event(finding: Finding, what: str, number: int, owners: list[str], times: Times, goes_on: bool) -> Event:
    """``goes_on``: what was there before had not ended."""
    joints = list(finding.joints) if owners == [ARM] else owners
    factor = times.get(SIZE, (1.0, None))[0]
    words = WORDS if not number else CHANGED if SIZE in times else RESTORED if goes_on else AGAIN
    if what:
        words = CARRIED_AGAIN if number else CARRIED
    said = " and ".join(f"{words[name]} {_time(*times[name])}" for name in words if name in times)
    subject = f"{', '.join(joints)}: {finding.effect.replace('_', ' ')}"
    if what:
        mass = factor * finding.parameters[ARM][what.rstrip("_")]["value"]
        subject = f"tip: {what.rstrip('_')} of {mass:.3g} kg"
    begin, until, grown = (times.get(name, (None, None))[0] for name in (BEGINS, ENDS, GROWS))
    std = next(times[name][1] for name in WORDS if name in times)
    return Event(
        finding.effect,
        joints,
        begin,
        until,
        grown,
        factor if number else None,
        std,
        f"{subject} {said.format(factor)}.",
    )


def _time(at: float, std: float | None) -> str:
    return f"{at:.2f} s" if std is None else f"{at:.2f} s ± {std:.2g} s"
