"""Node parameters: a few of each node's own, and those of the model that it has."""

from __future__ import annotations

import difflib
import json
import math
from typing import Any

import numpy as np

from trunk_ros.arm.parameters import RENAMED
from trunk_ros.errors import ModelError, TrunkError
from trunk_ros.model import Model, declared_parameters, load_model
from trunk_ros.nodes.graph.ros import (
    FloatingPointRange,
    IntegerRange,
    Parameter,
    ParameterDescriptor,
    ParameterException,
    SetParametersResult,
)
from trunk_ros.nodes.parameters import MODEL
from trunk_ros.parameter import Declaration

FOREIGN = ("use_sim_time", "start_type_description_service")  # of rclpy itself


def declare(node: Any, declaration: Declaration, value: Any = None, fixed: bool = False) -> Any:
    """Declare one parameter with unit, bounds and description; returns its value. Raises TrunkError.

    ``value``: what it is, whatever was given to the node. ``fixed``: it holds from the start.
    """
    wanted = declaration.default if value is None else value
    described = descriptor(declaration, fixed)
    try:
        return node.declare_parameter(declaration.name, wanted, described, value is not None).value
    except ParameterException as error:
        raise TrunkError(
            f"{node.get_name()}: parameter {declaration.name}: {' '.join(str(error).split())}"
        ) from None


def descriptor(declaration: Declaration, fixed: bool = False) -> Any:
    """Description as ``ros2 param describe`` shows it; rclpy itself refuses scalars out of bounds."""
    described = ParameterDescriptor(
        description=declaration.description,
        additional_constraints=declaration.range,
        read_only=fixed or declaration.fixed,
        dynamic_typing=declaration.free,
    )
    if declaration.bounds is None:
        return described
    low, high = declaration.bounds
    if isinstance(declaration.default, int):
        described.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    elif (
        isinstance(declaration.default, float) and not declaration.free and math.isfinite(declaration.default)
    ):
        ends = {"from_value": float(low), "to_value": float(high)}
        described.floating_point_range = [FloatingPointRange(**ends, step=0.0)]
    return described


def declare_model(node: Any, fixed: bool) -> Model:
    """Declare ``model`` and the parameters of the model that the node has; returns it. Raises TrunkError.

    Given parameters that name joints or a URDF are a complete model; else they change ``model``.
    """
    name = declare(node, MODEL, fixed=fixed)
    known = {d.name for d in declared_parameters()}
    given = {RENAMED.get(key, key): each.value for key, each in node._parameter_overrides.items()}
    flat = {key: value for key, value in given.items() if key in known}
    base = {} if {"arm.joints", "arm.urdf"} & flat.keys() else load_model(name).parameters()
    model = Model.from_parameters(base | flat)
    if model.any_joints:
        raise TrunkError(f"{node.get_name()}: a live node has to know its joints: name them in arm.joints")
    show_model(node, model, fixed)
    return model


def show_model(node: Any, model: Model, fixed: bool = False) -> None:
    """Let the parameters be those of a model: declare what it has, and take away what it has not."""
    flat = model.parameters()
    for d in declared_parameters():
        if node.has_parameter(d.name) and (d.name not in flat or not same(node, d.name, flat[d.name])):
            node.undeclare_parameter(d.name)
        if d.name in flat and not node.has_parameter(d.name):
            declare(node, d, flat[d.name], fixed)


def changed_model(model: Model, changes: dict[str, Any]) -> Model | None:
    """The model with changed parameters, None where none is of a model. Raises TrunkError for bad values."""
    known = {d.name for d in declared_parameters()}
    flat = {RENAMED.get(name, name): value for name, value in changes.items()}
    own = {name: value for name, value in flat.items() if name in known}
    if not own:
        return None
    before = model.parameters()
    if cleared := [name for name, value in own.items() if value is None]:
        raise ModelError(f"{cleared[0]} cannot be deleted: give the value at which it does nothing")
    return Model.from_parameters(before | own)


def same(node: Any, name: str, value: Any) -> bool:
    """Whether a parameter has this value already; what is no number equals itself."""
    now = node.get_parameter(name).value
    if isinstance(now, str) or isinstance(value, str) or value is None or now is None:
        return bool(now == value)
    if type(now) is not type(value) and not (hasattr(now, "__len__") and hasattr(value, "__len__")):
        return False
    ours, theirs = np.asarray(now), np.asarray(value)
    if ours.shape != theirs.shape or ours.dtype.kind != theirs.dtype.kind:
        return False
    return bool(np.array_equal(ours, theirs, equal_nan=ours.dtype.kind == "f"))


