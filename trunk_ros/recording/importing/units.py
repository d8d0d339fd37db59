"""Units that a mapping may name, and their factors to SI."""

import math

# unit: (SI unit, factor)
UNITS = {
    "rad": ("rad", 1.0),
    "deg": ("rad", math.pi / 180),
    "m": ("m", 1.0),
    "mm": ("m", 1e-3),
    "rad/s": ("rad/s", 1.0),
    "deg/s": ("rad/s", math.pi / 180),
    "m/s": ("m/s", 1.0),
    "N": ("N", 1.0),
    "N*m": ("N*m", 1.0),
    "1": ("1", 1.0),
}
QUANTITIES = {
    "position": ("rad", "deg", "m", "mm", "1"),
    "velocity": ("rad/s", "deg/s", "m/s", "1"),
    "effort": ("N*m", "N", "1"),
}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
DATES = "iso8601"
"""The unit of times such as 2025-11-12T09:53:06.117Z."""
