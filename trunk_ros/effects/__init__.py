"""One file, one phenomenon. Files in this folder, in those named by TRUNK_ROS_EFFECTS, and modules that other
packages name as entry points of the group ``trunk_ros.effects``, are found by themselves.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import pkgutil
import sys
from collections.abc import Collection, Iterator
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import get_args

from trunk_ros.effects.effect import Effect, Regime
from trunk_ros.errors import NOT_OURS, ModelError

GROUP = "trunk_ros.effects"
ACTS = ("run", "adjust")
STAGES = ("servo", "wire", "arm")


@cache
def registry() -> dict[str, type[Effect]]:
    """All effects by ID, in physical order of stage and place."""
    found: dict[str, type[Effect]] = {}
    for module in _modules():
        for item in vars(module).values():
            known = isinstance(item, type) and issubclass(item, Effect) and item.id
            if known and found.setdefault(item.id, item) is not item:
                raise ModelError(
                    f"{module.__file__} defines the effect {item.id!r}, which exists: choose another id"
                )
            if known:
                _check(item, module)
    return dict(sorted(found.items(), key=lambda pair: (STAGES.index(pair[1].stage), pair[1].place, pair[0])))


def _check(kind: type[Effect], module: ModuleType) -> None:
    """Raise ModelError for an effect that does not say of itself what every effect has to."""
    where = f"{module.__file__}: the effect {kind.__name__}"
    if missing := [name for name in Effect.__annotations__ if not hasattr(kind, name)]:
        raise ModelError(f"{where} lacks {', '.join(missing)}: docs/adding-an-effect.md has an example")
    for name, choices in (("stage", STAGES), ("regime", get_args(Regime))):
        if getattr(kind, name) not in choices:
            raise ModelError(
                f"{where} has the {name} {getattr(kind, name)!r}: choose from {', '.join(choices)}"
            )
    if all(getattr(kind, name) is getattr(Effect, name) for name in ACTS):
        raise ModelError(f"{where} does nothing: it has neither of {', '.join(ACTS)}")
    if not kind.__module__.startswith(f"{__name__}."):
        NOT_OURS.add(kind.__module__)


def effect(name: str) -> type[Effect]:
    """The effect with an ID. Raises ModelError naming those that exist."""
    try:
        return registry()[name]
    except KeyError:
        raise ModelError(f"unknown effect {name!r}: choose from {', '.join(registry())}") from None


def confused(name: str) -> dict[str, str]:
    """The effects that look much like one, as either of the two says, and the motion that separates them."""
    pairs = dict(effect(name).confused_with)
    for other in registry().values():
        for one, motion in other.confused_with:
            if one == name:
                pairs.setdefault(other.id, motion)
    return pairs


def imitated(kind: str, stages: Collection[str] = ()) -> tuple[str, ...]:
    """The effects that something which clocks or sensors do looks like, in some stages if any are given;
    those without a name last.
    """
    those = [effect for effect in registry().values() if kind in effect.imitated_by]
    those = [effect for effect in those if not stages or effect.stage in stages]
    return tuple(effect.id for effect in sorted(those, key=lambda effect: not effect.named))


def _modules() -> Iterator[ModuleType]:
    for _, name, _ in pkgutil.walk_packages(__path__, __name__ + "."):
        yield importlib.import_module(name)
    for point in entry_points(group=GROUP):
        yield _of_package(point)
    for folder in filter(None, os.environ.get("TRUNK_ROS_EFFECTS", "").split(os.pathsep)):
        if not Path(folder).is_dir():
            raise ModelError(f"TRUNK_ROS_EFFECTS names {folder}, which is not a folder")
        for path in sorted(Path(folder).glob("*.py")):
            yield _load(path)


def _of_package(point: EntryPoint) -> ModuleType:
    """The module of another package: the entry point names it, or an effect in it."""
    try:
        return importlib.import_module(point.module)
    except Exception as error:
        why = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise ModelError(f"cannot load the effect {point.name} of {point.module}: {why}") from error


def _load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"trunk_ros_effect_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ModelError(f"cannot load an effect from {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where Python looks for what the file says of itself
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[spec.name]
        raise ModelError(
            f"cannot load an effect from {path}: {type(error).__name__}: {' '.join(str(error).split())}"
        ) from error
    return module


__all__ = ["Effect", "confused", "effect", "imitated", "registry"]
