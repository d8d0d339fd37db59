"""Node parameters: the model's, from its one place of declaration, and a few of each node's own."""

from __future__ import annotations

import difflib
import math
from typing import Any

from trunk_ros.arm.parameters import ANY_JOINTS
from trunk_ros.errors import TrunkError
from trunk_ros.model import Declaration, Model, declared_parameters, load_model
from trunk_ros.nodes.graph.ros import FloatingPointRange, ParameterDescriptor, ParameterException

MODEL = Declaration(
    "model",
    "trunk",
    "",
    None,
    "model file, or a name in config/, for what no parameter says; may be set at run time",
)


def declare(node: Any, declaration: Declaration, default: Any = None) -> Any:
    """Declare one parameter with unit, bounds and description; returns its value. Raises TrunkError."""
    value = declaration.default if default is None else default
    try:
        return node.declare_parameter(declaration.name, value, descriptor(declaration)).value
    except ParameterException as error:
        raise TrunkError(
            f"{node.get_name()}: parameter {declaration.name}: {' '.join(str(error).split())}"
        ) from None


def descriptor(declaration: Declaration) -> Any:
    """Description as ``ros2 param describe`` shows it; rclpy itself refuses scalars out of bounds."""
    text = declaration.meaning + (f" [{declaration.unit}]" if declaration.unit else "")
    described = ParameterDescriptor(description=text, dynamic_typing=declaration.free)
    if declaration.bounds is None:
        return described
    low, high = (float(bound) for bound in declaration.bounds)
    described.additional_constraints = f"{low:g} to {high:g} {declaration.unit}".strip()
    if isinstance(declaration.default, float) and not declaration.free and math.isfinite(declaration.default):
        described.floating_point_range = [FloatingPointRange(from_value=low, to_value=high, step=0.0)]
    return described


def declare_model(node: Any) -> Model:
    """Declare every model parameter and return the model.

    A parameter file that names joints is a complete model; else ``model`` is. Raises TrunkError.
    """
    name = declare(node, MODEL)
    declared = {d.name: d for d in declared_parameters()}
    joints = declare(node, declared.pop("arm.joints"))
    base: dict[str, Any] = {}
    if list(joints) == [ANY_JOINTS] and not declare(node, declared.pop("arm.urdf")):
        base = load_model(name).parameters()
        own: dict[str, Any] = {name: base[name] for name in ("arm.joints", "arm.urdf") if name in base}
        set_quietly(node, own)
    for d in declared.values():
        declare(node, d, base.get(d.name))
    return model_of(node)


def unknown(node: Any) -> list[str]:
    """A line for each parameter that the node was given and does not have; rclpy passes over them."""
    known = sorted(node._parameters)  # rclpy lists these only by prefix
    others = {d.name for d in declared_parameters()}  # a file for all nodes may hold a model
    lines = []
    for name in node._parameter_overrides:
        if name not in known and name not in others and not name.startswith("qos_overrides."):
            near = difflib.get_close_matches(name, known, 1)
            lines.append(f"unknown parameter {name!r}" + (f": did you mean {near[0]!r}?" if near else ""))
    return lines


def model_of(node: Any) -> Model:
    """The model that a node's parameters describe. Raises TrunkError."""
    model = Model.from_parameters({d.name: node.get_parameter(d.name).value for d in declared_parameters()})
    if model.any_joints:
        raise TrunkError(f"{node.get_name()}: a live node has to know its joints: name them in arm.joints")
    return model


def describe_model(node: Any, model: Model) -> None:
    """Bring the parameters into line with a model that was loaded at run time."""
    flat = {d.name: d.default for d in declared_parameters()} | model.parameters()
    set_quietly(node, flat)


def set_quietly(node: Any, values: dict[str, Any]) -> None:
    """Set parameters from inside the node. Raises TrunkError where one is refused."""
    from trunk_ros.nodes.graph.ros import Parameter

    for result in node.set_parameters([Parameter(name, value=value) for name, value in values.items()]):
        if not result.successful:
            raise TrunkError(f"{node.get_name()}: {result.reason}")
