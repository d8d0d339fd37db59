"""wire_elasticity over DDS: what it says of the joints, the wires and the tip at one stamp."""

import itertools
from dataclasses import replace

import numpy as np

from test.nodes.graph import JOINTS, needs_ros, running, seconds
from trunk_ros.chain import Chain
from trunk_ros.model import load_model, save_model

pytestmark = needs_ros

DELAY, ZERO = 0.05, 0.01
START = 1_700_000_000 * 10**9
END = 1_700_000_000.585  # s, before the last sample


def test_late_joint_readings_make_neither_tip_nor_load_nor_wires_late(domain, peer, tmp_path):
    from trunk_ros.nodes.graph.messages import joint_state
    from trunk_ros.nodes.graph.ros import JointState, PoseStamped

    nominal = load_model("trunk")
    effects = {"sensor_delay": {"delay": DELAY}, "zero_offset": {"offset": np.full(5, ZERO)}}
    save_model(replace(nominal, effects=effects), tmp_path / "plant.yaml")
    stamp = np.arange(60) * 0.01
    phi = 0.3 * np.sin(6 * stamp)[:, None] * np.linspace(0.5, 1.0, 5)
    driven, _ = Chain(nominal, "wire").run(phi, stamp)
    true, late = driven + ZERO, round(DELAY * 100)

    gearbox = peer.publisher(JointState, "trunk/gearbox_states")
    shown, wires = peer.listen(JointState, "joint_states"), peer.listen(JointState, "trunk/wire_states")
    tips = peer.listen(PoseStamped, "trunk/tip_pose")
    with running("wire_elasticity", "--ros-args", "-p", f"model:={tmp_path / 'plant.yaml'}", domain=domain):
        peer.meets(gearbox, node="wire_elasticity")
        before = itertools.count(START - 10**9, 10**7)
        peer.answered(
            lambda: gearbox.publish(joint_state(next(before), JOINTS, phi[0])),
            lambda: shown and wires and tips,
        )
        for at, angles in zip(stamp, phi, strict=True):
            gearbox.publish(joint_state(START + round(at * 1e9), JOINTS, angles))
        peer.until(lambda: all(seconds(kept[-1].header.stamp) >= END for kept in (shown, wires, tips)))

    shown, wires, tips = (kept[-len(stamp) :] for kept in (shown, wires, tips))
    np.testing.assert_allclose([m.position for m in shown[late:]], true[:-late], atol=1e-9)
    place = [(m.pose.position.y, m.pose.position.z) for m in tips]
    heading = np.cumsum(true, axis=1)
    reach = 0.05 * np.stack([-np.sin(heading).sum(axis=1), np.cos(heading).sum(axis=1)], axis=1)
    np.testing.assert_allclose(place, reach, atol=1e-9)
    np.testing.assert_allclose([m.effort for m in shown], -nominal.arm.load(true), atol=1e-9)
    arm = nominal.arm
    stretch = arm.wire.cylinder_radius * (arm.ratio * phi - driven)
    np.testing.assert_allclose([m.position for m in wires], stretch, atol=1e-12)
