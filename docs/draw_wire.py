"""The picture and the table of wire.md: the paper's formula, the pair of wires, and finite elements."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

from test.concealed.wire_fe import Pair, joint_angle, nodes_of, pair_of, tensions_of
from trunk_ros.arm import Wire
from trunk_ros.compiled import Array
from trunk_ros.effects.wire.distributed_wire import pieces_of
from trunk_ros.effects.wire.wire_pair import WirePair
from trunk_ros.model import load_model

matplotlib.use("Agg")
from matplotlib import pyplot as plt

ARM = load_model("trunk").arm
JOINT = 4
TENSION = 8.0  # N
PAIR, ELEMENTS, PAPER = "#2166ac", "#222222", "#c8453b"
TABLE_HEAD = """| joint | eq. (6), 1 N | pair, 1 N | finite elements, 1 N | pretension for the nominal band |
|---|---|---|---|---|
"""


def wire() -> Wire:
    """The nominal wire."""
    if ARM.wire is None:
        raise ValueError("config/trunk.yaml lost its wire")
    return ARM.wire


def elements(joint: int, tension: float) -> Pair:
    """The same wire as finite elements: there the arcs come on top of l' and l''."""
    arcs = wire().shaft_radius * wire().a1[joint], wire().shaft_radius * wire().a2[joint]
    straight = float(wire().length1[joint] - arcs[0]), float(wire().length2[joint] - arcs[1])
    return replace(pair_of(joint, tension), straight=straight)


def pair(u: Array, load: Array, tension: float) -> tuple[Array, Any]:
    """Joint angles (n, joints) rad and memory of the pair, for (n,) rad before it and (n,) N m."""
    soft, grip = pieces_of(wire(), np.ones(5))
    band = ARM.dead_band[None]
    loads = np.tile(load[:, None], (1, 5))
    element = WirePair(np.full(5, tension), wire().cylinder_radius, soft, grip, band, loads)
    return element.run(np.tile(u[:, None], (1, 5)), band, None)


def half_widths(tension: float) -> tuple[Array, Array]:
    """Dead bands (joints,) rad of the pair and of the finite elements."""
    u = np.linspace(0.0, 0.02, 400)
    ours = u[-1] - pair(u, 0.0 * u, tension)[0][-1]
    theirs = [u[-1] - joint_angle(elements(j, tension), u / ARM.ratio[j])[-1] for j in range(5)]
    return ours, np.array(theirs)


def table() -> str:
    """Dead bands of all joints in mrad, and the pretension that gives the nominal one."""
    ours, theirs = half_widths(1.0)
    rows = zip(ARM.joints, ARM.dead_band, ours, theirs, ARM.dead_band / ours, strict=True)
    return TABLE_HEAD + "".join(
        f"| `{name}` | {1e3 * paper:.3f} | {1e3 * one:.4f} | {1e3 * other:.4f} | {need:.1f} N |\n"
        for name, paper, one, other, need in rows
    )


def tensions(axes: Any) -> None:
    """Tension along the wire that pulls: in full slip, and after turning back by half of the dead band."""
    soft, _ = pieces_of(wire(), np.ones(5))
    ends = 1e3 * np.concatenate([[0.0], np.cumsum(soft[JOINT])]) * wire().modulus * wire().section
    forward, chain = np.linspace(0.0, 0.01, 200), elements(JOINT, TENSION)
    turned = np.append(forward, 0.01 - half_widths(TENSION)[0][JOINT] * np.linspace(0, 1, 50))
    for u, shade, words in ((forward, 1.0, ("pair", "finite elements")), (turned, 0.45, (None, None))):
        tension = pair(u, 0.0 * u, TENSION)[1][1]
        axes.stairs(tension[JOINT, 0], ends, color=PAIR, alpha=shade, baseline=None, label=words[0])
        found = tensions_of(chain, nodes_of(chain, u / ARM.ratio[JOINT]))[-1]
        back = found[: len(found) // 2 - 1 : -1]
        axes.plot(centres(chain), back, ".", ms=3, mew=0, color=ELEMENTS, alpha=shade, label=words[1])
    cuts = 1e3 * np.array([0.0, wire().length1[JOINT], wire().length1[JOINT] + wire().length2[JOINT]])
    lumps = TENSION * np.array([1.0, np.exp(-wire().mu1[JOINT] * wire().a1[JOINT])])
    axes.stairs(lumps, cuts, color=PAPER, baseline=None, ls="--", label="paper: two lumps")
    axes.set(xlabel="along the wire, wheel to joint [mm]", ylabel="tension [N]")


def centres(chain: Pair) -> Array:
    """Middles of the elements [mm] of the first wire."""
    sizes: list[float] = []
    for straight, angle in zip(chain.straight, chain.wrap, strict=True):
        sizes += [straight, *[angle * 0.010 / chain.pieces] * chain.pieces]
    sizes.append(chain.length - sum(sizes))
    ends = np.cumsum(sizes)
    return np.asarray(1e3 * (ends - np.array(sizes) / 2))


def load_cycle(axes: Any, most: float) -> None:
    """The joint under a load that goes to and fro while the gearbox stands."""
    load = most * np.sin(np.linspace(0.0, 2.5 * np.pi, 500))
    ours = pair(0.0 * load, load, TENSION)[0][:, JOINT]
    theirs = joint_angle(elements(JOINT, TENSION), 0.0 * load, load)
    hooke = ARM.compliance[JOINT] * load
    axes.plot(load, 1e3 * hooke, "--", color=PAPER, lw=1, label="Hooke, one wire")
    axes.plot(load, 1e3 * ours, color=PAIR, lw=1.2, label="pair")
    axes.plot(load[::8], 1e3 * theirs[::8], ".", ms=3, color=ELEMENTS, label="finite elements")
    axes.set(xlabel="load [N m]", ylabel="deflection [mrad]")


def draw(path: Path) -> None:
    """Write the picture."""
    figure, panels = plt.subplots(1, 3, figsize=(10.0, 2.9), layout="constrained")
    tensions(panels[0])
    load_cycle(panels[1], 0.08)
    load_cycle(panels[2], 0.6)
    titles = (
        "full slip, and turned back by w",
        "load to and fro, gearbox at rest",
        "more load: one wire gets slack",
    )
    for axes, title in zip(panels, titles, strict=True):
        axes.set_title(title, fontsize=8)
        axes.legend(fontsize=7, frameon=False)
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=7)
        axes.locator_params(axis="x", nbins=5)
        axes.xaxis.label.set_size(8)
        axes.yaxis.label.set_size(8)
    figure.savefig(path, dpi=110)
    plt.close(figure)
