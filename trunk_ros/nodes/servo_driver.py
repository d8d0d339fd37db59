"""servo_driver: setpoints in, state of the gearbox shafts out; the motors sit behind a bus."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.model import Declaration
from trunk_ros.nodes.bus import SIMULATED, Bus, bus_of, gearbox_limits, within
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.elapsed import Elapsed
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.ros import JointState
from trunk_ros.trajectory import Array

ROUNDING = 1e-9  # rad


class ServoDriver(TrunkNode):
    """Refuses setpoints outside the limits, holding the last safe one; holds as well when they dry up."""

    NAME = "servo_driver"
    OWN = (
        Declaration(
            "timeout",
            0.5,
            "s",
            (0.01, 60.0),
            "silence after which the setpoints are called stale; the arm holds",
        ),
        Declaration("bus", SIMULATED, "", None, "the motors: simulated, or MODULE:CLASS of another bus"),
    )

    def configure(self) -> None:
        """Open the bus and the streams."""
        arm = self.model.arm
        self.joints = arm.motor_names
        self.matcher = JointMatcher(self.joints)
        self.lower, self.upper = gearbox_limits(arm)
        self.bus: Bus = bus_of(self.value("bus"), self.model)
        self.everyone = np.ones(len(arm.joints), dtype=bool)
        self.asked: Array | None = None
        self.shaft: Array | None = None
        self.elapsed = Elapsed()
        self.setpoints = self.watch("trunk/setpoints", self.value("timeout"))
        self.publish_state = self.joint_states_on("trunk/gearbox_states", self.joints)
        self.listen_to(JointState, "trunk/setpoints", self.on_setpoints)

    def tick(self, now: int) -> None:
        """Read the shafts and publish."""
        sample = self.bus.read(self.elapsed.at(now))
        self.shaft = sample.position
        self.publish_state(now, sample.position, sample.velocity, sample.effort)

    def on_setpoints(self, message: Any) -> None:
        """Check a setpoint and hand it on. Raises MessageError where it is refused."""
        stamp = self.arrived(self.setpoints, message)
        given = self.matcher.gather(message.name, message.position)
        for oddity in self.matcher.oddities():
            self.health.note(oddity)
        named = self._given(given, message)
        setpoint = given if named.all() else np.where(named, given, self.last_setpoint())
        self.check(setpoint)
        self.asked = setpoint
        self.bus.write(setpoint, self.elapsed.of(stamp))

    def _given(self, given: Array, message: Any) -> Any:
        """Which joints the message speaks of. Raises MessageError for a value that is no number."""
        if not self.matcher.missing and np.isfinite(given).all():
            return self.everyone
        named = np.array([joint not in self.matcher.missing for joint in self.joints]) & (
            len(message.position) > 0
        )
        if not np.isfinite(given[named]).all():
            raise MessageError(
                f"setpoint refused: {self.joints[np.argmax(named & ~np.isfinite(given))]} is not a number"
            )
        return named

    def last_setpoint(self) -> Array:
        """What joints that a setpoint leaves out are held at. Raises MessageError while that is not known."""
        last = self.shaft if self.asked is None else self.asked
        if last is None:
            raise MessageError("setpoint refused: where the joints stand that it leaves out is not known yet")
        return last

    def check(self, setpoint: Array) -> None:
        """Raise MessageError for a setpoint (joints,) rad outside the limits."""
        out = ~((setpoint >= self.lower - ROUNDING) & (setpoint <= self.upper + ROUNDING))
        if out.any():
            j = int(np.argmax(out))
            raise MessageError(
                f"setpoint refused: {self.joints[j]} at {setpoint[j]:.4f} rad is outside "
                f"{self.lower[j]:.4f} ... {self.upper[j]:.4f}; holding the last safe one"
            )
        over = np.abs(within(setpoint, self.model.arm) - setpoint) > ROUNDING
        if over.any():
            j = int(np.argmax(over))
            raise MessageError(
                f"setpoint refused: {self.joints[j]} at {setpoint[j]:.4f} rad would move a joint outside its "
                "limits; holding the last safe one"
            )

    def release(self) -> None:
        """Close the bus."""
        if hasattr(self, "bus"):
            self.bus.close()


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(ServoDriver, argv)
