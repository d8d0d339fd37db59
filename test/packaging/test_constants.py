"""The numbers that decide in the diagnosis: how many there are, and that each name has one meaning."""

import re
from collections import Counter
from pathlib import Path

from test.bench.policy import Constant, constants
from test.packaging.imports import ROOT

ROW = re.compile(r"^\| ((?:`[^`]+`(?:, )?)+|the rest) \| (\d+) \|", re.MULTILINE)
PAGE = (
    (ROOT / "docs" / "method.md")
    .read_text(encoding="utf-8")
    .partition("## Constants")[2]
    .partition("\n## ")[0]
)


def rooms() -> dict[tuple[str, ...], int]:
    """By files and folders of a row of the page: how many constants it says they have."""
    return {tuple(re.findall(r"`([^`]+)`", names)): int(count) for names, count in ROW.findall(PAGE)}


def room_of(constant: Constant) -> tuple[str, ...]:
    """The row that a constant belongs to: that of its file, else of its folder, else of the rest."""
    place = Path(constant.path).relative_to("trunk_ros")
    place = place.relative_to("diagnosis") if place.parts[0] == "diagnosis" else place
    for name in (place.as_posix(), f"{place.parts[0]}/"):
        for room in rooms():
            if name in room:
                return room
    return ()


def test_the_page_says_how_many_constants_there_are_and_where():
    assert Counter(map(room_of, constants())) == Counter(rooms())


def test_the_sum_on_the_page_is_that_of_its_rows():
    assert f"**{sum(rooms().values())} numbers**" in PAGE


def test_a_name_in_capitals_means_one_thing():
    names = Counter(constant.name for constant in constants())
    assert {name for name, count in names.items() if count > 1} == set()
