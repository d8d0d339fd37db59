"""Diagnoses made by hand, for what is said of them: nothing is fitted here."""

from dataclasses import replace
from typing import Any
from unittest.mock import patch

import numpy as np
from matplotlib.figure import Figure

from trunk_ros.chain import Chain
from trunk_ros.diagnosis.report import render
from trunk_ros.diagnosis.verdict.answer import Answer
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.model import load_model

NOISE = 1e-4  # rad
JOINTS = tuple(f"joint_{k}" for k in range(1, 6))


def page_of(result: Answer) -> str:
    """The page of a diagnosis without its pictures, for what it says: they take most of the time."""
    with patch.object(Figure, "savefig"):
        return render(result)


def finding(effect: str, joints: list[str], parameters: dict[str, Any], **other: Any) -> Finding:
    """A finding in the wire; ``parameters`` as in diagnosis.json."""
    said = {
        "regime": "posture", "confidence": 0.9, "equivalents": [], "depends_on": ["position"],
        "statement": f"{', '.join(joints)}: something is off.", "stage": "wire",
        "evidence": {"strength": 5.0, "gain": dict.fromkeys(joints, 1e4), "rivals": {}},
        **other,
    }  # fmt: skip
    return Finding(effect, joints=joints, parameters=parameters, **said)


def diagnosis(
    effects: dict[str, Any], findings: list[Finding], joints: tuple[str, ...] = JOINTS, seconds: float = 60.0
) -> Diagnosis:
    """What would be said of a five-joint arm with these effects; their findings are given."""
    nominal = load_model("trunk")
    nominal = replace(nominal, arm=replace(nominal.arm, joints=joints))
    model = replace(nominal, effects=effects)
    stamp = np.arange(0.0, seconds, 0.01)
    rate = np.array([0.31, 0.23, 0.41, 0.17, 0.29])
    gearbox = 0.6 * np.sin(rate * stamp[:, None] + np.arange(5))
    velocity = 0.6 * rate * np.cos(rate * stamp[:, None] + np.arange(5))
    before, after = (Chain(m, "wire").run(gearbox, stamp, None, velocity)[0] for m in (nominal, model))
    measured = after + NOISE * np.random.default_rng(1).standard_normal(after.shape)
    plots: dict[tuple[str, str], dict[str, Any]] = {}
    said = {}
    for c, joint in enumerate(joints):
        plots["wire", joint] = {
            "stamp": stamp, "measured": measured[:, c], "valid": stamp > 2.0,
            "error_before": (measured - before)[:, c], "error_after": (measured - after)[:, c],
            "gearbox": gearbox[:, c], "velocity": velocity[:, c], "noise": NOISE,
        }  # fmt: skip
        errors = [float(np.sqrt(np.mean((measured - y)[:, c] ** 2))) for y in (before, after)]
        said[joint] = {
            "unit": "rad", "rmse_before": errors[0], "rmse_after": errors[1], "noise_floor": NOISE,
            "rmse_before_std": 0.1 * errors[0], "rmse_after_std": 0.01 * errors[1],
        }  # fmt: skip
    stages = {
        "servo": {"compared": False, "joints": {}},
        "wire": {"compared": True, "joints": said, "silent": []},
        "arm": {"compared": False, "tip": {}},
    }
    topic = {"samples": len(stamp), "period": 0.01, "jitter": 0.0, "longest_gap": 0.4, "gap_at": 12.0,
             "gaps": 1, "lost": 39, "duplicates": 3}  # fmt: skip
    quality = {
        "run1": {"duration": seconds, "topics": {"joint_states": topic}, "notes": ["The end is cut off."]}
    }
    provenance = {"command": "trunk_ros diagnose run1 --output out", "bags": ["run1"]}
    return Diagnosis(stages, findings, [], [], model, quality, provenance, plots)


def value(number: float, std: float | None = None, unit: str = "rad") -> dict[str, Any]:
    """A parameter's value as in diagnosis.json."""
    return {"value": number, "std": std, "unit": unit}


def backlash(joint: str = "joint_3", others: tuple[str, ...] = JOINTS) -> Diagnosis:
    """One joint with a dead band 1 mrad wider than nominal."""
    width = np.where(np.array(others) == joint, 1e-3, 0.0)
    found = finding("backlash", [joint], {joint: {"half_width": value(1e-3, 2.3e-6)}}, regime="reversal",
                    depends_on=["direction"])  # fmt: skip
    return diagnosis({"backlash": {"half_width": width}}, [found], others)
