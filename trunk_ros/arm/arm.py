"""The arm: joints, transmission, servo, and the links that it carries."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from trunk_ros.arm.body import Body
from trunk_ros.arm.description import Description
from trunk_ros.arm.planar import planar
from trunk_ros.arm.wire import Wire
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError

GRAVITY = 9.81  # m/s^2, along -z
SERVO_OF_EACH = ("kp", "tau_v", "v_max", "delay", "feedforward")
STEP = 0.002  # s, in which the reference integrates its servos
LOADS = ("weight", "weight_and_inertia", "effort")


@dataclass(frozen=True)
class Arm:
    """A serial wire-driven arm; per-joint values are (joints,) arrays, angles rad, SI units. Of prismatic
    joints they are m and N.

    Its links are those of a URDF, or a planar chain. ``link_length`` or ``link_mass`` may be empty: then
    there is no tip and no load to speak of.
    """

    joints: tuple[str, ...]
    ratio: Array
    """Joint angle per gearbox angle; 1 where ``coupling`` is given."""
    dead_band: Array
    lower: Array
    upper: Array
    link_length: Array
    link_mass: Array
    compliance: Array
    payload: float = 0.0
    gravity: float | tuple[float, float, float] = GRAVITY
    """m/s^2: along -z of the world, or a vector in it."""
    mounting: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw [rad] of the base in the world (REP 103: about fixed X, Y, Z)."""
    servo_stated: bool = True
    """Whether anything is said of the servos; if not, the numbers below are those of any."""
    kp: float | Array = 20.0
    """1/s, and the numbers below as well: one for all joints, or (joints,)."""
    tau_v: float | Array = 0.02
    v_max: float | Array = 1.5
    delay: float | Array = 0.0
    feedforward: float | Array = 0.0
    counts_per_rev: float = 131072.0
    step: float = STEP
    """s, in which the servos' loops run; 0: as if without end. Of loops that the reference steps more finely
    than STEP, as they are stiff, as much less."""
    wire: Wire | None = field(default=None)
    load_from: str = "weight"
    """One of LOADS: what the joints' moment is taken from. See trunk_ros/resistance.py."""
    description: Description | None = None
    """The URDF in the place of lengths and masses."""
    coupling: Array | None = None
    """(joints, motors): joint angle per motor angle, where a motor moves several joints."""
    motors: tuple[str, ...] = ()
    """What the motors are called where they are not called as the joints."""

    def __post_init__(self) -> None:
        for name in ("ratio", "dead_band", "lower", "upper"):
            check_length(getattr(self, name), len(self.joints), name)
        for name in ("link_length", "link_mass", "compliance"):
            if len(getattr(self, name)):
                check_length(getattr(self, name), len(self.joints), name)

    @property
    def ahead(self) -> float:
        """Part of the reference's step by which loops in steps of their own see their shafts go on, as in
        ``servo_loop``: 0 in STEP, 1/2 where they run as if without end.
        """
        return 0.5 * (1.0 - self.step / STEP)

    @property
    def is_planar(self) -> bool:
        """Whether it is a chain of link lengths."""
        return self.description is None and len(self.link_length) == len(self.joints) > 0

    @property
    def has_geometry(self) -> bool:
        """Whether the links are known, so that there is a tip."""
        return self.description is not None or self.is_planar

    @property
    def has_load(self) -> bool:
        """Whether weight can be computed from the posture."""
        if self.description is not None:
            return self.body.mass > 0.0
        return self.is_planar and len(self.link_mass) == len(self.joints)

    @property
    def body(self) -> Body:
        """The links. Raises ModelError where they are not known."""
        if self.description is not None:
            return self.description.body(self.joints)
        if not self.is_planar:
            raise ModelError("the model has neither arm.urdf nor arm.link_length, so there is no tip")
        mass = self.link_mass if len(self.link_mass) else np.zeros(len(self.joints))
        return planar(tuple(self.link_length.tolist()), tuple(mass.tolist()))

    @cached_property
    def pull(self) -> Array:
        """(3,) m/s^2 gravity in the axes of the base."""
        world = (0.0, 0.0, -self.gravity) if isinstance(self.gravity, (int, float)) else self.gravity
        return np.asarray(turned(self.mounting).T @ np.asarray(world, dtype=float))

    @property
    def base_link(self) -> str:
        """The link that the tip is told in."""
        return "base_link" if self.description is None else self.description.found().base

    @property
    def units(self) -> dict[str, str]:
        """SI unit of the joints that are not in rad."""
        known = () if self.description is None else self.description.arm_joints
        return {j.name: "m" for j in known if j.kind == "prismatic" and j.name in self.joints}

    def index(self, joint: str) -> int:
        """Column of a joint. Raises ModelError for a joint that the arm does not have."""
        if joint not in self.joints:
            raise ModelError(f"unknown joint {joint!r}: the model has {', '.join(self.joints)}")
        return self.joints.index(joint)

    # Links

    def tip(self, theta: Array) -> Array:
        """Tip (n, 7) of joint angles (n, joints) in the base link: x, y, z [m], quaternion x, y, z, w."""
        return self.body.poses(theta)

    def load(self, theta: Array) -> Array:
        """Moment of the weight beyond each joint about it [N m], (n, joints), payload included.

        Positive where it tends to increase the joint angle. Zeros where the arm has no masses.
        """
        if not self.has_load:
            return np.zeros_like(theta)
        return self.body.moments(theta, self.pull, self.payload)

    def lever(self, theta: Array) -> Array:
        """Moment about each joint per kilogram at the tip [N m/kg], (n, joints)."""
        if not self.has_geometry:
            return np.zeros_like(theta)
        return self.body.moments(theta, self.pull, 1.0, links=False)

    def inertia(self, theta: Array, speed: Array, acceleration: Array) -> Array:
        """Moment of inertia forces about each joint [N m], (n, joints), payload included: -(M q'' + C q').

        Positive where it tends to increase the joint angle. Zeros where the arm has no masses.
        """
        if not self.has_load:
            return np.zeros_like(theta)
        return self.body.moments(theta, np.zeros(3), self.payload, speed, acceleration)

    def inertial_lever(self, theta: Array, speed: Array, acceleration: Array) -> Array:
        """Moment of inertia forces about each joint per kilogram at the tip [N m/kg], (n, joints)."""
        if not self.has_load:
            return np.zeros_like(theta)
        return self.body.moments(theta, np.zeros(3), 1.0, speed, acceleration, links=False)

    def mass_matrix(self, theta: Array) -> Array:
        """M(q) (n, joints, joints) kg m^2, payload included."""
        return self.body.mass_matrix(theta, self.payload)

    def mass_lever(self, theta: Array) -> Array:
        """What a kilogram at the tip adds to it, (n, joints, joints) kg m^2 per kg."""
        return self.body.mass_lever(theta)

    @cached_property
    def straight_inertia(self) -> Array:
        """(joints,) kg m^2 that each joint turns of the arm with all joints at 0."""
        return np.ascontiguousarray(self.mass_matrix(np.zeros((1, len(self.joints))))[0].diagonal())

    # Transmission

    @property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the motors, one per joint."""
        return self.motors or self.joints

    @property
    def rest(self) -> Array:
        """(joints,) where a simulated arm begins: 0, or the limit next to it."""
        return np.minimum(np.maximum(0.0, self.lower), self.upper)

    @property
    def top_speed(self) -> Array:
        """(joints,) rad/s that all joints can have at once with no motor beyond its top speed."""
        if self.coupling is None:
            return np.asarray(self.v_max * np.abs(self.ratio))
        asked = np.abs(np.linalg.inv(self.coupling))
        slowest = self.v_max / asked.sum(axis=1)  # of the joints that a motor moves, at once
        return np.asarray(np.where(asked > 0.0, slowest[:, None], np.inf).min(axis=0))

    def driven(self, motors: Array) -> Array:
        """What motor angles (…, motors) are at the joints, (…, joints): also of speeds."""
        return np.asarray(motors * self.ratio if self.coupling is None else motors @ self.coupling.T)

    def asked(self, joints: Array) -> Array:
        """Motor angles (…, motors) of what they are to be at the joints (…, joints)."""
        if self.coupling is None:
            return np.asarray(joints / self.ratio)
        return np.asarray(np.linalg.solve(self.coupling, joints.T).T)

    def carried(self, moment: Array) -> Array:
        """Moments on the joints (…, joints) as their motors feel them (…, motors) [N m]."""
        return np.asarray(moment * self.ratio if self.coupling is None else moment @ self.coupling)

    def uncoupled(self) -> Arm:
        """The arm as its joints' wires see it: one path each, as if a motor of its own drove it."""
        if self.coupling is None:
            return self
        return replace(self, coupling=None, motors=())

    # Parts

    def only(self, joints: tuple[str, ...]) -> Arm:
        """The same arm seen through some of its joints, in their order (without geometry: a chain cannot be
        cut).

        Raises ModelError for a joint that the arm does not have, and where motors move several joints.
        """
        if joints == self.joints:
            return self
        columns = [self.index(joint) for joint in joints]
        if self.coupling is not None:
            missing = ", ".join(joint for joint in self.joints if joint not in joints)
            raise ModelError(f"wire.coupling wants all joints: {missing or 'their order'} is missing")
        cut = {name: getattr(self, name)[columns] for name in ("ratio", "dead_band", "lower", "upper")}
        if len(self.compliance):
            cut["compliance"] = self.compliance[columns]
        motors = tuple(self.motors[c] for c in columns) if self.motors else ()
        empty = np.empty(0)
        cut |= {"link_length": empty, "link_mass": empty}
        own = {name: getattr(self, name) for name in SERVO_OF_EACH}
        cut |= {name: value[columns] for name, value in own.items() if np.ndim(value)}
        return replace(self, joints=joints, motors=motors, description=None, wire=None, **cut)


def turned(angles: tuple[float, float, float]) -> Array:
    """(3, 3) rotation of roll, pitch, yaw [rad] about fixed X, Y and Z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    about_y = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_z @ about_y @ about_x)


def check_length(values: Array, joints: int, name: str) -> None:
    """Raise ModelError unless there is one value per joint."""
    if len(values) != joints:
        raise ModelError(f"{name} has {len(values)} values for {joints} joints: give one per joint")
