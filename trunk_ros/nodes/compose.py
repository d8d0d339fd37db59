"""compose: several nodes in one process, on one executor. They share its memory, and one signal ends all."""

from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING

from trunk_ros.console.arguments import did_you_mean
from trunk_ros.errors import ArgumentError
from trunk_ros.nodes.parameters import PARAMETERS

if TYPE_CHECKING:
    from trunk_ros.nodes.graph.base import TrunkNode

NODES = tuple(PARAMETERS)
USAGE = f"""{__doc__}

usage: compose NODE NODE ... [--ros-args [--params-file FILE] [-p [NODE:]NAME:=VALUE] [-r __ns:=/SPACE] ...]

  NODE is one of {", ".join(NODES)}.
  A parameter is for all of them, or with NODE: in front for one; so are remappings. Files have nodes' names.

example: compose servo_driver wire_elasticity compensator --ros-args -p compensator:model:=found.yaml"""


def kind_of(name: str) -> type[TrunkNode]:
    """The class of a node. Raises ArgumentError where there is none of that name."""
    if name not in NODES:
        near = did_you_mean(name, NODES)
        raise ArgumentError(f"compose: no node {name!r}{near or ': choose from ' + ', '.join(NODES)}")
    module = import_module(f"trunk_ros.nodes.{name}")
    return next(each for each in vars(module).values() if getattr(each, "NAME", None) == name)


def main(argv: list[str]) -> int:
    """Run the nodes until they are asked to end."""
    end = argv.index("--ros-args") if "--ros-args" in argv else len(argv)
    names = argv[:end]
    if {"-h", "--help"} & set(argv):
        print(USAGE)
        return 0
    if not names:
        raise ArgumentError(f"compose: name the nodes: {', '.join(NODES)}")
    if len(set(names)) < len(names):
        raise ArgumentError("compose: each node once: a second one would have the same name")
    from trunk_ros.nodes.graph.process import run_nodes

    names.sort(key=lambda name: name == "recorder")  # which ends last, with all that the others said
    own, common = split(names, argv[end:])
    return run_nodes([partial(kind_of(name), cli_args=own[name]) for name in names], common)


def split(names: list[str], argv: list[str]) -> tuple[dict[str, list[str]], list[str]]:
    """The ROS arguments of each node, and those of all: ``-p NODE:NAME:=VALUE`` is the node's whatever its
    namespace, for which rcl takes a file alone.
    """
    own: dict[str, list[str]] = {name: [] for name in names}
    common: list[str] = []
    for flag, word in zip(["", *argv], argv, strict=False):
        node, _, rule = word.partition(":")
        if flag in ("-p", "--param") and node in own and ":=" in rule:
            common.pop()
            own[node] += ["--ros-args", flag, rule]
        else:
            common.append(word)
    return own, common