def meant(node: Any, given: list[Any]) -> list[Any]:
    """Parameters without those that hold from the start and are what they are asked to be.

    ``ros2 param`` takes 5e-05 for a word, as YAML does where there is no dot: it becomes the number it is.
    """

    def fixed(name: str) -> bool:
        return bool(node.has_parameter(name) and node.describe_parameter(name).read_only)

    read = [_number(node, each) for each in given]
    return [each for each in read if not (fixed(each.name) and same(node, each.name, each.value))]


def _number(node: Any, given: Any) -> Any:
    """The parameter with a word that is a number, or a list of such, as one where it is declared so."""
    kinds = (Parameter.Type.DOUBLE, Parameter.Type.DOUBLE_ARRAY)
    if not isinstance(given.value, str) or not node.has_parameter(given.name):
        return given
    kind = node.get_parameter(given.name).type_
    if kind not in kinds:
        return given
    try:
        value = json.loads(given.value)
        numbers: Any = [float(each) for each in value] if isinstance(value, list) else float(value)
    except (TypeError, ValueError):
        return given
    return Parameter(given.name, kind, numbers)


def unknown(node: Any) -> list[str]:
    """A line for each parameter that the node was given and does not have; rclpy passes over them."""
    others = {d.name for d in declared_parameters()} | RENAMED.keys()  # a file for all nodes may hold a model
    return [
        refusal(node, name)
        for name in node._parameter_overrides
        if not node.has_parameter(name) and name not in others and not name.startswith("qos_overrides.")
    ]


def refusal(node: Any, name: str) -> str:
    """Words about a name that no parameter has."""
    known = {*node._parameters, *(d.name for d in declared_parameters())}  # rclpy lists these only by prefix
    near = difflib.get_close_matches(name, sorted(known), 1)
    return f"unknown parameter {name!r}" + (f": did you mean {near[0]!r}?" if near else "")


class Settings:
    """A node's parameters at run time: a change applies at once, or is refused with the reason."""

    def __init__(self, node: Any, declarations: tuple[Declaration, ...]):
        self.node = node
        self.own = {d.name for d in declarations} | {*FOREIGN}
        self.taken: Model | None = None  # by the change under way
        self._values: dict[str, Any] = {}
        self._describing = False
        node.add_on_set_parameters_callback(self._asked)
        node.add_post_set_parameters_callback(self._set)

    def value(self, name: str) -> Any:
        """A parameter's value."""
        if name not in self._values:
            self._values[name] = self.node.get_parameter(name).value
        return self._values[name]

    def _asked(self, parameters: list[Any]) -> Any:
        """Whether a change is taken."""
        if self._describing:
            return SetParametersResult(successful=True)
        try:
            self._check({each.name: each.value for each in parameters})
        except TrunkError as error:
            self.node.get_logger().warning(f"parameters refused: {error}")
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _check(self, changes: dict[str, Any]) -> None:
        node = self.node
        models = (
            {MODEL.name, *RENAMED, *(d.name for d in declared_parameters())} if node.needs_model else set()
        )
        for name, value in changes.items():
            if name == "use_sim_time" and value != node.simulated:
                raise TrunkError("use_sim_time holds from the start of the node")
            if name not in self.own and name not in models and not node.has_parameter(name):
                raise TrunkError(refusal(node, name))
        if models & changes.keys():
            if node.fixed_model:
                raise TrunkError("the model holds from the start of the node")
            self.taken = node.swap.changed(changes)

    def _set(self, parameters: list[Any]) -> None:
        """What was taken holds: the node hears of it, and shows all that a model has changed."""
        self._values.clear()
        if self._describing:
            return
        taken, self.taken = self.taken, None
        if taken is not None:
            self.node.use(taken)
            self._describing = True
            try:
                self._show(taken, {each.name for each in parameters})
            finally:
                self._describing = False
        self.node.changed()

    def _show(self, model: Model, names: set[str]) -> None:
        for name in names & RENAMED.keys():
            self.node.undeclare_parameter(name)
        show_model(self.node, model)
