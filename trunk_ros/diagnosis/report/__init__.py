"""The report: one HTML file that says what was found, shows it, and works offline."""

from pathlib import Path

from trunk_ros.diagnosis.report.errors import figure_before_after, figure_over_time
from trunk_ros.diagnosis.report.page import render
from trunk_ros.diagnosis.report.signature import figure_signature
from trunk_ros.diagnosis.verdict.answer import Answer

__all__ = ["figure_before_after", "figure_over_time", "figure_signature", "render", "write"]


def write(result: Answer, path: Path) -> None:
    """Write the page of a diagnosis to a file."""
    path.write_text(render(result), encoding="utf-8", errors="replace")
