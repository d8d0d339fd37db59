"""URDF of the same arm three times: as measured, and as ghosts."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.etree.ElementTree import SubElement

from trunk_ros.errors import ModelError

# Red, green, blue and opacity; the measured arm keeps its own colours.
GHOSTS: dict[str, str | None] = {
    "measured": None, "nominal": "0.55 0.58 0.62 0.35", "fitted": "0.04 0.55 0.75 0.35"
}  # fmt: skip


def ghost(urdf: str, colour: str | None) -> str:
    """A URDF with every visual in one colour, and without what is only there to collide.

    Raises ModelError for what is no URDF.
    """
    try:
        robot = ElementTree.fromstring(urdf)
    except ElementTree.ParseError as error:
        raise ModelError(f"the arm's description is not URDF: {error}") from None
    for link in robot.iter("link"):
        for collision in link.findall("collision"):
            link.remove(collision)
        for visual in link.findall("visual") if colour else ():
            for material in visual.findall("material"):
                visual.remove(material)
            SubElement(SubElement(visual, "material", name="ghost"), "color", rgba=str(colour))
    return ElementTree.tostring(robot, encoding="unicode")
