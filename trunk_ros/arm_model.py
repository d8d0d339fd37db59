"""An arm and the effects found in it, apart from files and from what it predicts."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self, TypeVar

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.description import Description
from trunk_ros.arm.flat import limits_in
from trunk_ros.arm.parameters import ANY_JOINTS
from trunk_ros.compiled import Array
from trunk_ros.effect_values import Values, at_end, bind, payload_in, spread_over
from trunk_ros.effects import Effect, effect, registry
from trunk_ros.effects.moments import NOTHING, Payload
from trunk_ros.errors import ModelError

HELD, SAMPLED = "held", "sampled"
FITTED_ON = ("error", "zero", "reach", "lowest", "highest")
"""What a model knows of each joint from the recordings that it was fitted on."""

AnyModel = TypeVar("AnyModel", bound="ArmModel")  # what is made of a model is of its kind


@dataclass(frozen=True)
class ArmModel:
    """An arm and its effects: ``effects[id]`` maps a parameter to (joints,) values, a float where shared,
    words to lists.

    ``duration`` is the length [s] of the recording that effects of time were fitted on; live nodes hold
    their value at its end. ``error``, ``zero``, ``reach``, ``lowest`` and ``highest`` (joints,) rad are what
    it left of samples that its fit did not see, what it was off by throughout a recording that it did not
    see, and how far from their mean, rms, and between which angles the motors went there, joint side; empty
    where that is not known.
    """

    arm: Arm
    effects: Mapping[str, Values] = field(default_factory=dict)
    duration: float = 0.0
    error: Array = field(default_factory=lambda: np.empty(0))
    zero: Array = field(default_factory=lambda: np.empty(0))
    reach: Array = field(default_factory=lambda: np.empty(0))
    lowest: Array = field(default_factory=lambda: np.empty(0))
    highest: Array = field(default_factory=lambda: np.empty(0))
    setpoints: str = HELD
    """What recorded setpoints are: each held until the next, or samples of what the servo got (SAMPLED)."""
    setpoints_stated: bool = False
    """Whether that is said, and not what is supposed of recordings of which nobody said it."""
    recordings: tuple[str, ...] = ()
    """Those that curves over time without a name were drawn from, as ``Recording.stamped``. Empty where that
    is not known."""

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

    def at_end(self) -> Self:
        """The model as it is at the end of the recording that it was fitted on: what had ended by then is
        gone, what had begun lasts.
        """
        there = {name: at_end(name, v, self.duration, self.arm.joints) for name, v in self.in_order()}
        return replace(self, effects={name: values for name, values in there.items() if values})

    @property
    def says_its_servos(self) -> bool:
        """Whether anything is known of its servos: otherwise they are those of the paper's arm."""
        return self.arm.servo_stated or any(effect(name).stage == "servo" for name in self.effects)

    def loaded_arm(self) -> Arm:
        """The arm with the payload that was found."""
        return replace(self.arm, payload=self.payload)

    def number(self, name: str) -> Any:
        """A number of the arm, such as its ``ratio``, with what was found of it."""
        return self._with_found(name, getattr(self.arm, name))

    @property
    def top_speeds(self) -> Array:
        """(2, joints) rad/s: the top speeds of the shafts upwards and downwards, with what was found."""
        v_max = np.broadcast_to(self.number("v_max"), len(self.arm.joints))
        return np.asarray(self._with_found("top_speeds", np.array([v_max, v_max])))

    @property
    def ki(self) -> Array:
        """(joints,) 1/s^2: the gain of an integral part that was found."""
        return np.asarray(self._with_found("ki", np.zeros(len(self.arm.joints))))

    def _with_found(self, name: str, number: Any) -> Any:
        for found, values in self.in_order():
            number = effect(found).changed(number, values) if effect(found).changes == name else number
        return number

    def with_numbers(self, names: Collection[str]) -> Self:
        """The model whose arm has the numbers of these names as they were found, by joint, without the
        effects that say so.
        """
        numbers: dict[str, Any] = {
            name: np.broadcast_to(self.number(name), len(self.arm.joints)) for name in names
        }
        others = {n: values for n, values in self.effects.items() if effect(n).changes not in names}
        return replace(self, arm=replace(self.arm, **numbers), effects=others)

    def prompt(self) -> Self:
        """The model with readings that are not late: as the joints are."""
        kept = {name: v for name, v in self.effects.items() if not effect(name).delays_readings}
        return replace(self, effects=kept)

    def for_joints(self, joints: tuple[str, ...]) -> Self:
        """The model for a recording's joints. Raises ModelError where a joint is not the arm's."""
        if self.any_joints:
            return replace(
                self,
                arm=_spread(self.arm, joints),
                **{name: spread_over(getattr(self, name), len(joints)) for name in FITTED_ON},
                effects={
                    name: {key: spread_over(value, len(joints)) for key, value in values.items()}
                    for name, values in self.effects.items()
                },
            )
        for joint in joints:
            self.arm.index(joint)
        return self

    def with_urdf(self, text: str, recorded: tuple[str, ...]) -> Self:
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

    def only(self, joints: tuple[str, ...]) -> Self:
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
        fitted_on = {name: cut(known) if len(known := getattr(self, name)) else known for name in FITTED_ON}
        return replace(self, arm=self.loaded_arm().only(joints), effects=effects, **fitted_on)

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


def _spread(arm: Arm, joints: tuple[str, ...]) -> Arm:
    """The arm with as many joints as that, each like its only one."""
    names = ("ratio", "dead_band", "lower", "upper", "compliance", "link_length", "link_mass")
    arrays: dict[str, Any] = {name: spread_over(getattr(arm, name), len(joints)) for name in names}
    return replace(arm, joints=joints, wire=None, **arrays)
