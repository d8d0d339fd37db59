"""The complete model of an arm: its nominal description and the effects found in it; a ROS 2 parameter file on disk."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.description import ANY_JOINTS, arm_from, arm_parameters, check_names, declared_arm
from trunk_ros.description import Declaration as Declaration
from trunk_ros.effects import Effect, effect, registry
from trunk_ros.errors import ModelError

Values = dict[str, Any]


@dataclass(frozen=True)
class Model:
    """An arm and its effects: ``effects[id]`` maps a parameter to (joints,) values, a float where shared, words to lists.

    ``duration`` is the length [s] of the recording that effects of time were fitted on; live nodes hold their value at its end.
    """

    arm: Arm
    effects: Mapping[str, Values] = field(default_factory=dict)
    duration: float = 0.0

    @property
    def any_joints(self) -> bool:
        """Whether the model takes the joints of whatever recording it meets."""
        return self.arm.joints == (ANY_JOINTS,)

    @property
    def payload(self) -> float:
        """Mass at the tip [kg], nominal and found."""
        found = (values.get("payload", 0.0) for values in self.effects.values())
        return self.arm.payload + float(sum(found))

    def loaded_arm(self) -> Arm:
        """The arm with the payload that was found."""
        return replace(self.arm, payload=self.payload)

    def for_joints(self, joints: tuple[str, ...]) -> Model:
        """The model for a recording's joints. Raises ModelError where a joint is not the arm's."""
        if self.any_joints:
            one = self.arm
            spread = {name: np.full(len(joints), getattr(one, name)[0]) for name in ("ratio", "dead_band", "lower", "upper")}
            return replace(self, arm=replace(one, joints=joints, **spread))
        for joint in joints:
            self.arm.index(joint)
        return self

    def bound(self, stage: str) -> list[Effect]:
        """The effects of a stage as blocks over all joints, in physical order."""
        return [bind(name, values, self.arm.joints) for name, values in self.in_order() if effect(name).stage == stage]

    def in_order(self) -> list[tuple[str, Values]]:
        """The effects that the model has, in the registry's order."""
        return [(name, self.effects[name]) for name in registry() if name in self.effects]

    def parameters(self) -> dict[str, Any]:
        """Flat ROS parameters, effects at their null left out."""
        flat = arm_parameters(self.arm)
        flat["model.duration"] = float(self.duration)
        for name, values in self.in_order():
            for key, value in values.items():
                flat[f"effects.{name}.{key}"] = value.tolist() if isinstance(value, np.ndarray) else value
        return flat

    @staticmethod
    def from_parameters(flat: Mapping[str, Any]) -> Model:
        """The model of flat ROS parameters. Raises ModelError for unknown names, lengths or values out of bounds."""
        check_names(flat, {d.name for d in declared_parameters()})
        arm = arm_from(flat)
        effects: dict[str, Values] = {}
        for name, kind in registry().items():
            given = {key.split(".", 2)[2]: value for key, value in flat.items() if key.startswith(f"effects.{name}.")}
            values = _effect_values(kind, given, arm.joints)
            if values:
                effects[name] = values
        return Model(arm, effects, float(flat.get("model.duration", 0.0)))

    def hash(self) -> str:
        """Twelve hex digits that change with any parameter."""
        text = json.dumps(self.parameters(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]


def bind(name: str, values: Values, joints: tuple[str, ...]) -> Effect:
    """An effect over all joints from a model's values."""
    kind = effect(name)
    numbers: dict[str, Array] = {
        p.name: np.broadcast_to(np.asarray(values.get(p.name, p.null), dtype=float), (len(joints),)) for p in kind.parameters
    }
    return kind(numbers, {text: tuple(values[text]) for text in kind.texts if text in values}, str(values.get("form", "")))


def _effect_values(kind: type[Effect], given: Mapping[str, Any], joints: tuple[str, ...]) -> Values:
    """A model's values of one effect; empty where everything is at its null."""
    values: Values = {}
    for p in kind.parameters:
        numbers = np.atleast_1d(np.asarray(given.get(p.name, []), dtype=float))
        if not numbers.size or np.all(numbers == p.null):
            continue
        where = f"effects.{kind.id}.{p.name}"
        if numbers.size not in (1, len(joints)) or (p.shared and numbers.size != 1):
            raise ModelError(f"{where} has {numbers.size} values: give {1 if p.shared else len(joints)}")
        if not np.all((numbers >= p.bounds[0]) & (numbers <= p.bounds[1])):
            raise ModelError(f"{where} = {numbers.tolist()} is outside {p.bounds[0]:g} ... {p.bounds[1]:g} {p.unit}")
        values[p.name] = float(numbers[0]) if p.shared else np.broadcast_to(numbers, (len(joints),)).copy()
    if not values:
        return {}
    for text in kind.texts:
        words = [str(word) for word in given.get(text, [])]
        if any(words):
            values[text] = words
    if given.get("form"):
        values["form"] = str(given["form"])
    bind(kind.id, values, joints)
    return values


def declared_parameters() -> list[Declaration]:
    """Every parameter of a model, with unit, bounds and meaning: what each node declares."""
    declared = declared_arm()
    for name, kind in registry().items():
        for p in kind.parameters:
            default: Any = float(p.null) if p.shared else [float(p.null)]
            declared.append(Declaration(f"effects.{name}.{p.name}", default, p.unit, p.bounds, f"{name}: {p.meaning}"))
        for text in kind.texts:
            declared.append(Declaration(f"effects.{name}.{text}", [""], "", None, f"{name}: {text}, one word per joint"))
        if len(kind.forms) > 1:
            forms = ", ".join(kind.forms)
            declared.append(Declaration(f"effects.{name}.form", kind.forms[0], "", None, f"{name}: one of {forms}"))
    return declared


def load_model(name: str | Path) -> Model:
    """Read a model file, or one of those in config/ by name. Raises ModelError in one line."""
    path = Path(name)
    if not path.is_file():
        from trunk_ros.share import config_path

        path = config_path(f"{name}.yaml") if "/" not in str(name) and path.suffix != ".yaml" else path
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(f"cannot read the model {path}: {getattr(error, 'strerror', None) or error}") from None
    except yaml.YAMLError as error:
        raise ModelError(f"{path} is not YAML: {' '.join(str(error).split())}") from None
    try:
        tree = next(iter(content.values()))["ros__parameters"]
    except (AttributeError, KeyError, TypeError, StopIteration):
        raise ModelError(f"{path} is not a ROS 2 parameter file: it wants '/**: ros__parameters:' at the top") from None
    try:
        return Model.from_parameters(dict(_flatten(tree)))
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from None
    except (TypeError, ValueError) as error:
        raise ModelError(f"{path}: a parameter has a value of the wrong kind ({error})") from None


def save_model(model: Model, path: Path) -> None:
    """Write a model as a ROS 2 parameter file."""
    tree: dict[str, Any] = {}
    for key, value in model.parameters().items():
        branch = tree
        *parents, leaf = key.split(".")
        for parent in parents:
            branch = branch.setdefault(parent, {})
        branch[leaf] = value
    text = yaml.safe_dump({"/**": {"ros__parameters": tree}}, sort_keys=False, default_flow_style=None, width=120)
    path.write_text(text)


def _flatten(tree: Any, prefix: str = "") -> list[tuple[str, Any]]:
    if not isinstance(tree, dict):
        return [(prefix, tree)]
    return [pair for key, value in tree.items() for pair in _flatten(value, f"{prefix}.{key}" if prefix else str(key))]
