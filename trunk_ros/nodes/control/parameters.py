"""What the parameters of the compensator say of its control."""

from __future__ import annotations

from typing import Any

from trunk_ros.nodes.control import slow_feedback
from trunk_ros.nodes.control.controller import Settings
from trunk_ros.nodes.parameters import FEEDBACK


def settings_of(node: Any) -> Settings:
    """What the parameters say of the control."""
    names = ("reversal", "max_acceleration", "patience", "lead")
    feedback = slow_feedback.Settings(*[node.value(each.name) for each in FEEDBACK])
    return Settings(**{name: node.value(name) for name in names}, feedback=feedback)
