"""docs/effects.md says what the code says."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from trunk_ros.effects import registry

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "effects.md").read_text(encoding="utf-8")


def module(name: str) -> ModuleType:
    """A module of docs/."""
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    assert spec
    assert spec.loader
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def test_the_page_is_up_to_date() -> None:
    """If not: make docs."""
    assert module("make_effects").page() == TEXT


def test_the_dead_bands_of_the_wires_page_are_those_of_the_models() -> None:
    assert module("draw_wire").table() in (DOCS / "wire.md").read_text(encoding="utf-8")


def test_the_wires_page_shows_its_picture() -> None:
    assert (DOCS / "figures" / "wire.png").stat().st_size < 100_000


@pytest.mark.parametrize("name", registry())
def test_every_effect_has_its_picture(name: str) -> None:
    picture = DOCS / "figures" / "effects" / f"{name}.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size < 60_000


def test_every_link_leads_to_an_effect_or_a_page() -> None:
    links = re.findall(r"\]\(([^)]+)\)", TEXT)
    titles = set(re.findall(r"^### (\w+)$", TEXT, re.MULTILINE))
    assert titles == set(registry())
    for link in links:
        assert link[1:] in titles if link.startswith("#") else (DOCS / link).exists(), link


def test_named_rivals_come_with_the_motion_that_separates_them() -> None:
    """From both sides: what one effect says of another stands with the other as well."""
    for name, kind in registry().items():
        for other, motion in kind.confused_with:
            for one, rival in ((name, other), (other, name)):
                own = TEXT.partition(f"### {one}\n")[2].partition("\n### ")[0]
                assert f"[`{rival}`]" in own, (one, rival)
            assert motion in TEXT


@pytest.mark.parametrize("name", registry())
def test_every_effect_says_what_it_is_easily_confused_with(name: str) -> None:
    own = TEXT.partition(f"### {name}\n")[2].partition("\n### ")[0]
    assert "- Easily confused with\n  - [`" in own
