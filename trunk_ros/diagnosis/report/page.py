"""The page, from what was found to HTML. What comes from a recording is escaped by the template."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template

from trunk_ros.diagnosis.report.cards import card
from trunk_ros.diagnosis.report.commands import cut, diagnose_again, motions, play, with_simulator
from trunk_ros.diagnosis.report.data import numbers, provenance, recordings
from trunk_ros.diagnosis.report.errors import (
    LEAST,
    WELL_ABOVE,
    figure_before_after,
    figure_over_time,
    ratios,
    shown_over_time,
)
from trunk_ros.diagnosis.report.next_steps import next_steps
from trunk_ros.diagnosis.report.script import as_data, policy, script, stylesheet
from trunk_ros.diagnosis.report.series import series
from trunk_ros.diagnosis.report.signals import Signal, judged, mixed_up, signals
from trunk_ros.diagnosis.report.style import image
from trunk_ros.diagnosis.report.units import spoken
from trunk_ros.diagnosis.report.verdict import gain, headline, verdict_word
from trunk_ros.diagnosis.report.where import maps, not_compared
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.verdict.answer import Answer
from trunk_ros.words import listed

TEMPLATES = Path(__file__).parent


@cache
def _template() -> Template:
    """The page to fill in, compiled once for all pages of a fleet."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"listed": listed, "spoken": spoken}
    return environment.get_template("page.html.j2")


def render(result: Answer) -> str:
    """The whole page as text."""
    return _template().render(**content(result))


def content(result: Answer) -> dict[str, Any]:
    """What the template fills in."""
    shown = shown_over_time(result)
    before_after, over_time, said = drawn(result, shown)
    return {
        "headline": headline(result),
        "gain": gain(result),
        "steps": next_steps(result),
        "contents": contents(result, bool(shown)),
        "policy": policy(bool(shown)),
        "stylesheet": stylesheet(),
        "script": script(),
        "series": as_data(series(result)) if shown else None,
        "verdict": result.verdict,
        "simulation": result.simulation,
        "verdict_word": verdict_word(result),
        "recordings": recordings(result),
        "judged": judged(result),
        "mixed_up": [statement for said in mixed_up(result).values() for statement in said],
        "maps": maps(result),
        "framed": any(cell.rest for m in maps(result) for _, row in m.rows for cell in row),
        "not_compared": not_compared(result),
        "coarse": any(r.of != "noise" for r in ratios(result)),
        "low": any(min(r.before, r.after) < LEAST for r in ratios(result)),
        "before_after": before_after,
        "over_time": over_time,
        "quiet": quiet(result, shown),
        "well_above": WELL_ABOVE,
        "cards": said,
        "events": result.events,
        "unexplained": result.unexplained,
        "unnamed": any(not f.named for f in result.findings),
        "experiments": result.experiments,
        "runs": runs(result),
        "undecided": any(not e.get("trajectory") for e in result.experiments),
        "again": diagnose_again(result),
        "with_simulator": with_simulator(result),
        "cut": cut(result),
        "not_cut": cut(result, fitting=False),
        "rivals_remain": any(f.equivalents for f in result.findings),
        "numbers": numbers(result),
        "provenance": provenance(result),
    }


def drawn(result: Answer, shown: list[Signal]) -> tuple[str | None, str | None, list[dict[str, Any]]]:
    """The figures of all signals, and what the page says of each finding with its own: most of its time."""

    def errors() -> str | None:
        return image(figure_before_after(result)) if ratios(result) else None

    def over_time() -> str | None:
        return image(figure_over_time(shown)) if shown else None

    of_findings = [partial(card, result, finding) for finding in result.findings]
    parts: list[Callable[[], Any]] = [errors, over_time, *of_findings]
    one, other, *said = each(Work(), lambda draw: draw(), parts)
    return one, other, [a_card | {"finding": f} for a_card, f in zip(said, result.findings, strict=True)]


def contents(result: Answer, over_time: bool) -> list[tuple[str, str]]:
    """Anchors and titles of the parts that the page has."""
    seen = judged(result)
    return [
        *([("where", "Where")] if seen else []),
        *([("time", "Over time")] if over_time else []),
        *([("found", "What was found")] if result.findings else []),
        *([("rest", "Still unexplained"), ("settle", "Decisive motion")] if seen else []),
        ("data", "Quality of the data"),
        ("again", "To reproduce"),
    ]


def runs(result: Answer) -> list[str]:
    """The command that plays each experiment's motion."""
    return [play(result, file) for file in motions(result)]


def quiet(result: Answer, shown: list[Signal]) -> list[str]:
    """Signals that the figure over time leaves out."""
    seen = {(s.stage, s.name) for s in shown}
    return [f"{s.stage} · {s.name}" for s in signals(result) if (s.stage, s.name) not in seen]
