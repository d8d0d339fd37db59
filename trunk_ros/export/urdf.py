"""Effects in URDF: what it says of limits, frames and masses. It has no actuators and no sensors."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

import numpy as np

from trunk_ros.arm.description import Description
from trunk_ros.bodies.found import Bodies
from trunk_ros.effect_values import Values
from trunk_ros.errors import ModelError
from trunk_ros.export.joints import JointWriter
from trunk_ros.export.last_link import OTHER_FRAME, TOO_LIGHT, Frame, own_part, told, turn_between
from trunk_ros.export.markup import numbers, to_text, turned, written

NO_INERTIAL = "{}: mass and centre of the last link: {} has no <inertial> to write them into"


class UrdfWriter(JointWriter):
    """Writes into a URDF file."""

    kind, tag, joints_at = "URDF", "robot", "joint"

    def limit(self, joint: str) -> Element | None:
        found = self.found.get(joint)
        if found is None:
            return None
        limit = found.find("limit")
        return SubElement(found, "limit", effort="0", velocity="0") if limit is None else limit

    def told(self, limit: Element, key: str) -> str | None:
        return limit.get(key)

    def tell(self, limit: Element, key: str, text: str) -> None:
        limit.set(key, text)

    def term(self, joint: str, name: str, value: float) -> str:
        """``friction`` and ``damping`` of ``dynamics``."""
        found = self.found.get(joint)
        if found is None or name == "armature":
            return ""
        dynamics = found.find("dynamics")
        dynamics = SubElement(found, "dynamics") if dynamics is None else dynamics
        dynamics.set(name, written([value]))
        return "dynamics"

    def last_link(self, bodies: Bodies) -> None:
        """``inertial`` of the link that the last joint moves; its inertia about the centre stays."""
        why = self._last_link(bodies)
        if why:
            self.remarks.append(why)

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

    def _last_link(self, bodies: Bodies) -> str:
        """Why it cannot be written, if so."""
        arm = self.model.arm
        names = [joint for joint in self.joints if joint in self.found and joint != bodies.last]
        names.append(bodies.last)
        try:
            theirs = Description(to_text(self.root)).found(tuple(names)).body(tuple(names))
            mine = Frame.of(arm.body, [arm.joints.index(name) for name in names])
            turn = turn_between(mine, Frame.of(theirs, list(range(len(names)))))
        except (ModelError, ValueError):
            turn = None
        if turn is None:
            return OTHER_FRAME.format(bodies.last)
        child = self.found[bodies.last].find("child")
        name = "" if child is None else str(child.get("link"))
        inertial = self.root.find(f"link[@name='{name}']/inertial")
        mass = None if inertial is None else inertial.find("mass")
        if inertial is None or mass is None:
            return NO_INERTIAL.format(bodies.last, name)
        origin = inertial.find("origin")
        origin = SubElement(inertial, "origin", xyz="0 0 0", rpy="0 0 0") if origin is None else origin
        own, whole = numbers(mass.get("value"), 1)[0], theirs.last_link
        others = whole.mass * whole.lever - own * np.array(numbers(origin.get("xyz"), 3))
        part = own_part(bodies, turn, np.zeros(3), whole.mass, (whole.mass - own, others))
        if part is None:
            return TOO_LIGHT.format(bodies.last)
        mass.set("value", written([part[0]]))
        origin.set("xyz", written(part[1]))
        self.note("link", name, told(bodies))
        return ""

    def _following(self, joint: str) -> Element | None:
        """The joint on the link that a joint moves."""
        child = self.found[joint].find("child") if joint in self.found else None
        link = None if child is None else child.get("link")
        for each in self.root.findall("joint"):
            parent = each.find("parent")
            if parent is not None and parent.get("link") == link:
                return each
        return None
