"""The seeds of the proof, and what is drawn from each. Building and tuning take seeds below 50 000, of the
fourth plant below 252 000.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from test.concealed.case import Case, draw_case
from test.concealed.masses_case import KINDS as MASSES
from test.concealed.masses_case import draw_masses_case
from test.concealed.mujoco_case import draw_mujoco_case
from test.concealed.wire_case import KINDS, draw_wire_case

CONCEALED = {
    "singles": range(50_000, 50_270),  # ten rounds of the 27 effects, from half the noise to ten times it
    "pairs": range(51_000, 51_090),
    "triples": range(52_000, 52_060),
    "unknown": range(53_000, 53_078),  # physics outside the table, six rounds of 13
    "hard": range(54_000, 54_060),  # one to four effects; coloured noise, 25 Hz, losses, drifting clock …
    "wire": range(55_000, 55_042),  # finite-element wires
    "mujoco": range(56_000, 56_060),  # tendons, masses and friction in an engine, four rounds of 15
    "masses": range(252_000, 252_090),  # integrated from inertia, wires, friction and weight, five of 18
    "everyday": range(252_500, 252_554),  # such arms at work: motions that were not made to identify anything
    "events": range(253_000, 253_056),  # such arms to which something happens in mid-run, seven rounds of 8
    "awkward": range(254_000, 254_108),  # such arms under sensors, clocks and loggers of 12 kinds, nine times
}
CLEAN = {
    "clean": range(60_000, 60_210),
    "clean_hard": range(61_000, 61_060),
    "clean_wire": range(62_000, 62_030),
    "clean_mujoco": range(63_000, 63_030),
    "clean_masses": range(255_000, 255_030),
    "clean_everyday": range(256_000, 256_050),
    "clean_awkward": range(257_000, 257_096),
}
LIVE = range(70_000, 70_012)  # arms on the live graph, each with three effects
LIVE_MANY = range(71_000, 71_008)  # each with five to eight
KNOBS: dict[str, dict[str, Any]] = {
    "singles": {"count": 1, "level": (0.5, 10.0)}, "pairs": {"count": 2}, "triples": {"count": 3},
    "unknown": {"unknown": True}, "hard": {"count": None, "hard": True},
    "clean": {"count": 0}, "clean_hard": {"count": 0, "hard": True},
}  # fmt: skip
PART = 150


def drawn(kind: str, seed: int) -> Case:
    """The arm of a seed. Raises RuntimeError where it does not come out at its strength."""
    if kind == "clean_wire":
        return draw_wire_case(seed, "clean")
    if kind == "wire":
        return draw_wire_case(seed, KINDS[1:][seed % len(KINDS[1:])])
    if kind == "clean_mujoco":
        return draw_mujoco_case(seed, "clean")
    if kind == "mujoco":
        return draw_mujoco_case(seed)
    if kind in MASSES:
        return draw_masses_case(seed, kind)
    return draw_case(seed, **KNOBS[kind])


def in_turn(full: bool, kinds: Collection[str] = ()) -> list[tuple[str, int]]:
    """(kind, seed) so that any first part holds all kinds, or those that are asked for, in their shares; the
    part or everything.
    """
    both = {kind: some for kind, some in {**CONCEALED, **CLEAN}.items() if not kinds or kind in kinds}
    placed = [
        ((n + 0.5) / len(some), kind, seed) for kind, some in both.items() for n, seed in enumerate(some)
    ]
    order = [(kind, seed) for _, kind, seed in sorted(placed)]
    return order if full else order[:PART]
