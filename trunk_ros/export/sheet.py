"""What became of each effect in another simulator's file."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from trunk_ros.bodies.found import Bodies
from trunk_ros.effect_values import Values
from trunk_ros.effects import effect
from trunk_ros.export.missing import missing
from trunk_ros.model import Model

TERMS = ("friction", "damping", "armature")  # of bodies.yaml, which a file can have
AT_THE_MOTOR = ("load_droop", "motor_friction", "servo_bandwidth", "unknown_servo")
"""What friction and masses do to a motor, by the names of a diagnosis that knows neither."""
TWICE = "{}: left out: friction and masses do that to the motors, and they are written as bodies"
TAKEN = "{}: not written, {} is in its place; it lies before the wire, in the servo's own loop"


@dataclass(frozen=True)
class Line:
    """One thing that was written: the element it is in, and where it comes from."""

    tag: str
    name: str
    text: str


@dataclass
class Sheet:
    """The new file, what was written into it, and what is left for the reality layer."""

    text: str
    lines: list[Line]
    layer: Model
    remarks: list[str] = field(default_factory=list)

    @property
    def left(self) -> list[str]:
        """What the layer adds, a sentence each with its size."""
        return [f"{name}: {sizes(self.layer, name, values)}" for name, values in self.layer.in_order()]


class Writer(ABC):
    """Writes effects into a file: a method named as an effect takes its values, writes what the format can
    say, and returns what is left of them.
    """

    def __init__(self, model: Model):
        """``model``: what the simulator lacks, over its own ratios."""
        self.model = model
        self.joints = model.arm.joints
        self.lines: list[Line] = []
        self.remarks: list[str] = []
        self.taken: dict[tuple[str, str], str] = {}
        """By joint and term (friction, damping, armature) the effect that is written in its place."""
        self.half_widths: dict[str, float] = {}
        """By joint the backlash that is written as friction over stiffness [rad]."""

    @abstractmethod
    def text(self) -> str:
        """The file with what was written, each with a comment."""

    @abstractmethod
    def last_link(self, bodies: Bodies) -> None:
        """Write mass and centre of the last link, or remark why not."""

    @abstractmethod
    def term(self, joint: str, name: str, value: float) -> str:
        """Write a joint's friction, damping or armature; what the format calls it, "" where it cannot."""

    def run(self, bodies: Bodies | None = None) -> Sheet:
        """Write all effects, and friction, armature and the last link where torque has shown them."""
        if bodies is not None and bodies.centre is not None:
            self.last_link(bodies)  # before an effect adds a payload to it
        left: dict[str, Values] = {}
        for name, values in self.model.in_order():
            write: Callable[[Values], Values] | None = getattr(self, name, None)
            rest = values if write is None else write(values)
            if rest and effect(name).stage == "arm":
                self.remarks.append(f"{name}: {sizes(self.model, name, rest)}: this file has no place for it")
            elif rest:
                left[name] = rest
        if bodies is not None:
            self._terms(bodies)
        layer = replace(self.model, effects=left)
        told = self.model.number("kp") / layer.number("kp")  # what the file has of it now, as a factor
        arm = replace(layer.arm, kp=layer.arm.kp * told)
        return Sheet(self.text(), self.lines, replace(layer, arm=arm), self.remarks)

    def _terms(self, bodies: Bodies) -> None:
        """What was fitted of each joint, where no effect has its place."""
        for joint, own in bodies.joints.items():
            for name in (name for name in TERMS if name in own and joint in self.joints):
                said = f"{joint}: {name} {own[name].value:.4g} {own[name].unit}"
                if (joint, name) in self.taken:
                    self.remarks.append(TAKEN.format(said, self.taken[joint, name]))
                    continue
                called = self.term(joint, name, own[name].value)
                if called:
                    self.note(
                        "joint", joint, f"bodies: {name} {own[name].value:.4g} {own[name].unit}: {called}"
                    )
                else:
                    self.remarks.append(f"{said}: this file has no place for it")

    def each(self, values: Values, key: str, write: Callable[[str, float], bool]) -> Values:
        """Write a value per joint; what is left where ``write`` could not."""
        kind = next(name for name, v in self.model.effects.items() if v is values)
        null = effect(kind).parameter(key).null
        sizes_ = np.broadcast_to(np.asarray(values[key], dtype=float), (len(self.joints),)).copy()
        for k, joint in enumerate(self.joints):
            if sizes_[k] != null and write(joint, float(sizes_[k])):
                sizes_[k] = null
        return {**values, key: sizes_} if np.any(sizes_ != null) else {}

    def note(self, tag: str, name: str, text: str) -> None:
        """Remember what was written where."""
        self.lines.append(Line(tag, name, text))


def sheet_of(
    model: Model, simulation: Model | None, writer: Callable[[Model], Writer], bodies: Bodies | None = None
) -> Sheet:
    """What a simulator lacks, written by the writer of its format."""
    lacking = missing(model, simulation)
    effects = lacking.model.effects
    twice = [n for n in AT_THE_MOTOR if n in effects] if bodies is not None and bodies.pull_at_motors else []
    wanted = replace(lacking.model, effects={n: v for n, v in effects.items() if n not in twice})
    out = writer(wanted).run(bodies)
    out.remarks = [*lacking.remarks, *map(TWICE.format, twice), *out.remarks]
    return out


def sizes(model: Model, name: str, values: Values) -> str:
    """The leading parameter of an effect, by joint where it has one each."""
    lead = effect(name).own_parameters(str(values.get("form", effect(name).forms[0])))[0]
    given = np.asarray(values.get(lead.name, lead.null), dtype=float)
    unit = "" if lead.unit == "1" else f" {lead.unit}"
    if lead.shared or given.ndim == 0:
        return f"{lead.name} {float(given):.4g}{unit}"
    if not effect(name).named:
        over = zip(model.arm.joints, values.get("on", ()), strict=False)
        return f"a curve on {', '.join(joint for joint, on in over if on)}"
    own = [f"{j} {v:.4g}{unit}" for j, v in zip(model.arm.joints, given, strict=True) if v != lead.null]
    return f"{lead.name} {', '.join(own)}"
