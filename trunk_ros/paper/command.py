"""`paper`: prints the comparison; with --output also a page and its figures."""

from __future__ import annotations

import base64
from importlib.resources import files
from pathlib import Path

from jinja2 import Template
from rich.console import Console
from rich.table import Table
from rich.text import Text

from trunk_ros.arm import Wire
from trunk_ros.errors import ModelError
from trunk_ros.model import load_model
from trunk_ros.paper.figures import figures_5_and_6, tip_over_workspace
from trunk_ros.paper.formulas import PRINTED_FIGURES, quantities
from trunk_ros.paper.workspace import STRETCH, WORST, Workspace, workspace
from trunk_ros.recording.arguments import Parser
from trunk_ros.recording.output import new_folder, prepare_output

PAGE = "paper.html"
FIGURES = ("paper-fig-5-6.png", "paper-workspace.png")
COLUMNS = ("median", "max", "straight", "all +23°")


def main(argv: list[str]) -> int:
    """`paper [--output DIR] [--overwrite]`. Raises ArgumentError where DIR exists or cannot be written."""
    asked = parser().parse_args(argv)
    if asked.output is not None:
        prepare_output(asked.output, asked.overwrite, (PAGE, *FIGURES))
    arm = load_model("trunk").arm
    if arm.wire is None:
        raise ModelError("config/trunk.yaml lacks wire.modulus and the rest of Table 1: bring them back")
    found = workspace(arm)
    show(Console(), arm.wire, found)
    if asked.output is not None:
        pictures = [figures_5_and_6(arm.wire), tip_over_workspace(arm, found)]
        with new_folder(asked.output, asked.overwrite, (PAGE, *FIGURES)) as folder:
            for name, picture in zip(FIGURES, pictures, strict=True):
                (folder / name).write_bytes(picture)
            (folder / PAGE).write_text(page(arm.wire, found, pictures), encoding="utf-8")
        print(f"{asked.output}: {', '.join((PAGE, *FIGURES))}")
    return 0


def parser() -> Parser:
    """Arguments of `paper`."""
    made = Parser(prog="paper", description="The paper's numbers, checked, and its further work.")
    made.add_argument("--output", type=Path, metavar="DIR", help=f"also write {PAGE} and its figures there")
    made.add_argument("--overwrite", action="store_true", help="replace DIR if it exists")
    return made


def show(console: Console, wire: Wire, found: Workspace) -> None:
    """Print everything as tables."""
    for quantity in quantities(wire):
        table = _table(f"{quantity.title} / {quantity.unit}", tuple(f"C{i}" for i in range(1, 6)))
        for way, cells in quantity.cells().items():
            table.add_row(way, *cells)
        console.print(table, Text(f"Done differently: {quantity.difference}\n", style="dim"))
    table = _table("All joints turned: error of the tip / mm", COLUMNS)
    for name, lengths in found.summary().items():
        table.add_row(name, *(f"{1e3 * length:.3f}" for length in lengths))
    console.print(table, Text(remark(found), style="dim"))


def remark(found: Workspace) -> str:
    """What the numbers of the workspace say."""
    summary = found.summary()
    friction, weight = summary[WORST][1], summary[STRETCH][1]
    return (
        f"{len(found.tip)} postures. The dead bands of all joints add up to {1e6 * friction:.0f} µm at the "
        f"tip, where the paper prints {PRINTED_FIGURES[0]} µm for joint 5 alone; the stretch under the "
        f"weight of the links is {weight / friction:.0f} times as large. To carry it a wire pulls with up to "
        f"{found.tension:.0f} N, where the paper takes 1 N, and the dead band of eq. (6) grows with the pull."
    )


def page(wire: Wire, found: Workspace, pictures: list[bytes]) -> str:
    """The same as one HTML file, figures included."""
    text = files("trunk_ros.paper").joinpath("page.html").read_text(encoding="utf-8")
    template = Template(text, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return str(
        template.render(
            quantities=quantities(wire),
            summary=found.summary(),
            columns=COLUMNS,
            remark=remark(found),
            pictures=[base64.b64encode(picture).decode() for picture in pictures],
        )
    )


def _table(title: str, columns: tuple[str, ...]) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold")
    table.add_column("")
    for column in columns:
        table.add_column(column, justify="right")
    return table
