"""Wire-driven arms on ROS 2: simulate, compensate, record, and find the physics a simulation left out."""

__version__ = "0.1.0"
