"""``effects``: the library of effects, and all about one of them."""

from __future__ import annotations

import inspect
import json
import textwrap
from typing import TYPE_CHECKING, Any

from trunk_ros.console.arguments import Parser, did_you_mean
from trunk_ros.console.console import columns, say

if TYPE_CHECKING:
    from trunk_ros.effects import Effect
    from trunk_ros.parameter import Parameter

WIDTH = 100
NEEDS = {
    "load": "the load, from masses in the model or recorded effort",
    "weight": "masses in the model",
    "effort": "recorded effort",
    "dead_band": "a nominal backlash in the model",
    "several": "more than one joint",
}


def parser() -> Parser:
    """Arguments of ``effects``."""
    about = "Show the effect library, or one effect in full."
    made = Parser("effects", about, ["", "backlash", "--json"])
    made.add_argument("name", nargs="?", metavar="NAME", help="an effect's ID; all of them by default")
    made.add_argument("--json", action="store_true", help="the same for programs")
    return made


def main(argv: list[str]) -> int:
    """The command."""
    asked = parser().parse_args(argv)
    from trunk_ros.effects import registry
    from trunk_ros.errors import ArgumentError

    named = {name: kind for name, kind in registry().items() if kind.named}
    if asked.name and asked.name not in named:
        near = did_you_mean(asked.name, named)
        raise ArgumentError(f"no effect {asked.name!r}{near or ': choose from ' + ', '.join(named)}")
    kinds = [named[asked.name]] if asked.name else list(named.values())
    if asked.json:
        told = [facts(kind) for kind in kinds]
        say(json.dumps(told[0] if asked.name else told, indent=1))
    else:
        say(*(one(kinds[0]) if asked.name else listed(kinds)))
    return 0


def listed(kinds: list[type[Effect]]) -> list[str]:
    """A line for each effect, by stage."""
    rows = [(kind.id, kind.stage, kind.regime, kind.title()) for kind in kinds]
    return [
        *columns([("effect", "stage", "regime", "what it is"), *rows]),
        "",
        "`trunk_ros effects NAME` has its equation, parameters and source.",
    ]


def facts(kind: type[Effect]) -> dict[str, Any]:
    """All about an effect, as JSON has it."""
    return {
        "effect": kind.id,
        "what": kind.title(),
        "equation": inspect.cleandoc(kind.__doc__ or ""),
        "stage": kind.stage,
        "regime": kind.regime,
        "signature": kind.signature,
        "parameters": [_parameter(p) for p in kind.parameters],
        "moments": [_parameter(p) for p in kind.moments()],
        "words": list(kind.texts),
        "forms": [form for form in kind.forms if form],
        "needs": [NEEDS[need] for need in kind.needs],
        "includes": list(kind.replaces),
        "confused_with": [{"effect": name, "told_apart_by": how} for name, how in kind.confused_with],
        "compensable": kind.compensable,
        "source": kind.source,
    }


def _parameter(p: Parameter) -> dict[str, Any]:
    told = {"name": p.name, "unit": p.unit, "bounds": list(p.bounds), "meaning": p.meaning}
    return {**told, "shared": p.shared}


def one(kind: type[Effect]) -> list[str]:
    """The same in lines."""
    told = facts(kind)
    never = "" if kind.compensable else ", never compensated"
    lines = [
        f"{kind.id}: {told['what']}",
        f"  stage {kind.stage}, regime {kind.regime}{never}",
        *(f"  {line}".rstrip() for line in told["equation"].splitlines()),
        *_wrapped("what one sees", told["signature"]),
        "  parameters:",
        *(f"    {line}" for line in columns([_row(p) for p in told["parameters"]])),
    ]
    if told["moments"]:
        rows = columns([_row(p) for p in told["moments"]])
        lines += ["  in mid-run:", *(f"    {line}" for line in rows)]
    for name in ("words", "forms", "needs", "includes"):
        lines += _wrapped(name, ", ".join(told[name])) if told[name] else []
    for other in told["confused_with"]:
        lines += _wrapped(f"separated from {other['effect']} by", other["told_apart_by"])
    return lines + _wrapped("source", told["source"])


def _row(p: dict[str, Any]) -> tuple[str, ...]:
    low, high = p["bounds"]
    whose = "all joints" if p["shared"] else "per joint"
    return p["name"], p["unit"], f"{low:g} … {high:g}", whose, p["meaning"]


def _wrapped(name: str, text: str) -> list[str]:
    return textwrap.wrap(f"{name}: {text}", WIDTH, initial_indent="  ", subsequent_indent="    ")
