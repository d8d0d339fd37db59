"""Friction, armature and the last link's mass from the torque of the motors."""
