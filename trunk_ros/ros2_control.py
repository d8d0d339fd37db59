"""The arm as hardware of ros2_control: URDF with the tag that topic_based_ros2_control reads.

Its plugin publishes what controllers command on a topic, and takes states from another: here the
compensator's ``trunk/reference`` and the arm's ``joint_states``.
"""

from __future__ import annotations

import sys
from xml.etree import ElementTree
from xml.etree.ElementTree import SubElement

from trunk_ros.arm import Arm
from trunk_ros.arm.urdf import urdf
from trunk_ros.errors import TrunkError
from trunk_ros.model import load_model

PLUGIN = "topic_based_ros2_control/TopicBasedSystem"
COMMANDS, STATES = "trunk/reference", "joint_states"
QUIET = 1e-4  # rad by which commands and states have to differ in sum for the plugin to speak


def urdf_with_hardware(arm: Arm, namespace: str = "", start: float = 0.0) -> str:
    """URDF text of the arm with its hardware interface; the plugin's topics are absolute.

    ``start`` [rad]: where the joints stand when the hardware becomes active: the plugin asks for that before
    a controller does. Raises ModelError for a model of any joints.
    """
    robot = ElementTree.fromstring(urdf(arm))
    system = SubElement(robot, "ros2_control", name="trunk", type="system")
    hardware = SubElement(system, "hardware")
    SubElement(hardware, "plugin").text = PLUGIN
    prefix = f"/{namespace.strip('/')}/" if namespace.strip("/") else "/"
    values = {"joint_commands_topic": prefix + COMMANDS, "joint_states_topic": prefix + STATES}
    for name, value in (values | {"trigger_joint_command_threshold": f"{QUIET:g}"}).items():
        SubElement(hardware, "param", name=name).text = value
    for joint in arm.joints:
        here = SubElement(system, "joint", name=joint)
        SubElement(here, "command_interface", name="position")
        position = SubElement(here, "state_interface", name="position")
        SubElement(position, "param", name="initial_value").text = f"{start:g}"
        SubElement(here, "state_interface", name="velocity")
    ElementTree.indent(robot)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding="unicode") + "\n"


def main(argv: list[str] | None = None) -> int:
    """Print it: ``python -m trunk_ros.ros2_control [MODEL [NAMESPACE]]``, by default the nominal arm."""
    given = sys.argv[1:] if argv is None else argv
    try:
        arm = load_model(given[0] if given else "trunk").arm
        print(urdf_with_hardware(arm, given[1] if given[1:] else ""), end="")
    except TrunkError as error:
        print(f"ros2_control: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
