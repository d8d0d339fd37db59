"""What happens to an integrated arm in the middle of a run, and what that is called."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from test.concealed.draws import ALL, Rng, logarithmic, signed, sizes
from test.concealed.hidden import Hidden
from test.concealed.masses_arm import Arm, having, soft
from test.concealed.masses_draw import carried, place
from test.concealed.mujoco_draw import Wish
from test.concealed.nominal import COMPLIANCE, HALF_WIDTH, Array, load

Make: TypeAlias = Callable[[Arm], Arm]


def _same(arm: Arm) -> Arm:
    return arm


@dataclass(frozen=True)
class Event:
    """An arm that becomes another from one moment of the run (s) until another, or little by little.

    base: how it is made without being wrong; before, after: how it is wrong outside of that time, and within.
    """

    hidden: Hidden
    after: Make
    begin: float
    until: float = np.inf
    base: Make = _same
    before: Make = _same
    slowly: Callable[[float], Make] | None = None

    def arms(self, happens: bool = True) -> list[tuple[float, Arm]]:
        """From when (s) the arm is built how."""
        base = self.base(Arm())
        if not happens:
            return [(0.0, base)]
        if self.slowly is not None:
            parts = np.linspace(0.0, 1.0, 200)[1:]
            when = self.begin + parts * (self.until - self.begin)
            grown = [(float(t), self.slowly(float(x))(base)) for t, x in zip(when, parts, strict=True)]
            return [(0.0, base), *grown]
        there, back = self.after(base), self.before(base)
        return [one for one in ((0.0, back), (self.begin, there), (self.until, back)) if np.isfinite(one[0])]


Draw: TypeAlias = Callable[[Rng, Wish, float], Event]
EVENTS: dict[str, Draw] = {}


def _event(draw: Draw) -> Draw:
    EVENTS[draw.__name__] = draw
    return draw


def _once(rng: Rng, wish: Wish, seconds: float) -> float:
    """When one of its joints has gone a third to two thirds of its way, or of the time if it rests: what
    happens before a joint moves at all, or afterwards, no recording shows.
    """
    gone = (np.abs(np.diff(wish.theta[:, wish.joints[0]])) + 1e-12).cumsum()
    return float(np.searchsorted(gone, rng.uniform(0.3, 0.65) * gone[-1])) / len(gone) * seconds


def _told(effect: str, joints: tuple[int, ...], form: str, values: dict[str, Any], begin: float,
          until: float = np.inf, same: tuple[str, ...] = ()) -> Hidden:  # fmt: skip
    moments = {"from": begin} | ({"until": until} if np.isfinite(until) else {})
    return Hidden(effect, joints, form, values, same, moments)


@_event
def payload_picked_up(rng: Rng, wish: Wish, seconds: float) -> Event:
    """A weight is taken up and, mostly, put down again; the wires stretch all the time."""
    begin, payload, upstream = (
        float(rng.uniform(0.2, 0.45)) * seconds,
        float(logarithmic(rng, 0.03, 0.2)),
        place(rng),
    )
    until = float(rng.uniform(0.6, 0.85)) * seconds if rng.uniform() < 0.7 else np.inf
    values = {"compliance": COMPLIANCE.copy(), "payload": payload}
    told = _told("load_elasticity", ALL, "payload", values, begin, until, ("compliance",))

    def empty(b: Arm) -> Arm:
        return soft(b, ALL, COMPLIANCE, upstream)

    return Event(told, lambda b: replace(empty(b), payload=payload), begin, until, before=empty)


@_event
def ratio_changes(rng: Rng, wish: Wish, seconds: float) -> Event:
    """A wire climbs to another radius of its wheel."""
    begin, relative = _once(rng, wish, seconds), wish.per(wish.theta) * signed(rng, len(wish.joints))
    told = _told("ratio_error", wish.joints, "climbs", {"relative": relative}, begin, same=("relative",))
    return Event(told, lambda b: having(b, wish.joints, wheel=1 + relative), begin)


@_event
def screw_loosens(rng: Rng, wish: Wish, seconds: float) -> Event:
    """From a moment on the wheel has play on its shaft."""
    begin, gap = _once(rng, wish, seconds), wish.size * 1.5 * sizes(rng, len(wish.joints))
    told = _told("backlash", wish.joints, "loose", {"half_width": gap}, begin, same=("half_width",))
    return Event(told, lambda b: having(b, wish.joints, gap=gap), begin)


@_event
def rubs(rng: Rng, wish: Wish, seconds: float) -> Event:
    """Something gets into the joint and rubs from then on."""
    begin, joints = _once(rng, wish, seconds), wish.joints
    more, base = wish.size * 1.5 * sizes(rng, len(joints)), COMPLIANCE[list(joints)]
    told = _told("backlash", joints, "rubs", {"half_width": more}, begin, same=("half_width",))
    wide = (HALF_WIDTH[list(joints)] + more) / base
    return Event(
        told,
        lambda b: having(b, joints, joint=wide),
        begin,
        base=lambda b: soft(carried(b), joints, base, 1.0),
    )


@_event
def tension_rises(rng: Rng, wish: Wish, seconds: float) -> Event:
    """All wires are pulled harder from a moment on: every dead band grows by one factor."""
    begin, factor = _once(rng, wish, seconds), 1 + 1.5 * wish.size / float(HALF_WIDTH.mean())
    told = _told("tension_error", ALL, "pressed", {"factor": factor}, begin, same=("factor",))
    return Event(told, lambda b: replace(b, capstan=b.capstan * factor), begin)


@_event
def wire_slips(rng: Rng, wish: Wish, seconds: float) -> Event:
    """A wire slips in its clamp."""
    begin, step = _once(rng, wish, seconds), wish.size * 1.5 * signed(rng, len(wish.joints))
    values = {"onset": np.full(len(step), begin), "step": step}
    told = _told("wire_slip", wish.joints, "clamp", values, begin, same=("onset", "step"))
    return Event(told, lambda b: having(b, wish.joints, zero=step), begin)


def _softer(rng: Rng, wish: Wish) -> tuple[Array, float]:
    base = COMPLIANCE[list(wish.joints)]
    wanted = 1.5 * wish.per(load(wish.theta)) * sizes(rng, len(base))
    return np.clip(wanted, 0.05 * base, 4 * base), float(rng.integers(2))


@_event
def strand_breaks(rng: Rng, wish: Wish, seconds: float) -> Event:
    """A wire that was stiff gives way from a moment on."""
    begin, (gives, upstream) = _once(rng, wish, seconds), _softer(rng, wish)
    told = _told("load_elasticity", wish.joints, "breaks", {"compliance": gives}, begin, same=("compliance",))
    return Event(told, lambda b: soft(b, wish.joints, gives, upstream), begin)


@_event
def softens(rng: Rng, wish: Wish, seconds: float) -> Event:
    """A wire gives way more and more."""
    begin, until = 0.15 * seconds, 0.9 * seconds
    gives, upstream = _softer(rng, wish)
    told = _told("load_elasticity", wish.joints, "grows", {"compliance": gives}, begin, until)

    def so_far(share: float) -> Make:
        return lambda b: soft(b, wish.joints, share * gives, upstream)

    return Event(told, so_far(1.0), begin, until, slowly=so_far)
