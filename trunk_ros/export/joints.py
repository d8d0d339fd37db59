"""What URDF and SDF share: a file of joints with limits."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import ClassVar
from xml.etree.ElementTree import Element

from trunk_ros.effect_values import Values
from trunk_ros.errors import TrunkError
from trunk_ros.export.markup import commented, parse, to_text, written
from trunk_ros.export.sheet import Writer
from trunk_ros.model import Model


class JointWriter(Writer):
    """Writes into an XML file that has the model's joints by name."""

    kind: ClassVar[str]
    """What such a file is called."""
    tag: ClassVar[str]
    """Of its root."""
    joints_at: ClassVar[str]
    """Where its joints are."""

    def __init__(self, model: Model, path: Path):
        """Raises TrunkError for a file of another kind, or with none of the joints."""
        super().__init__(model)
        self.root = parse(path.read_text(encoding="utf-8"), str(path))
        self.found = {str(joint.get("name")): joint for joint in self.root.findall(self.joints_at)}
        if self.root.tag != self.tag or not set(self.joints) & set(self.found):
            raise TrunkError(f"{path}: no {self.kind} with any of the joints {', '.join(self.joints)}")
        self.remarks += [f"{joint}: not in the file" for joint in self.joints if joint not in self.found]

    @abstractmethod
    def limit(self, joint: str) -> Element | None:
        """The limits of a joint, made where there are none; None for a joint that is not in the file."""

    @abstractmethod
    def told(self, limit: Element, key: str) -> str | None:
        """A limit as the file has it."""

    @abstractmethod
    def tell(self, limit: Element, key: str, text: str) -> None:
        """Write a limit."""

    def text(self) -> str:
        commented(self.root, self.lines)
        return to_text(self.root)

    def hard_stop(self, values: Values) -> Values:
        """The joint's limit, where it is nearer than the one in the file."""
        key = "upper" if values.get("form", "upper") == "upper" else "lower"

        def write(joint: str, end: float) -> bool:
            limit = self.limit(joint)
            if limit is None:
                return False
            known = self.told(limit, key)
            nearest = (min if key == "upper" else max)(end, float(known)) if known else end
            self.tell(limit, key, written([nearest]))
            self.note("joint", joint, f"hard_stop at {end:.4g} rad: limit")
            return True

        return self.each(values, key, write)

    def velocity_saturation(self, values: Values) -> Values:
        """The joint's top speed; of one that is faster one way both are the layer's, as limits are even."""
        if "uneven_speed" in self.model.effects or not set(self.joints) <= set(self.found):
            return values

        def write(joint: str, fastest: float) -> bool:
            limit = self.limit(joint)
            assert limit is not None
            ratio = abs(float(self.model.arm.ratio[self.joints.index(joint)]))
            self.tell(limit, "velocity", written([fastest * ratio]))
            self.note("joint", joint, f"velocity_saturation {fastest:.4g} rad/s at the motor: limit")
            return True

        return self.each(values, "v_max", write)
