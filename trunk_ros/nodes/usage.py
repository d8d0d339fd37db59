"""What ``--help`` says of a node, without importing it: ROS and the model take long."""

from __future__ import annotations

import ast
from pathlib import Path

from trunk_ros.nodes.parameters import COMMON, MODEL, PARAMETERS
from trunk_ros.parameter import Declaration


def usage(name: str) -> str:
    """What a node does, and its own parameters."""
    declared = (*COMMON, *PARAMETERS[name])
    wide = max(len(each.name) for each in declared) + 1
    return "\n".join(
        [
            purpose(name),
            "",
            f"usage: {name} [--ros-args [--params-file FILE] [-p NAME:=VALUE] ...]",
            "",
            *(line(declaration, wide) for declaration in declared),
            *(["  and every parameter of a model file"] if MODEL in declared else []),
        ]
    )


def purpose(name: str) -> str:
    """The docstring of a node's file."""
    source = Path(__file__).with_name(f"{name}.py").read_text(encoding="utf-8")
    return ast.get_docstring(ast.parse(source)) or name


def line(declaration: Declaration, wide: int) -> str:
    """A parameter with its bounds and default, its name in a column so ``wide``."""
    bounds = f", {declaration.range}" if declaration.range else ""
    return f"  {declaration.name:{wide}}{declaration.description}{bounds}; default {declaration.default!r}"
