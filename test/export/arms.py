"""Small arms in the formats of other simulators."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.model import Model

JOINTS = ("shoulder", "elbow")
KP, KV = 100.0, 2.0
MJCF = """<mujoco><compiler angle="radian"/>
<option timestep="0.001" integrator="implicitfast" gravity="-9.81 0 0"/>
<worldbody><body name="upper" pos="0 0 0.1"><joint name="shoulder" axis="1 0 0" range="-2 2" armature="0.01"/>
<geom type="capsule" size="0.01" fromto="0 0 0 0 0 0.2" mass="0.2" contype="0"/>
<body name="lower" pos="0 0 0.2"><joint name="elbow" axis="1 0 0" armature="0.01"/>
<geom type="capsule" size="0.01" fromto="0 0 0 0 0 0.15" mass="0.1" contype="0"/>
<site name="tip" pos="0 0 0.15"/></body></body></worldbody>
<actuator>{drives}</actuator>
<sensor><jointpos name="s" joint="shoulder"/><jointpos name="e" joint="elbow"/></sensor></mujoco>"""
SERVOS = "".join(f'<position joint="{name}" kp="{KP}" kv="{KV}"/>' for name in JOINTS)
MOTORS = "".join(f'<motor joint="{name}"/>' for name in JOINTS)
URDF = """<robot name="arm"><!-- mine --><link name="base"/><link name="upper"/><link name="lower"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
<axis xyz="1 0 0"/><limit lower="-2" upper="2" velocity="3" effort="5"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0 0.2" rpy="0 0 0"/><axis xyz="1 0 0"/>
<limit lower="-2" upper="2" velocity="3" effort="5"/></joint>
<transmission name="t"><joint name="elbow"/><actuator name="m"><mechanicalReduction>50</mechanicalReduction>
</actuator></transmission></robot>"""
SDF = """<sdf version="1.9"><model name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
<joint name="shoulder" type="revolute"><parent>base</parent><child>upper</child><axis><xyz>1 0 0</xyz>
<limit><lower>-2</lower><upper>2</upper></limit></axis></joint>
<joint name="elbow" type="revolute"><parent>upper</parent><child>lower</child><axis><xyz>1 0 0</xyz>
<dynamics><damping>0.1</damping></dynamics></axis></joint>
<plugin filename="gz-sim-joint-position-controller-system" name="gz::sim::systems::JointPositionController">
<joint_name>elbow</joint_name><p_gain>50</p_gain><d_gain>1</d_gain></plugin></model></sdf>"""


def model_of(effects: dict[str, dict[str, Any]]) -> Model:
    """An arm of two joints, whose transmission is meant to be ideal."""
    two = np.ones(2)
    arm = Arm(JOINTS, two, 0.0 * two, -3.0 * two, 3.0 * two, np.array([0.2, 0.15]), np.empty(0), np.empty(0))
    return Model(arm, effects)


def pair(shoulder: float = 0.0, elbow: float = 0.0) -> np.ndarray:
    """A value for each joint."""
    return np.array([shoulder, elbow])
