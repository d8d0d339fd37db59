"""The paper's own table as a case: what is printed, what the tool's page makes of it, and its correction.

The printed numbers are written down here a second time; the page is the command ``trunk_ros paper``.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass

import numpy as np

from test.concealed.codes import ROOT

PRINTED = {  # C. Ciofu and G. Stan, table 2, C1 ... C5
    "k_i·100 / %": (96.07, 96.30, 96.30, 96.30, 96.30),
    "Δl_i / µm": (5.1184, 6.5111, 7.8997, 9.2882, 10.6768),
    "Δθ_i / arcmin": (0.335, 0.4262, 0.5170, 0.6079, 0.6988),
}
WIDE = "200"  # columns of the terminal, so that no row is broken


@dataclass(frozen=True)
class Row:
    """A quantity of table 2: largest deviation from the print, as a share, by the formulas and corrected."""

    quantity: str
    printed: tuple[float, ...]
    formulas_off: float
    corrected_off: float
    said: str


def _off(said: list[float], printed: tuple[float, ...]) -> float:
    return float(np.abs(np.array(said) / np.array(printed) - 1).max())


def read_page(text: str) -> list[Row]:
    """Rows of table 2 of the page. Raises ValueError where it lacks one or prints other numbers."""
    blocks = {block.split("\n", 1)[0].strip(): block for block in text.split("\n\n")}
    out = []
    for quantity, printed in PRINTED.items():
        block = blocks.get(f"Table 2, {quantity}")
        if block is None:
            raise ValueError(f"the page has no table of {quantity}")
        rows = {}
        for line in block.splitlines():
            cells = [cell.strip() for cell in line.strip("│ ").split("│")]
            if line.startswith("│"):
                rows[cells[0]] = [float(cell) for cell in cells[1:]]
        if not np.allclose(rows["as printed"], printed, rtol=1e-9):
            raise ValueError(f"{quantity}: the page says that {rows['as printed']} is printed")
        words = " ".join(block[block.rindex("┘") + 1 :].split()).removeprefix("Done differently: ")
        formulas, corrected = (
            _off(rows[name], printed) for name in ("formulas, Table 1", "done differently")
        )
        out.append(Row(quantity, printed, formulas, corrected, words))
    return out


def paper_rows() -> list[Row]:
    """Runs the command and reads its page. Raises RuntimeError where it fails, ValueError as `read_page`."""
    done = subprocess.run(
        [sys.executable, "-m", "trunk_ros", "paper"],
        cwd=ROOT, env={**os.environ, "COLUMNS": WIDE}, capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(f"paper ended with {done.returncode}: {done.stderr.strip()[-300:]}")
    return read_page(done.stdout)
