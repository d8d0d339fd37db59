"""Effects in MuJoCo's own terms, by its MjSpec."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.effect_values import Values
from trunk_ros.effects.wire.load_elasticity import DAMPING, LoadElasticity
from trunk_ros.export.mjcf_actuator import Drive, tag_of
from trunk_ros.export.mjcf_file import STIFF, MjcfFile
from trunk_ros.export.mjcf_play import add_play
from trunk_ros.export.mjcf_swing import write_swing
from trunk_ros.export.sheet import TERMS

PAYLOAD, GRAIN = "payload", 1e-3  # m, its radius
SAGS = "payload {:.4g} kg: no mass in the file, since the servos' findings have what it does to the motors"
NO_TIP = "payload {:.4g} kg: no site is called tip, so the file has no mass there"
FREE = 1e3  # rad


class MjcfWriter(MjcfFile):
    """Writes into an MJCF file. Where a joint has a position actuator, play and compliance are said by
    friction and stiffness; under a bare motor a play is a joint of its own.
    """

    def ratio_error(self, values: Values) -> Values:
        """The actuator's gear; its stiffness about the joint stays."""

        def write(joint: str, relative: float) -> bool:
            drive = self.drives[joint]
            if drive is None:
                return False
            drive.gear(1.0 / (1.0 + relative))
            return self._told(drive, f"ratio_error {relative:+.4g}: gear")

        return self.each(values, "relative", write)

    def joint_coupling(self, values: Values) -> Values:
        """The actuator pulls a tendon over both joints in the place of the joint."""
        if values.get("form", "angle") != "angle" or any(f"gain_{k}" in values for k in (2, 3)):
            return values
        sources = dict(zip(self.joints, values.get("source", ()), strict=False))

        def write(joint: str, gain: float) -> bool:
            drive, source = self.drives[joint], sources.get(joint, "")
            if drive is None or self.spec.joint(source) is None:
                return False
            name = drive.couple(self.spec, joint, source, gain)
            self.note("fixed", name, f"joint_coupling of {joint}: {gain:.4g} of {source}")
            return True

        return self.each(values, "gain", write)

    def backlash(self, values: Values) -> Values:
        """Friction over the actuator's stiffness is a play; a motor without stiffness gets a joint that has
        play, and a bearing that holds the link within it.
        """
        return self.each(values, "half_width", self._play)

    def load_elasticity(self, values: Values) -> Values:
        """A spring in series with the actuator's: less stiffness. Where the links swing on it, it has their
        damping.
        """
        if values.get("payload") or values.get("form") == "lever":
            return self._carried(values)
        form = values.get("form", LoadElasticity.forms[0])
        swings, rubs = form in LoadElasticity.shaking and self.model.arm.has_load, form == "held"
        ratios = np.broadcast_to(values.get("damping", DAMPING.null), (len(self.joints),))

        def write(joint: str, compliance: float) -> bool:
            drive = self.drives[joint]
            if drive is None or compliance < 0.0:
                return False
            late, firm = drive.lag(self._damping(joint)), drive.stiffness
            drive.soften(compliance)
            if joint in self.half_widths:  # of the same width over less stiffness
                less = self.half_widths[joint] * (firm - drive.stiffness)
                self._rub(joint, float(self.spec.joint(joint).frictionloss) - less)
            if swings:
                self._swing(joint, drive, float(ratios[self.joints.index(joint)]), late, rubs)
            return self._told(drive, f"load_elasticity {compliance:.4g} rad/(N m): kp, kv")

        return self.each(values, "compliance", write)

    def wire_slack(self, values: Values) -> Values:
        """Left to the layer, but for the mass."""
        return self._carried(values)

    def wire_stiffening(self, values: Values) -> Values:
        """Left to the layer, but for the mass."""
        return self._carried(values)

    def load_droop(self, values: Values) -> Values:
        """The same at the setpoint."""
        if np.any(np.less(values["gain"], 0.0)) or not all(self.drives.values()):
            return values

        def write(joint: str, gain: float) -> bool:
            drive = self.drives[joint]
            assert drive is not None
            drive.soften(gain * abs(float(self.model.arm.ratio[self.joints.index(joint)])))
            return self._told(drive, f"load_droop {gain:.4g} rad/(N m): kp, kv")

        return self.each(values, "gain", write)

    def viscous_lag(self, values: Values) -> Values:
        """Damping over the actuator's stiffness; a mere delay, or a lag without inertia, is left."""
        if values.get("form", "first_order") != "first_order":
            return values

        def write(joint: str, constant: float) -> bool:
            drive = self.drives[joint]
            if drive is None:
                return False
            self._damp(joint, self._damping(joint) + constant * drive.stiffness)
            self.taken[joint, "damping"] = "viscous_lag"
            self.note("joint", joint, f"viscous_lag {constant:.4g} s: damping")
            return True

        return self.each(values, "time_constant", write)

    def hard_stop(self, values: Values) -> Values:
        """The joint's range."""
        side = 1 if values.get("form", "upper") == "upper" else 0

        def write(joint: str, end: float) -> bool:
            own = self.spec.joint(joint)
            if own is None:
                return False
            low, high = own.range if own.range[0] < own.range[1] else (-FREE, FREE)
            ends = [low, high]
            ends[side] = min(high, end) if side else max(low, end)
            own.range, own.limited = ends, True
            own.solref_limit = [2.0 * self.spec.option.timestep, 1.0]
            own.solimp_limit = list(STIFF)
            self.note("joint", joint, f"hard_stop at {end:.4g} rad: range")
            return True

        return self.each(values, ("lower", "upper")[side], write)

    def servo_delay(self, values: Values) -> Values:
        """The actuators' own delay, where this MuJoCo has it."""
        return self._late(self._actuators(), "servo_delay", values)

    def sensor_delay(self, values: Values) -> Values:
        """The delay of the joints' sensors, where all of them have one; a mean they have not."""
        if values.get("form") == "averaged":
            return values
        kind = self.mujoco.mjtSensor.mjSENS_JOINTPOS
        found = {s.objname: s for s in self.spec.sensors if s.type == kind and s.objname in self.joints}
        ready = list(found.values()) if set(found) == set(self.joints) else []
        return self._late(ready, "sensor_delay", values)

    def servo_bandwidth(self, values: Values) -> Values:
        """The actuators' gain."""
        if not all(self.drives.values()):
            return values

        def write(joint: str, more: float) -> bool:
            drive = self.drives[joint]
            assert drive is not None
            drive.strengthen(1.0 + more)
            return self._told(drive, f"servo_bandwidth {more:+.4g}: kp")

        return self.each(values, "relative", write)

    def link_length_error(self, values: Values) -> Values:
        """Where the next joint, or the tip, sits on the link."""

        def write(joint: str, longer: float) -> bool:
            own = self.spec.joint(joint)
            if own is None:
                return False
            bodies = [body for body in own.parent.bodies if body.name != PAYLOAD]
            beyond = [*bodies, *(site for site in own.parent.sites if "tip" in site.name)]
            if not beyond:
                return False
            place = beyond[0]
            length = float(np.linalg.norm(place.pos))
            if length == 0.0:
                return False
            place.pos = np.array(place.pos) * (1.0 + longer / length)
            place.name = place.name or f"{joint}_next"
            tag = "body" if bodies else "site"
            self.note(tag, place.name, f"link_length_error of {joint} {longer:+.4g} m: pos")
            return True

        return self.each(values, "length_error", write)

    def base_tilt(self, values: Values) -> Values:
        """The turn of the body that the first joint is in."""
        own = self.spec.joint(self.joints[0])
        if own is None:
            return values
        body, angle = own.parent, float(np.asarray(values["angle"]).ravel()[0])
        turned = np.zeros(4)
        turn = np.array([np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0])
        self.mujoco.mju_mulQuat(turned, turn, np.array(body.quat, dtype=float))
        body.quat = turned
        body.name = body.name or f"{own.name}_link"
        self.note("body", body.name, f"base_tilt {angle:+.4g} rad about X: quat")
        return {}

    def _play(self, joint: str, half_width: float) -> bool:
        own, drive = self.spec.joint(joint), self.drives[joint]
        if own is None:
            return False
        if drive is None:
            rub = add_play(self.mujoco, self.spec, joint, half_width)
            text = f"backlash of {joint}: {half_width:.4g} rad to either side"
            self.note("joint", f"{joint}_backlash", text)
            self.note(
                "fixed", f"{joint}_link", f"{joint}'s link behind its play; its bearing rubs {rub:.3g} N m"
            )
            self.remarks.append(f"{joint}: its link's angle is the tendon {joint}_link; {joint} is the motor")
            return True
        self._rub(joint, float(own.frictionloss) + half_width * drive.stiffness)
        self.taken[joint, "friction"], self.half_widths[joint] = "backlash", half_width
        text = f"backlash {half_width:.4g} rad: frictionloss over the actuator's stiffness"
        self.note("joint", joint, text)
        return True

    def _swing(self, joint: str, drive: Drive, damping: float, late: float, rubs: bool) -> None:
        inertia = float(self.model.arm.straight_inertia[self.joints.index(joint)])
        done = write_swing(self.mujoco, self.spec, joint, drive, damping, late, inertia, rubs)
        self.remarks += done.remarks
        if done.hertz:
            self.taken |= {(joint, name): "load_elasticity" for name in TERMS}
            self._told(drive, f"load_elasticity: swings at {done.hertz:.3g} Hz, ratio {damping:.3g}: kv")

    def _carried(self, values: Values) -> Values:
        """The payload as a mass; the layer has its sag in the wire. What it does to the motors comes with the
        mass, unless the servos' findings have it already.
        """
        sites = [site for site in self.spec.sites if "tip" in site.name]
        mass = float(values.get("payload", 0.0))
        if mass and sites and not {"load_droop", "unknown_servo"} & set(self.model.effects):
            body = sites[0].parent.add_body(name=PAYLOAD, pos=sites[0].pos)
            ball = self.mujoco.mjtGeom.mjGEOM_SPHERE
            body.add_geom(type=ball, size=[GRAIN, 0, 0], mass=mass, contype=0, conaffinity=0)
            self.note("body", PAYLOAD, f"payload {mass:.4g} kg at the tip")
        elif mass:
            self.remarks.append(SAGS.format(mass) if sites else NO_TIP.format(mass))
        return values

    def _late(self, elements: list[Any], name: str, values: Values) -> Values:
        if not elements or not hasattr(elements[0], "delay"):
            return values
        for element, delay in zip(elements, np.broadcast_to(values["delay"], len(elements)), strict=True):
            if delay == 0.0:
                continue
            element.delay = float(element.delay) + delay
            element.nsample = int(np.ceil(element.delay / self.spec.option.timestep)) + 2
            element.interp = 1
            element.name = element.name or f"{getattr(element, 'objname', '') or element.target}_{name}"
            tag = tag_of(element) if name == "servo_delay" else "jointpos"
            self.note(tag, element.name, f"{name} {delay:.4g} s: delay")
        return {}
