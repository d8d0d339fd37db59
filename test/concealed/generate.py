"""``python -m test.concealed.generate --seeds 0:20 --output DIR``: concealed cases as bags."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed.bag import write_bag
from test.concealed.case import Case, draw_case
from test.concealed.catalogue import CATALOGUE
from test.concealed.masses_case import KINDS as MASSES
from test.concealed.masses_case import draw_masses_case
from test.concealed.mujoco_case import draw_mujoco_case
from test.concealed.wire_case import draw_wire_case

MIXTURE: dict[str, dict[str, Any]] = {
    "singles": {"count": 1}, "pairs": {"count": 2}, "triples": {"count": 3}, "clean": {"count": 0},
    "unknown": {"unknown": True}, "hard": {"count": None, "hard": True},
}  # fmt: skip
OTHER_PLANTS: dict[str, Callable[[int], Case]] = {
    "wire": draw_wire_case,
    "mujoco": draw_mujoco_case,
    **{kind: partial(draw_masses_case, kind=kind) for kind in MASSES},
}
LAYOUT = """case_NNNN/train: bag to diagnose; case_NNNN/test: another motion of the same arm, to judge on.
truth.json: what is hidden (effect, form, joints, parameters, strength = rms of the effect over the sensor
noise), kinds of motion and of recording; `same` lists the parameters that mean the contract's.
clean.npz: train and test (n, 5) rad, the noise-free joint angle at the stamps of joint_states.
"""


def kind_of(seed: int) -> str:
    """The mixture: of twenty seeds seven singles, four pairs, three triples, three clean, three unknown."""
    once = ("singles", "pairs", "clean", "singles", "triples", "unknown", "singles", "pairs", "singles",
            "triples", "clean", "singles", "unknown", "pairs", "singles", "triples", "clean", "pairs",
            "singles", "unknown")  # fmt: skip
    return once[seed % 20]


def write_case(case: Case, folder: Path, kind: str = "") -> None:
    """Writes both bags, truth.json and clean.npz; truth.json comes last and says that the case is whole."""
    folder.mkdir(parents=True)
    write_bag(case.train, folder / "train", 2 * case.seed)
    write_bag(case.test, folder / "test", 2 * case.seed + 1)
    np.savez(folder / "clean.npz", train=case.train.theta_clean, test=case.test.theta_clean)
    (folder / "truth.json").write_text(json.dumps({"kind": kind, **case.told()}, indent=1))


def generate(seeds: range, output: Path, kind: str | None = None, **knobs: Any) -> None:
    """Writes the cases of the seeds that are not there yet."""
    output.mkdir(parents=True, exist_ok=True)
    (output / "README.txt").write_text(LAYOUT)
    for seed in seeds:
        folder = output / f"case_{seed:04d}"
        if (folder / "truth.json").exists():
            continue
        which = kind or kind_of(seed)
        write_case(_drawn(seed, which, knobs), folder, which)
        print(f"\r{folder.name} {which}", end="", file=sys.stderr)
    print(file=sys.stderr)


def _drawn(seed: int, which: str, knobs: dict[str, Any]) -> Case:
    if which in OTHER_PLANTS:
        return OTHER_PLANTS[which](seed)
    return draw_case(seed, **{**MIXTURE[which], **knobs})


def seeds_of(text: str) -> range:
    """``0:20`` or ``7``."""
    first, _, last = text.partition(":")
    return range(int(first), int(last)) if last else range(int(first), int(first) + 1)


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.concealed.generate", description=__doc__)
    parser.add_argument("--seeds", type=seeds_of, default=range(20), help="FIRST:LAST, LAST not included")
    parser.add_argument("--output", type=Path, required=True)
    group = parser.add_mutually_exclusive_group()
    for name in ("singles", "pairs", "triples", "clean", "unknown", *OTHER_PLANTS):
        group.add_argument(f"--{name}", dest="kind", action="store_const", const=name)
    parser.add_argument("--hard", action="store_true", help="coloured noise, 25 Hz, losses, compensator …")
    parser.add_argument("--effects", help="these only, comma separated")
    parser.add_argument("--level", help="strength LOW:HIGH, default 1:30")
    args = parser.parse_args(argv)
    knobs: dict[str, Any] = {"hard": True} if args.hard else {}
    if args.effects:
        knobs["effects"] = args.effects.split(",")
        if strange := set(knobs["effects"]) - set(CATALOGUE):
            parser.error(f"no effect {', '.join(sorted(strange))}; there are {', '.join(CATALOGUE)}")
    if args.level:
        low, high = args.level.split(":")
        knobs["level"] = (float(low), float(high))
    kind = args.kind or ("hard" if args.hard else None)
    generate(args.seeds, args.output, kind, **knobs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
