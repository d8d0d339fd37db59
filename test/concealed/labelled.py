"""Reads the labels of recordings that came with the project into the form of truth.json."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from test.concealed.hidden import DEPENDS_ON, REGIME


def _told(label: dict[str, Any]) -> dict[str, Any]:
    joints = [f"joint_{n}" for n in label["joints"]]
    each: dict[str, dict[str, Any]] = {name: {} for name in joints}
    shared: dict[str, Any] = {}
    for key, value in label["parameters"].items():
        one_joint = len(joints) == 1 and label["effect"] not in ("joint_coupling",)
        if isinstance(value, list) or (one_joint and key not in ("time_constant", "damping", "source")):
            values = value if isinstance(value, list) else [value]
            for name, one in zip(joints, values, strict=True):
                each[name][key] = one
        else:
            shared[key] = value
    parameters = {k: v for k, v in {**each, "arm": shared}.items() if v}
    return {
        "effect": label["effect"], "stage": label["stage"], "regime": label["regime"], "joints": joints,
        "parameters": parameters, "same": list(label["parameters"]), "known": label["effect"] in REGIME
        and not label["effect"].startswith("x_"), "depends_on": DEPENDS_ON.get(label["effect"], ""),
    }  # fmt: skip


def labelled_truth(folder: Path) -> dict[str, dict[str, Any]]:
    """Contents of truth.json by name of the recording, from folder/labels.json."""
    labels = json.loads((folder / "labels.json").read_text())
    return {
        one["name"]: {
            "truth": [_told(t) for t in one["truth"]],
            "known": one["known"],
            "noise": {"noise": one["noise_rad"]},
            "train": one["train"],
            "test": one["test"],
        }
        for one in labels
    }
