"""Effects in URDF: what it says of limits, frames and masses. It has no actuators and no sensors."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from trunk_ros.errors import TrunkError
from trunk_ros.export.markup import commented, numbers, parse, to_text, turned, written
from trunk_ros.export.sheet import Writer
from trunk_ros.model import Model, Values


class UrdfWriter(Writer):
    """Writes into a URDF file."""

    def __init__(self, model: Model, path: Path):
        """Raises TrunkError for a file that is no URDF, or has none of the joints."""
        super().__init__(model)
        self.root = parse(path.read_text(encoding="utf-8"), str(path))
        found = {str(joint.get("name")): joint for joint in self.root.findall("joint")}
        if self.root.tag != "robot" or not set(self.joints) & set(found):
            raise TrunkError(f"{path}: no URDF with any of the joints {', '.join(self.joints)}")
        self.found = found
        self.remarks += [f"{joint}: not in the file" for joint in self.joints if joint not in found]

    def text(self) -> str:
        commented(self.root, self.lines)
        return to_text(self.root)

    def hard_stop(self, values: Values) -> Values:
        """The joint's limit."""
        key = "upper" if values.get("form", "upper") == "upper" else "lower"

        def write(joint: str, end: float) -> bool:
            limit = self._limit(joint)
            if limit is None:
                return False
            known = limit.get(key)
            nearest = (min if key == "upper" else max)(end, float(known)) if known else end
            limit.set(key, written([nearest]))
            self.note("joint", joint, f"hard_stop at {end:.4g} rad: limit")
            return True

        return self.each(values, key, write)

    def velocity_saturation(self, values: Values) -> Values:
        """The joint's top speed."""
        if not set(self.joints) <= set(self.found):
            return values
        for k, joint in enumerate(self.joints):
            limit = self._limit(joint)
            assert limit is not None
            limit.set("velocity", written([float(values["v_max"]) * abs(float(self.model.arm.ratio[k]))]))
            self.note("joint", joint, f"velocity_saturation {values['v_max']:.4g} rad/s at the motor: limit")
        return {}

    def ratio_error(self, values: Values) -> Values:
        """The reduction of a transmission, where the file has one."""

        def write(joint: str, relative: float) -> bool:
            for each in self.root.findall("transmission"):
                reduction = each.find("*/mechanicalReduction")
                if reduction is not None and each.find(f"joint[@name='{joint}']") is not None:
                    old = numbers(reduction.text, 1)[0] or 1.0
                    reduction.text = written([old / (1.0 + relative)])
                    self.note(
                        "transmission", str(each.get("name")), f"ratio_error {relative:+.4g}: reduction"
                    )
                    return True
            return False

        return self.each(values, "relative", write)

    def link_length_error(self, values: Values) -> Values:
        """Where the next joint sits on the link."""

        def write(joint: str, longer: float) -> bool:
            following = self._following(joint)
            origin = following.find("origin") if following is not None else None
            if following is None or origin is None:
                return False
            place = np.array(numbers(origin.get("xyz"), 3))
            length = float(np.linalg.norm(place))
            if length == 0.0:
                return False
            origin.set("xyz", written(place * (1.0 + longer / length)))
            self.note("joint", str(following.get("name")), f"link_length_error of {joint} {longer:+.4g} m")
            return True

        return self.each(values, "length_error", write)

    def base_tilt(self, values: Values) -> Values:
        """The turn of the first joint's frame."""
        first = self.found.get(self.joints[0])
        if first is None:
            return values
        angle = float(np.asarray(values["angle"]).ravel()[0])
        origin = first.find("origin")
        origin = SubElement(first, "origin", xyz="0 0 0", rpy="0 0 0") if origin is None else origin
        origin.set("rpy", written(turned(numbers(origin.get("rpy"), 3), angle)))
        self.note("joint", self.joints[0], f"base_tilt {angle:+.4g} rad about X: origin")
        return {}

    def _following(self, joint: str) -> Element | None:
        """The joint on the link that a joint moves."""
        child = self.found[joint].find("child") if joint in self.found else None
        link = None if child is None else child.get("link")
        for each in self.root.findall("joint"):
            parent = each.find("parent")
            if parent is not None and parent.get("link") == link:
                return each
        return None

    def _limit(self, joint: str) -> Element | None:
        found = self.found.get(joint)
        if found is None:
            return None
        limit = found.find("limit")
        return SubElement(found, "limit", effort="0", velocity="0") if limit is None else limit
