"""XML with a comment before each element that was written."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from scipy.spatial.transform import Rotation

from trunk_ros.errors import TrunkError
from trunk_ros.export.sheet import Line

BY = "trunk_ros: "


def parse(text: str, what: str) -> Element:
    """The root of an XML text, comments kept. Raises TrunkError where it is none."""
    try:
        builder = ElementTree.TreeBuilder(insert_comments=True)
        return ElementTree.fromstring(text.strip(), ElementTree.XMLParser(target=builder))
    except ElementTree.ParseError as error:
        raise TrunkError(f"{what} is no XML: {error}") from None


def to_text(root: Element) -> str:
    """The whole file."""
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def commented(root: Element, lines: Sequence[Line]) -> None:
    """Put each line as a comment before the element of its tag and name; others at the top."""
    above: dict[Any, Element] = {child: parent for parent in root.iter() for child in parent}
    for line in lines:
        found = [e for e in root.iter(line.tag) if e.get("name") == line.name and e in above]
        comment = ElementTree.Comment(f" {BY}{line.text.replace('--', '- -')} ")
        if found:
            parent = above[found[0]]
            parent.insert(list(parent).index(found[0]), comment)
            above[comment] = parent
        else:
            root.insert(0, comment)


def numbers(text: str | None, count: int) -> list[float]:
    """Numbers of an attribute or of a text; zeros where there is none. Raises TrunkError for others."""
    try:
        values = [float(word) for word in (text or "").split()]
    except ValueError:
        raise TrunkError(f"{text!r} in the file are no numbers") from None
    return values if len(values) == count else [0.0] * count


def written(values: Iterable[float]) -> str:
    """Numbers as text, in full."""
    return " ".join(f"{value:.12g}" for value in values)


def turned(rpy: Sequence[float], angle: float) -> list[float]:
    """Roll, pitch and yaw [rad] of a frame that is turned by ``angle`` about X first in its parent's axes."""
    turn = Rotation.from_rotvec([angle, 0.0, 0.0]) * Rotation.from_euler("xyz", rpy)
    return [float(value) for value in turn.as_euler("xyz")]
