"""What ``diagnosis.json`` says of a bank: which motions it is of, and what each adds."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Term
from trunk_ros.effects.bank import Bank, joints_of

POINTS = 200  # of a loop


def sources_of(term: Term, column: int) -> list[str]:
    """The motions that a column's bank is of."""
    return list(term.words[column].values())


def varies_with(term: Term) -> list[str]:
    """All motions that the banks of a term are of, each once: the bank of another joint may have a sum or a
    difference the other way round.
    """
    words = (word for column in term.columns for word in sources_of(term, column))
    kept: list[str] = []
    for motion in sorted({motion for word in words for motion in joints_of(word)}):
        turned = [motion[k + 1 :] + sign + motion[:k] for k, sign in enumerate(motion) if sign in "+-"]
        if not set(turned).intersection(kept):
            kept.append(motion)
    return kept


def statement(kind: type[Bank], term: Term, where: str) -> str:
    """One sentence."""
    on = " and ".join(varies_with(term))
    if kind.fades:
        return f"{where}: loops are others at first and settle, in a way that no name fits."
    if kind.axes > 1:
        return f"{where}: where {on} stand together moves the angle along a surface that no name fits."
    if kind.by_posture:
        return f"{where}: loops change with the posture in a way that no name fits; plays stand in."
    if not kind.named:
        return f"{where}: the angle remembers the motion of {on} in a way that no name fits; plays stand in."
    if kind.regime == "reversal":
        return f"{where}: the motion of {on} drags the joint along, contact after contact."
    return f"{where}: the posture of {on} moves the joint along a curve."


def parameters(context: Context, kind: type[Bank], term: Term) -> dict[str, dict[str, dict[str, Any]]]:
    """By joint: each source, and how far it moves the joint at most over its range."""
    out: dict[str, dict[str, dict[str, Any]]] = {}
    for column in term.columns:
        unit = context.stage.unit(column)
        told = out[context.joints[column]] = {}
        for k, word in enumerate(sources_of(term, column), start=1):
            number = "" if k == 1 else f"_{k}"
            told[f"source{number}"] = {"value": word, "std": None, "unit": ""}
            size = float(np.ptp(_loop(kind, term.own[column], k)[1]))
            told[f"size{number}"] = {"value": size, "std": None, "unit": unit}
    return out


def told(context: Context, kind: type[Bank], term: Term) -> dict[str, Any]:
    """The first source's curve, loop or surface by joint, with what it is over and of, and their units."""
    column = term.columns[0]
    word = sources_of(term, column)[0] if kind.axes == 1 else "position"
    own = context.stage.unit(column)
    return {
        "on": word,
        "of": "the angle",
        "x_unit": context.stage.units.get(word, "rad") if word in context.joints else own,
        "y_unit": own,
        "joints": {context.joints[c]: _drawn(kind, term, c) for c in term.columns},
    }


def _drawn(kind: type[Bank], term: Term, column: int) -> dict[str, Any]:
    """What the first source of a column adds, ``y`` over ``x``; of two motions a row for each place of the
    joint itself, with where the other joint stands in each column.
    """
    if kind.axes == 1:
        return dict(zip(("x", "y"), _loop(kind, term.own[column], 1), strict=True))
    low, high, weights = kind.read(term.own[column], 1)
    side = POINTS // 10
    x, other = np.linspace(low, high, side).T
    both = np.stack(np.meshgrid(x, other, indexing="ij"), axis=-1).reshape(-1, kind.axes)
    y = (kind.shapes(both, low, high) @ weights).reshape(side, side)
    return {"x": x, "with": joints_of(sources_of(term, column)[0])[1], "with_x": other, "y": y}


def _loop(kind: type[Bank], own: dict[str, float], k: int) -> tuple[Array, Array]:
    """What a source adds, over one large swing to and fro about its centre."""
    low, high, weights = kind.read(own, k)
    bottom, top = kind.swing(low, high)
    swing = np.linspace(0.5 * (bottom + top), top, POINTS // 4)
    path = np.concatenate(
        [swing, np.linspace(top, bottom, POINTS // 2), np.linspace(bottom, top, POINTS // 2)]
    )
    added = kind.shapes(path, low, high) @ weights
    settled = len(swing)
    return path[settled:], added[settled:]
