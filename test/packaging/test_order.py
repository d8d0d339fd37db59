"""What knows of what: no file imports itself by way of others, and no list elsewhere names an effect."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from test.packaging.imports import ROOT, imported, modules, reached, within
from trunk_ros.effects import registry

IDS = set(registry())
WITHOUT_NAMES = [m for room in ("data", "diagnosis", "nodes") for m in modules(f"trunk_ros/{room}")]


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


def circles(above: dict[str, set[str]]) -> list[str]:
    """Those that depend on themselves, what depends on nothing and what nothing depends on taken away."""
    left = dict(above)
    while True:
        used = set().union(*left.values())
        kept = {name: on & set(left) for name, on in left.items() if on & set(left) and name in used}
        if len(kept) == len(left):
            return sorted(kept)
        left = kept


def test_circles_are_seen():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"c"}}) == ["b", "c"]
    assert circles({"a": {"b"}, "b": {"c"}, "c": set()}) == []


def test_no_file_imports_itself_by_way_of_others():
    files = {name_of(path): path for path in modules("trunk_ros") if path.name != "__init__.py"}
    assert circles({name: imported(path) & set(files) for name, path in files.items()}) == []


def test_what_is_found_before_physics_knows_nothing_of_the_diagnosis():
    assert within(reached(modules("trunk_ros/data")), "trunk_ros.diagnosis") == []


def ids_in(text: str) -> Iterator[tuple[int, str]]:
    """Line and ID of each text in code that is the ID of an effect."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in IDS:
            yield node.lineno, node.value


def test_ids_are_seen():
    assert list(ids_in('"""backlash"""\nx = model.effects.get("zero_offset")\n')) == [
        (1, "backlash"),
        (2, "zero_offset"),
    ]


@pytest.mark.parametrize("path", WITHOUT_NAMES, ids=lambda path: str(path.relative_to(ROOT)))
def test_an_effect_is_named_in_its_own_file_only(path):
    assert list(ids_in(path.read_text())) == []
