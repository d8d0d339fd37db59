"""The layout in which Foxglove and Lichtblick show a scene's MCAP file."""

from __future__ import annotations

from typing import Any, TypeAlias

from trunk_ros.show.ghosts import GHOSTS
from trunk_ros.show.scene import Scene

COLOURS = {"measured": "#eb9628", "nominal": "#8a939d", "fitted": "#3ca5d7"}
JOINT_COLOURS = ("#4e98e2", "#f5774d", "#f7df71", "#5cd6a9", "#a395e2", "#e07ab0", "#8a939d")
WORLD = "world"
NEVER = "–"  # where a regime does not hold
REACH = 0.5  # m of an arm of which it is not known

Panels: TypeAlias = dict[str, dict[str, Any]]


def lanes(scene: Scene) -> list[str]:
    """The topic of each of the scene's findings."""
    return [
        f"/regimes/{spell.joint}/{spell.effect.replace(' ', '_')}_{number}"
        for number, spell in enumerate(scene.spells)
    ]


def layout(scene: Scene, reach: float) -> dict[str, Any]:
    """3D and findings on the left, a tab for each joint and the lanes of the regimes on the right."""
    panels: Panels = {
        "3D!arm": _arm(reach or REACH),
        "Markdown!findings": {"markdown": scene.statement},
        "Tab!joints": {"activeTabIdx": 0, "tabs": [{"title": "all residuals", "layout": "Plot!residuals"}]},
        "Plot!residuals": _plot(
            "Residuals, fitted, in thousandths of rad or m",
            [
                _path(f"/residuals/fitted.position[{c}]", joint, JOINT_COLOURS[c % len(JOINT_COLOURS)])
                for c, joint in enumerate(scene.joints)
            ],
        ),
    }
    for c, joint in enumerate(scene.joints):
        panels |= _joint(scene, c, joint)
        below = {"first": f"Plot!{joint}", "second": f"Plot!{joint} residual", "direction": "column"}
        panels["Tab!joints"]["tabs"].append({"title": joint, "layout": below})
    right: Any = "Tab!joints"
    if scene.spells:
        panels["StateTransitions!regimes"] = _regimes(scene)
        right = _split("Tab!joints", "StateTransitions!regimes", "column", 75)
    left = _split("3D!arm", "Markdown!findings", "column", 70)
    return {
        "configById": panels, "globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1},
        "layout": _split(left, right, "row", 40),
    }  # fmt: skip


def _split(first: Any, second: Any, direction: str, share: int) -> dict[str, Any]:
    return {"first": first, "second": second, "direction": direction, "splitPercentage": share}


def _arm(reach: float) -> dict[str, Any]:
    """Three arms in one 3D view, each by its own URDF and frames."""
    layers = {
        kind: {
            "layerId": "foxglove.Urdf", "instanceId": kind, "label": kind, "visible": True, "order": order,
            "sourceType": "topic", "topic": f"/{kind}/robot_description", "framePrefix": f"{kind}/",
            "displayMode": "visual",
        }
        for order, kind in enumerate(GHOSTS)
    }  # fmt: skip
    grid = {
        "layerId": "foxglove.Grid", "instanceId": "grid", "label": "Grid", "visible": True, "size": 1,
        "divisions": 10, "lineWidth": 1, "color": "#8080808c", "order": len(layers),
    }  # fmt: skip
    camera = {
        "perspective": True, "distance": 2.5 * reach, "phi": 75, "thetaOffset": 60, "target": [0, 0, 0],
        "targetOffset": [0, 0, 0.5 * reach], "targetOrientation": [0, 0, 0, 1], "fovy": 45,
        "near": 0.01, "far": 100,
    }  # fmt: skip
    return {
        "followTf": WORLD, "followMode": "follow-none", "cameraState": camera,
        "layers": {"grid": grid, **layers}, "topics": {}, "transforms": {},
        "scene": {"transforms": {"visible": False, "showLabel": False}},
    }  # fmt: skip


def _joint(scene: Scene, column: int, joint: str) -> Panels:
    """A joint's angles and what they leave."""
    unit = scene.units[joint]
    angles = [_path(f"/{kind}/joint_states.position[{column}]", kind, COLOURS[kind]) for kind in GHOSTS]
    left = [
        _path(f"/residuals/{kind}.position[{column}]", kind, COLOURS[kind]) for kind in ("nominal", "fitted")
    ]
    return {
        f"Plot!{joint}": _plot(f"{joint}: {unit}", angles),
        f"Plot!{joint} residual": _plot(f"{joint}: residual, m{unit}", left),
    }


def _regimes(scene: Scene) -> dict[str, Any]:
    paths = [
        {
            "value": f"{topic}.data",
            "label": f"{spell.joint}: {spell.effect}",
            "timestampMethod": "receiveTime",
        }
        for spell, topic in zip(scene.spells, lanes(scene), strict=True)
    ]  # fmt: skip
    return {"isSynced": True, "paths": paths}


def _plot(title: str, paths: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "title": title, "paths": paths, "showLegend": True, "legendDisplay": "floating", "isSynced": True,
        "xAxisVal": "timestamp", "showXAxisLabels": True, "showYAxisLabels": True,
    }  # fmt: skip


def _path(value: str, label: str, colour: str) -> dict[str, Any]:
    return {
        "value": value, "label": label, "color": colour, "enabled": True, "timestampMethod": "headerStamp",
        "showLine": True, "lineSize": 1.2,
    }  # fmt: skip
