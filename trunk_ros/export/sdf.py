"""Effects in SDF, with the joints' position controllers of Gazebo where the file has them."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

import numpy as np

from trunk_ros.bodies.found import Bodies
from trunk_ros.effect_values import Values
from trunk_ros.export.joints import JointWriter
from trunk_ros.export.last_link import told
from trunk_ros.export.markup import numbers, turned, written

CONTROLLER = "JointPositionController"


class SdfWriter(JointWriter):
    """Writes into an SDF file. Play, compliance and lag are said beside the gains of a joint's position
    controller; without one they are left.
    """

    kind, tag, joints_at = "SDF", "sdf", ".//joint"

    def limit(self, joint: str) -> Element | None:
        return self._part(joint, "limit")

    def told(self, limit: Element, key: str) -> str | None:
        known = limit.find(key)
        return None if known is None else known.text

    def tell(self, limit: Element, key: str, text: str) -> None:
        child(limit, key).text = text

    def term(self, joint: str, name: str, value: float) -> str:
        """``friction`` and ``damping`` of the axis."""
        dynamics = None if name == "armature" else self._part(joint, "dynamics")
        if dynamics is None:
            return ""
        child(dynamics, name).text = written([value])
        return "dynamics"

    def last_link(self, bodies: Bodies) -> None:
        """Left to the user, since links of SDF may be placed in any frame."""
        self.remarks.append(f"{told(bodies)}: write it into the link's inertial, in its own frame")

    def backlash(self, values: Values) -> Values:
        """Friction over the controller's gain is a play."""

        def write(joint: str, half_width: float) -> bool:
            gain = self._gain(joint, "p_gain")
            if gain is None:
                return False
            self._add(joint, "friction", half_width * numbers(gain.text, 1)[0])
            self.taken[joint, "friction"], self.half_widths[joint] = "backlash", half_width
            self.note("joint", joint, f"backlash {half_width:.4g} rad: friction over p_gain")
            return True

        return self.each(values, "half_width", write)

    def viscous_lag(self, values: Values) -> Values:
        """Damping over the controller's gain; a mere delay, or a lag without inertia, is left."""
        if values.get("form", "first_order") != "first_order":
            return values

        def write(joint: str, constant: float) -> bool:
            gain = self._gain(joint, "p_gain")
            if gain is None:
                return False
            self._add(joint, "damping", constant * numbers(gain.text, 1)[0])
            self.taken[joint, "damping"] = "viscous_lag"
            self.note("joint", joint, f"viscous_lag {constant:.4g} s: damping over p_gain")
            return True

        return self.each(values, "time_constant", write)

    def load_elasticity(self, values: Values) -> Values:
        """A spring in series with the controller's gain; one that links swing on, or that changes with
        the angle, is left.
        """
        if values.get("form", "weight") != "weight":
            return values

        def write(joint: str, compliance: float) -> bool:
            gain = self._gain(joint, "p_gain")
            if gain is None or compliance < 0.0:
                return False
            firm = numbers(gain.text, 1)[0]
            factor = 1.0 / (1.0 + firm * compliance)
            if joint in self.half_widths:  # of the same width over less stiffness
                self._add(joint, "friction", -self.half_widths[joint] * firm * (1.0 - factor))
            for name in ("p_gain", "d_gain"):
                element = self._gain(joint, name)
                if element is not None:
                    element.text = written([numbers(element.text, 1)[0] * factor])
            self.note("joint", joint, f"load_elasticity {compliance:.4g} rad/(N m): gains of its controller")
            return True

        return self.each(values, "compliance", write)

    def base_tilt(self, values: Values) -> Values:
        """The pose of the model."""
        model = next(self.root.iter("model"), None)
        if model is None:
            return values
        angle = float(np.asarray(values["angle"]).ravel()[0])
        pose = child(model, "pose")
        there = numbers(pose.text, 6)
        pose.text = written([*there[:3], *turned(there[3:], angle)])
        self.note("model", str(model.get("name")), f"base_tilt {angle:+.4g} rad about X: pose")
        return {}

    def _gain(self, joint: str, name: str) -> Element | None:
        """A gain of the joint's position controller."""
        for plugin in self.root.iter("plugin"):
            told = plugin.find("joint_name")
            if CONTROLLER in str(plugin.get("name")) and told is not None and told.text == joint:
                return plugin.find(name)
        return None

    def _part(self, joint: str, name: str) -> Element | None:
        """``limit`` or ``dynamics`` of a joint's axis."""
        axis = self.found[joint].find("axis") if joint in self.found else None
        return None if axis is None else child(axis, name)

    def _add(self, joint: str, name: str, more: float) -> None:
        dynamics = self._part(joint, "dynamics")
        if dynamics is not None:
            element = child(dynamics, name)
            element.text = written([numbers(element.text, 1)[0] + more])


def child(element: Element, name: str) -> Element:
    """A child by name, made where there is none."""
    found = element.find(name)
    return SubElement(element, name) if found is None else found
