"""Effects in SDF, with the joints' position controllers of Gazebo where the file has them."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from trunk_ros.errors import TrunkError
from trunk_ros.export.markup import commented, numbers, parse, to_text, turned, written
from trunk_ros.export.sheet import Writer
from trunk_ros.model import Model, Values

CONTROLLER = "JointPositionController"


class SdfWriter(Writer):
    """Writes into an SDF file. Play, compliance and lag are said beside the gains of a joint's position
    controller; without one they are left.
    """

    def __init__(self, model: Model, path: Path):
        """Raises TrunkError for a file that is no SDF, or has none of the joints."""
        super().__init__(model)
        self.root = parse(path.read_text(encoding="utf-8"), str(path))
        self.found = {str(joint.get("name")): joint for joint in self.root.iter("joint")}
        if self.root.tag != "sdf" or not set(self.joints) & set(self.found):
            raise TrunkError(f"{path}: no SDF with any of the joints {', '.join(self.joints)}")
        self.remarks += [f"{joint}: not in the file" for joint in self.joints if joint not in self.found]

    def text(self) -> str:
        commented(self.root, self.lines)
        return to_text(self.root)

    def backlash(self, values: Values) -> Values:
        """Friction over the controller's gain is a play."""

        def write(joint: str, half_width: float) -> bool:
            gain = self._gain(joint, "p_gain")
            if gain is None:
                return False
            self._add(joint, "friction", half_width * numbers(gain.text, 1)[0])
            self.note("joint", joint, f"backlash {half_width:.4g} rad: friction over p_gain")
            return True

        return self.each(values, "half_width", write)

    def viscous_lag(self, values: Values) -> Values:
        """Damping over the controller's gain."""

        def write(joint: str, constant: float) -> bool:
            gain = self._gain(joint, "p_gain")
            if gain is None:
                return False
            self._add(joint, "damping", constant * numbers(gain.text, 1)[0])
            self.note("joint", joint, f"viscous_lag {constant:.4g} s: damping over p_gain")
            return True

        return self.each(values, "time_constant", write)

    def load_elasticity(self, values: Values) -> Values:
        """A spring in series with the controller's gain."""

        def write(joint: str, compliance: float) -> bool:
            gain = self._gain(joint, "p_gain")
            if gain is None or compliance < 0.0:
                return False
            factor = 1.0 / (1.0 + numbers(gain.text, 1)[0] * compliance)
            for name in ("p_gain", "d_gain"):
                element = self._gain(joint, name)
                if element is not None:
                    element.text = written([numbers(element.text, 1)[0] * factor])
            self.note("joint", joint, f"load_elasticity {compliance:.4g} rad/(N m): gains of its controller")
            return True

        return self.each(values, "compliance", write)

    def hard_stop(self, values: Values) -> Values:
        """The axis' limit."""
        key = "upper" if values.get("form", "upper") == "upper" else "lower"

        def write(joint: str, end: float) -> bool:
            limit = self._part(joint, "limit")
            if limit is None:
                return False
            known = limit.find(key)
            nearest = (
                end if known is None else (min if key == "upper" else max)(end, float(known.text or end))
            )
            child(limit, key).text = written([nearest])
            self.note("joint", joint, f"hard_stop at {end:.4g} rad: limit")
            return True

        return self.each(values, key, write)

    def velocity_saturation(self, values: Values) -> Values:
        """The axis' top speed."""
        if not set(self.joints) <= set(self.found):
            return values
        for k, joint in enumerate(self.joints):
            limit = self._part(joint, "limit")
            assert limit is not None
            top = float(values["v_max"]) * abs(float(self.model.arm.ratio[k]))
            child(limit, "velocity").text = written([top])
            self.note("joint", joint, f"velocity_saturation {values['v_max']:.4g} rad/s at the motor: limit")
        return {}

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
