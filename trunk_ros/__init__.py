"""Tendon-driven arms: names the physical effects that a simulation is missing; ROS 2 nodes around it."""

__version__ = "0.2.0"
