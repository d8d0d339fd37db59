"""The lines of a table as rows of fields, below its comments and its header."""

import csv
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from trunk_ros.errors import RecordingError
from trunk_ros.recording.arrays import ELSEWHERE
from trunk_ros.recording.importing.field import as_number

BLANKS = " "
"""The delimiter of a table whose fields stand apart by any number of blanks and tabs."""

_MARKS = ",;\t|"
_COMMENT = re.compile(r"\s*[#%]+\s+")  # without the blank the mark is part of the name, as in ROS's %time
_HEAD = 512  # bytes, in which files that are no text have a zero


@dataclass(frozen=True)
class Rows:
    """names: the header, which is in `line`, from 1; the first of the `rows` below it is in `first_line`."""

    names: list[str]
    line: int
    rows: Iterator[list[str]]
    first_line: int
    delimiter: str


def refuse_binary(path: Path) -> None:
    """RecordingError for a file that holds no text; OSError where it cannot be read."""
    with path.open("rb") as stream:
        if b"\0" in stream.read(_HEAD):
            raise RecordingError(f"{path}: is no table: it holds no text in UTF-8; {ELSEWHERE}")


def opened(lines: Iterable[str], delimiter: str = "") -> Rows:
    """The rows of a table, whose ``delimiter`` is found where none is given.

    Lines that begin with # or % above the header are comments; the last of them is the header where it has
    as many fields as a line with numbers below it. csv.Error where it is no table.
    """
    lines, comment, line, number, at = iter(lines), "", "", 0, 0
    for number, line in enumerate(lines, start=1):
        if line.lstrip().startswith(("#", "%")):
            comment, at, line = line, number, ""
        elif line.strip() or not comment:
            break
    head = _COMMENT.sub("", comment, count=1) if comment else ""
    mark = delimiter or _delimiter_of(head, line)
    names, first = _fields_of(head, mark), _fields_of(line, mark)
    told = len(names) == len(first) and any(as_number(field) is not None for field in first)
    if comment and (told or not line):
        return Rows(names, at, split(chain([line], lines), mark), number, mark)
    below = next(lines, "")
    mark = delimiter or _delimiter_of(line, below)
    rows = split(chain([line, below], lines), mark)
    return Rows([name.strip() for name in next(rows, [])], number, rows, number + 1, mark)


def split(lines: Iterable[str], delimiter: str) -> Iterator[list[str]]:
    """Each line's fields, [] of an empty one."""
    if delimiter != BLANKS:
        return csv.reader(lines, delimiter=delimiter)
    plain = (line.replace("\t", " ").rstrip() + "\n" for line in lines)
    return csv.reader(plain, delimiter=BLANKS, skipinitialspace=True)


def _fields_of(line: str, delimiter: str) -> list[str]:
    return [field.strip() for field in next(split([line], delimiter), [])]


def _delimiter_of(head: str, below: str) -> str:
    """Of a header and the row below it: by which both have as many fields, and all of the header's names."""
    names = {mark: _fields_of(head, mark) for mark in _MARKS}
    agree = [m for m in _MARKS if all(names[m]) and len(names[m]) == len(_fields_of(below or head, m)) > 1]
    if agree:
        return max(agree, key=lambda mark: len(names[mark]))
    if any(mark in head for mark in ",;|"):
        return max(",;|", key=head.count)
    return BLANKS if len(_fields_of(head, BLANKS)) > 1 else ","
