"""Write effects.md and its pictures from the registry: python docs/make_effects.py, or `make docs`."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent))

from trunk_ros.effects import Effect, confused, registry  # noqa: E402
from trunk_ros.effects.bank import Bank  # noqa: E402
from trunk_ros.parameter import Parameter  # noqa: E402

STAGES = {
    "servo": "Servo: setpoint to gearbox angle",
    "wire": "Wire: gearbox angle to joint angle",
    "arm": "Arm: joint angles to tip",
}
HEAD = """# Effect library

What a simulation may have left out, in physical order. Made by `make docs` from `trunk_ros/effects/`: what
stands here is what the code says. [Physics](physics.md) explains the mechanisms,
[Adding an effect](adding-an-effect.md) how to write one.

Pictures show the nominal arm with the effect less the nominal arm without it, joint 2 of five that all move:
over time, with the joint angle in grey, and over what the effect depends on.
Blue: joint moving up; red: down; grey: at rest.

"""


def page() -> str:
    """The text of effects.md."""
    kinds = list(registry().values())
    return (
        HEAD
        + "\n".join([*overview(kinds), *(line for stage in STAGES for line in chapter(stage, kinds))])
        + "\n"
    )


def overview(kinds: list[type[Effect]]) -> Iterator[str]:
    """All effects in one table."""
    yield "| effect | stage | regime | what one sees |"
    yield "|---|---|---|---|"
    for kind in kinds:
        yield f"| [`{kind.id}`](#{kind.id}) | {kind.stage} | `{kind.regime}` | {kind.signature} |"
    yield ""


def chapter(stage: str, kinds: list[type[Effect]]) -> Iterator[str]:
    """The effects of a stage."""
    yield f"## {STAGES[stage]}"
    yield ""
    for kind in kinds:
        if kind.stage == stage:
            yield from section(kind, kinds)


def section(kind: type[Effect], kinds: list[type[Effect]]) -> Iterator[str]:
    """All about one effect."""
    yield f"### {kind.id}"
    yield ""
    yield f"![{kind.id}](figures/effects/{kind.id}.png)"
    yield ""
    yield kind.signature
    yield ""
    yield "```"
    yield inspect.cleandoc(kind.__doc__ or "")
    yield "```"
    yield ""
    yield from parameters(kind)
    yield ""
    yield f"- Source: {kind.source}"
    yield from facts(kind)
    yield from rivals(kind)
    yield ""


def parameters(kind: type[Effect]) -> Iterator[str]:
    """The table of an effect's parameters; numbered ones that are all alike share a row."""
    yield "| parameter | unit | bounds | absent at | |"
    yield "|---|---|---|---|---|"
    many = ("moment_", "value_", "weight_", "low_", "high_")
    shown = [p for p in kind.parameters if not p.name.startswith(many)]
    for p in shown:
        low, high = p.bounds
        yield f"| `{p.name}` | {p.unit} | {low:g} … {high:g} | {p.null:g} | {meaning(p)} |"
    for begin in many:
        values = [p for p in kind.parameters if p.name.startswith(begin)]
        if values:
            p, low, high = values[0], *values[0].bounds
            ends = f"`{p.name}` … `{values[-1].name}`"
            yield f"| {ends} | {p.unit} | {low:g} … {high:g} | {p.null:g} | {meaning(p)} |"
    for text in kind.texts:
        yield f"| `{text}` | word | | | one per joint |"


def meaning(p: Parameter) -> str:
    """What a parameter means, and how it is fitted."""
    notes = [
        p.meaning,
        *(["shared by all joints"] if p.shared else []),
        *(["fitted in log"] if p.scale == "log" else []),
    ]
    return ", ".join(notes)


def facts(kind: type[Effect]) -> Iterator[str]:
    """What else is to be known."""
    if len(kind.forms) > 1:
        yield f"- Forms: {', '.join(f'`{form}`' for form in kind.forms)}. A fit chooses."
    if kind.everywhere:
        yield "- Acts on all joints alike and is judged for the arm as a whole."
    if issubclass(kind, Bank):
        yield "- The diagnosis tries it last, on joints where the other effects leave much of the residual."
    elif not kind.tried:
        yield "- The diagnosis does not try it: it is switched on in a model by hand."
    if kind.moments():
        once = ", ".join(f"`{m.name}`" for m in kind.moments() if not m.name[-1].isdigit())
        yield f"- In mid-run: {once} (s); again, or with another size: `from_2`, `until_2`, `times_2`."
    if kind.replaces:
        yield f"- Includes {', '.join(f'`{name}`' for name in kind.replaces)}."
    if kind.stage == "wire":
        yield f"- Place {kind.place}. " + (
            "The compensator corrects it." if kind.compensable else "Never compensated."
        )


def rivals(kind: type[Effect]) -> Iterator[str]:
    """What it is easily confused with, from either side, and the motion that separates the two."""
    pairs = confused(kind.id)
    if pairs:
        yield "- Easily confused with"
        for name, motion in pairs.items():
            yield f"  - [`{name}`](#{name}): {motion}."


def main() -> int:
    """Write the page and the pictures."""
    (DOCS / "effects.md").write_text(page(), encoding="utf-8")
    import draw_effects
    import draw_wire

    for kind in registry().values():
        draw_effects.draw(kind, DOCS / "figures" / "effects" / f"{kind.id}.png")
    draw_wire.draw(DOCS / "figures" / "wire.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
