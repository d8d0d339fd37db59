"""The complete model of an arm: its nominal description and the effects found in it; a ROS 2 parameter file
on disk.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.description import Description
from trunk_ros.arm.flat import arm_from, arm_parameters, limits_in, per_joint
from trunk_ros.arm.parameters import ANY_JOINTS, RENAMED, check_names, checked, declared_arm
from trunk_ros.compiled import Array
from trunk_ros.effect_values import Values, at_end, bind, check_rivals, effect_values, payload_in, spread_over
from trunk_ros.effects import Effect, effect, registry
from trunk_ros.effects.lasting import NOTHING, Payload
from trunk_ros.errors import ModelError
from trunk_ros.parameter import Declaration
from trunk_ros.parameter_file import model_path, read_parameters, write_parameters
from trunk_ros.predictor import Predictor


@dataclass(frozen=True)
class Model(Predictor):
    """An arm and its effects: ``effects[id]`` maps a parameter to (joints,) values, a float where shared,
    words to lists.

    ``duration`` is the length [s] of the recording that effects of time were fitted on; live nodes hold
    their value at its end. ``error`` and ``reach`` (joints,) rad are what it left of samples that its fit
    did not
    see, and how far from their mean the motors went there, joint side, rms; empty where that is not known.
    """

    arm: Arm
    effects: Mapping[str, Values] = field(default_factory=dict)
    duration: float = 0.0
    error: Array = field(default_factory=lambda: np.empty(0))
    reach: Array = field(default_factory=lambda: np.empty(0))

    @property
    def any_joints(self) -> bool:
        """Whether the model takes the joints of whatever recording it meets."""
        return self.arm.joints == (ANY_JOINTS,)

    @property
    def payload(self) -> float:
        """Mass at the tip [kg], nominal and found."""
        return self.arm.payload + sum(one.mass for one in self._payloads() if one.always)

    @property
    def taken_up(self) -> Payload:
        """A mass at the tip that is not there from beginning to end."""
        return next((one for one in self._payloads() if not one.always), NOTHING)

    def _payloads(self) -> list[Payload]:
        return [
            payload_in(p.name, values)
            for name, values in self.effects.items()
            for p in effect(name).carried()
        ]

    def at_end(self) -> Model:
        """The model as it is at the end of the recording that it was fitted on: what had ended by then is
        gone, what had begun lasts.
        """
        there = {name: at_end(name, v, self.duration, self.arm.joints) for name, v in self.in_order()}
        return replace(self, effects={name: values for name, values in there.items() if values})

    def loaded_arm(self) -> Arm:
        """The arm with the payload that was found."""
        return replace(self.arm, payload=self.payload)

    def for_joints(self, joints: tuple[str, ...]) -> Model:
        """The model for a recording's joints. Raises ModelError where a joint is not the arm's."""
        if self.any_joints:
            return replace(
                self,
                arm=_spread(self.arm, joints),
                error=spread_over(self.error, len(joints)),
                reach=spread_over(self.reach, len(joints)),
                effects={
                    name: {key: spread_over(value, len(joints)) for key, value in values.items()}
                    for name, values in self.effects.items()
                },
            )
        for joint in joints:
            self.arm.index(joint)
        return self

    def with_urdf(self, text: str, recorded: tuple[str, ...]) -> Model:
        """The model with the links of a URDF; one for any joints takes those of ``recorded`` that move its
        tip.

        Raises ModelError where the URDF has none of them.
        """
        description = Description(text).found(recorded)
        own = tuple(joint.name for joint in description.arm_joints)
        joints = tuple(joint for joint in own if joint in recorded) if self.any_joints else self.arm.joints
        if other := [joint for joint in joints if joint not in own] or (not joints and recorded):
            raise ModelError(
                f"the URDF is of another arm: {', '.join(own)} move its {description.tip}, "
                f"not {', '.join(other)}"
            )
        arm = _spread(self.arm, joints) if self.any_joints else self.arm
        lower, upper = limits_in(description, joints)
        empty = np.empty(0)
        arm = replace(
            arm, description=description, link_length=empty, link_mass=empty, lower=lower, upper=upper
        )
        return replace(self, arm=replace(arm, load_from="weight") if arm.has_load else arm)

    def only(self, joints: tuple[str, ...]) -> Model:
        """The model of some of the arm's joints, in their order. Raises ModelError for a joint that it
        lacks.
        """
        if joints == self.arm.joints:
            return self
        columns = [self.arm.index(joint) for joint in joints]

        def cut(value: Any) -> Any:
            if isinstance(value, list):
                return [value[c] for c in columns]
            return value[columns] if isinstance(value, np.ndarray) else value

        effects = {
            name: {key: cut(value) for key, value in values.items()} for name, values in self.effects.items()
        }
        error, reach = (known[columns] if len(known) else known for known in (self.error, self.reach))
        return replace(self, arm=self.loaded_arm().only(joints), effects=effects, error=error, reach=reach)

    def bound(self, stage: str) -> list[Effect]:
        """The effects of a stage as blocks over all joints, in physical order."""
        return [
            bind(name, values, self.arm.joints)
            for name, values in self.in_order()
            if effect(name).stage == stage
        ]

    def in_order(self) -> list[tuple[str, Values]]:
        """The effects that the model has, in physical order. Raises ModelError for one that there is not."""
        order = list(registry())
        return sorted(self.effects.items(), key=lambda item: order.index(effect(item[0]).id))

    def parameters(self) -> dict[str, Any]:
        """Flat ROS parameters, effects at their null left out."""
        flat = arm_parameters(self.arm)
        flat["recording.duration"] = float(self.duration)
        flat |= {
            f"recording.{name}": known.tolist()
            for name, known in (("error", self.error), ("reach", self.reach))
            if len(known)
        }
        for name, values in self.in_order():
            for key, value in effect_values(effect(name), values, self.arm.joints).items():
                flat[f"effects.{name}.{key}"] = np.asarray(value).tolist()
        return flat

    @staticmethod
    def from_parameters(flat: Mapping[str, Any], folder: Path | None = None) -> Model:
        """The model of flat ROS parameters; files that it names are looked for in ``folder``.

        Raises ModelError for unknown names, lengths or values out of bounds.
        """
        declared = {d.name: d for d in declared_parameters()}
        flat = {RENAMED.get(name, name): value for name, value in flat.items()}
        check_names(flat, declared)
        given = {name: checked(declared[name], value) for name, value in flat.items()}
        arm = arm_from(given, folder)
        effects: dict[str, Values] = {}
        for name, kind in registry().items():
            own = {
                key.split(".", 2)[2]: value
                for key, value in given.items()
                if key.startswith(f"effects.{name}.")
            }
            values = effect_values(kind, own, arm.joints)
            if values:
                effects[name] = values
        check_rivals(effects)
        known = {name: per_joint(given, f"recording.{name}", len(arm.joints)) for name in ("error", "reach")}
        return Model(arm, effects, given.get("recording.duration", 0.0), **known)

    def hash(self) -> str:
        """Twelve hex digits that change with any parameter."""
        text = json.dumps(self.parameters(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]


def _spread(arm: Arm, joints: tuple[str, ...]) -> Arm:
    """The arm with as many joints as that, each like its only one."""
    names = ("ratio", "dead_band", "lower", "upper", "compliance", "link_length", "link_mass")
    arrays: dict[str, Any] = {name: spread_over(getattr(arm, name), len(joints)) for name in names}
    return replace(arm, joints=joints, wire=None, **arrays)


def declared_parameters() -> list[Declaration]:
    """Every parameter of a model, with unit, bounds and meaning: what each node declares."""
    declared = declared_arm()
    for name, kind in registry().items():
        for p in (*kind.parameters, *kind.moments()):
            default: Any = float(p.null) if p.shared else [float(p.null)]
            declared.append(
                Declaration(f"effects.{name}.{p.name}", default, p.unit, p.bounds, f"{name}: {p.meaning}")
            )
        for text in kind.texts:
            declared.append(
                Declaration(f"effects.{name}.{text}", [""], "", None, f"{name}: {text}, one word per joint")
            )
        if len(kind.forms) > 1:
            forms = ", ".join(kind.forms)
            declared.append(
                Declaration(f"effects.{name}.form", kind.forms[0], "", None, f"{name}: one of {forms}")
            )
    return declared


def load_model(name: str | Path) -> Model:
    """Read a model file, or one of those in config/ by name. Raises ModelError in one line."""
    path = model_path(name)
    flat = read_parameters(path)
    try:
        return Model.from_parameters(flat, path.parent)
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from None


def save_model(model: Model, path: str | Path) -> None:
    """Write a model as a ROS 2 parameter file."""
    write_parameters(model.parameters(), Path(path))
