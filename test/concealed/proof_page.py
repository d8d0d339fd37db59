"""Puts the last table and its figures into docs/."""

from __future__ import annotations

import shutil
from pathlib import Path

BEGIN, END = (
    "<!-- proof: from here on written by python -m test.concealed.proof --page -->",
    "<!-- proof: to here -->",
)


def with_table(page: str, table: str) -> str:
    """The page with the table between its marks. Raises ValueError where they are missing."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"the page has no place for the table: {BEGIN} ... {END}")
    return f"{before}{BEGIN}\n\n{table.strip()}\n\n{END}{after}"


def update_page(proof: Path, docs: Path) -> None:
    """PROOF.md gets proof/table.md, docs/figures the pictures. Raises ValueError as `with_table`."""
    page = docs / "PROOF.md"
    page.write_text(with_table(page.read_text(), (proof / "table.md").read_text()))
    for picture in proof.glob("proof-*.png"):
        shutil.copy(picture, docs / "figures" / picture.name)
