"""Prints the comparison, and writes it as a page with figures."""

from __future__ import annotations

import base64
from importlib.resources import files
from pathlib import Path

from jinja2 import Template
from rich.console import Console
from rich.table import Table
from rich.text import Text

from trunk_ros.arm import Wire
from trunk_ros.console.console import Level, asked, say
from trunk_ros.errors import ModelError
from trunk_ros.model import load_model
from trunk_ros.paper.figures import figures_5_and_6, tip_over_workspace
from trunk_ros.paper.formulas import PRINTED_FIGURES, quantities
from trunk_ros.paper.workspace import STRETCH, WORST, Workspace, workspace
from trunk_ros.recording.output import new_folder, prepare_output

PAGE = "paper.html"
FIGURES = ("paper-fig-5-6.png", "paper-workspace.png")
COLUMNS = ("median", "max", "straight", "all +23°")


def run(output: Path | None, overwrite: bool = False) -> None:
    """Print the comparison; also write it as a page. Raises ArgumentError where that cannot be written."""
    if output is not None:
        prepare_output(output, overwrite, (PAGE, *FIGURES))
    arm = load_model("trunk").arm
    if arm.wire is None:
        raise ModelError("config/trunk.yaml lacks wire.modulus and the rest of Table 1: bring them back")
    found = workspace(arm)
    if asked() > Level.QUIET:
        show(Console(), arm.wire, found)
    if output is not None:
        pictures = [figures_5_and_6(arm.wire), tip_over_workspace(arm, found)]
        with new_folder(output, overwrite, (PAGE, *FIGURES)) as folder:
            for name, picture in zip(FIGURES, pictures, strict=True):
                (folder / name).write_bytes(picture)
            (folder / PAGE).write_text(page(arm.wire, found, pictures), encoding="utf-8")
        say(f"{output}: {', '.join((PAGE, *FIGURES))}")


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
