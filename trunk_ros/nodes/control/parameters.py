"""What the parameters of the compensator say of its control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from trunk_ros.nodes.control import slow_feedback
from trunk_ros.nodes.parameters import FEEDBACK


@dataclass(frozen=True)
class Settings:
    """How to control: see the node's parameters. rad, rad/s^2, s."""

    reversal: float
    max_acceleration: float
    patience: float
    open_loop: bool
    lead: bool
    feedback: slow_feedback.Settings


def settings_of(node: Any) -> Settings:
    """What the parameters say of the control."""
    names = ("reversal", "max_acceleration", "patience", "open_loop", "lead")
    feedback = slow_feedback.Settings(*[node.value(each.name) for each in FEEDBACK])
    return Settings(**{name: node.value(name) for name in names}, feedback=feedback)
