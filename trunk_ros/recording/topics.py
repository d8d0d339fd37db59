"""The topics of an arm, their types, and how they are found in a recording that carries a namespace."""

JOINT_STATE = "sensor_msgs/msg/JointState"
POSE = "geometry_msgs/msg/PoseStamped"

JOINT_TOPICS = {
    "reference": "trunk/reference",
    "setpoints": "trunk/setpoints",
    "gearbox_states": "trunk/gearbox_states",
    "joint_states": "joint_states",
    "wire_states": "trunk/wire_states",
}
TIP = "tip_pose"
TIP_TOPIC = "trunk/tip_pose"
DESCRIPTION_TOPIC = "robot_description"
STRING = "std_msgs/msg/String"
TOPICS = {**JOINT_TOPICS, TIP: TIP_TOPIC}
COMPARED = {
    "servo": ("setpoints", "gearbox_states"),
    "wire": ("gearbox_states", "joint_states"),
    "arm": ("joint_states", TIP),
}
"""What drives each stage of an arm, and what it shows, in the order of the signal."""
SHOWN = ("gearbox_states", "joint_states", TIP)  # what was measured of an arm
OURS = "trunk"  # the folder of topics that nodes of ours publish besides
SOURCES = ("gearbox_states", "setpoints")  # what a model can be driven by


def split_topic(topic: str) -> tuple[str, str] | None:
    """(namespace, key) of a topic that describes an arm: `/a/trunk/setpoints` is ("/a", "setpoints")."""
    for key, name in TOPICS.items():
        if topic == name or topic.endswith("/" + name):
            return topic[: -len(name)].rstrip("/"), key
    return None


def is_description(topic: str) -> bool:
    """Whether a topic holds a URDF."""
    return topic.rpartition("/")[2] == DESCRIPTION_TOPIC


def expected_type(key: str) -> str:
    """Message type of the topic with this key."""
    return POSE if key == TIP else JOINT_STATE
