"""ROS 2 parameter files that hold a model."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from trunk_ros.arm.parameters import shortened
from trunk_ros.errors import ModelError
from trunk_ros.recording import plain_yaml
from trunk_ros.share import share_folder


def read_parameters(path: Path) -> dict[str, Any]:
    """The parameters of a file, flat. Raises ModelError where it is none."""
    try:
        content = plain_yaml.load(path.read_bytes(), references=False)
    except OSError as error:
        raise ModelError(f"cannot read the model {path}: {error.strerror}") from None
    except ValueError as error:
        raise ModelError(f"{path} {error}") from None
    try:
        return dict(_flatten(_tree(content)))
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from None


def write_parameters(flat: Mapping[str, Any], path: Path) -> None:
    """Write flat parameters as a file for all nodes."""
    tree: dict[str, Any] = {}
    for key, value in flat.items():
        branch = tree
        *parents, leaf = key.split(".")
        for parent in parents:
            branch = branch.setdefault(parent, {})
        branch[leaf] = value
    text = yaml.safe_dump(
        {"/**": {"ros__parameters": tree}}, sort_keys=False, default_flow_style=None, width=120
    )
    path.write_text(text)


def model_path(name: str | Path) -> Path:
    """The file of a model, or of a name in config/. Raises ModelError for an unknown name."""
    path = Path(name)
    alone = len(path.parts) == 1 and path.suffix != ".yaml"
    if os.path.isfile(path) or not (alone or os.path.isdir(path)):  # False, whatever the name
        return path
    known = {file.stem: file for file in sorted((share_folder() / "config").glob("*.yaml"))}
    if str(name) not in known and os.path.isdir(path):
        raise ModelError(f"{shortened(str(name))} is a folder: give the file, such as {path / 'model.yaml'}")
    if str(name) not in known:
        raise ModelError(f"no model {shortened(str(name))}: give a file or one of {', '.join(known)}")
    return known[str(name)]


def _tree(content: Any) -> dict[str, Any]:
    """The parameters under '/**', or under the only node there is."""
    nodes = content if isinstance(content, dict) else {}
    node = nodes.get("/**") or next(iter(nodes.values()), None)
    tree = node.get("ros__parameters") if isinstance(node, dict) else None
    if not isinstance(tree, dict):
        raise ModelError("not a ROS 2 parameter file: it wants '/**: ros__parameters:' at the top")
    return {key: value for key, value in tree.items() if key != "use_sim_time"}


def _flatten(tree: Any, prefix: str = "") -> list[tuple[str, Any]]:
    if not isinstance(tree, dict):
        return [(prefix, tree)]
    return [
        pair
        for key, value in tree.items()
        for pair in _flatten(value, f"{prefix}.{key}" if prefix else str(key))
    ]
