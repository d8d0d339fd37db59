"""Physics of the servo that no name fits: a smooth curve added to the gearbox angle."""

from trunk_ros.effects.wire.unknown import Unknown


class UnknownServo(Unknown):
    """phi += curve(x)."""

    id = "unknown_servo"
    stage, place, regime = "servo", 250, "posture"
    compensable = False
