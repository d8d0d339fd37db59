"""The complete model of an arm: its nominal description and the effects found in it; a ROS 2 parameter file
on disk.
"""

from __future__ import annotations

import difflib
import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.arm.flat import arm_from, arm_parameters, per_joint
from trunk_ros.arm.parameters import RENAMED, check_names, checked, declared_arm, shortened
from trunk_ros.arm_model import FITTED_ON, HELD, SAMPLED
from trunk_ros.effect_values import Values, check_rivals, effect_values
from trunk_ros.effects import effect, registry
from trunk_ros.errors import ModelError
from trunk_ros.parameter import Declaration
from trunk_ros.parameter_file import model_path, read_parameters, write_parameters
from trunk_ros.predictor import Predictor


@dataclass(frozen=True)
class Model(Predictor):
    """An arm and its effects, with what it predicts and as a file; see ``ArmModel`` for what it holds."""

    def parameters(self) -> dict[str, Any]:
        """Flat ROS parameters, effects at their null left out."""
        flat = arm_parameters(self.arm)
        flat["recording.duration"] = float(self.duration)
        if self.setpoints != HELD or self.setpoints_stated:
            flat["recording.setpoints"] = self.setpoints
        if self.recordings:
            flat["recording.of"] = list(self.recordings)
        flat |= {
            f"recording.{name}": known.tolist() for name in FITTED_ON if len(known := getattr(self, name))
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
        _check_effects(flat)
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
        known = {name: per_joint(given, f"recording.{name}", len(arm.joints)) for name in FITTED_ON}
        setpoints = given.get("recording.setpoints", HELD)
        if setpoints not in (HELD, SAMPLED):
            raise ModelError(f"recording.setpoints = {shortened(setpoints)}: choose {HELD} or {SAMPLED}")
        duration = given.get("recording.duration", 0.0)
        of = tuple(filter(None, given.get("recording.of", [])))
        stated = "recording.setpoints" in given
        return Model(
            arm, effects, duration, **known, setpoints=setpoints, setpoints_stated=stated, recordings=of
        )

    def hash(self) -> str:
        """Twelve hex digits that change with any parameter."""
        text = json.dumps(self.parameters(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]


def _check_effects(names: Iterable[str]) -> None:
    """Raise ModelError for values of an effect that there is not."""
    for name in names:
        group, _, rest = name.partition(".")
        own = rest.partition(".")[0]
        if group == "effects" and own and own not in registry():
            near = difflib.get_close_matches(own, registry(), 1)
            raise ModelError(
                f"unknown effect {shortened(own)}{f': did you mean {near[0]!r}?' if near else ''} "
                "(one of your own is found where the environment variable TRUNK_ROS_EFFECTS names its folder)"
            )


def declared_parameters() -> list[Declaration]:
    """Every parameter of a model, with unit, bounds and meaning: what each node declares."""
    declared = declared_arm()
    for name, kind in registry().items():
        for p in (*kind.parameters, *kind.moments()):
            default: Any = float(p.null) if p.shared else [float(p.null)]
            both = p.shared and bool(kind.apart) and p in kind.parameters
            meaning = f"{name}: {p.meaning}" + (f"; one per joint in form {kind.apart}" if both else "")
            declared.append(
                Declaration(f"effects.{name}.{p.name}", default, p.unit, p.bounds, meaning, free=both)
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
