"""The arguments of bringup, without what it takes to run it: help and completion are quick."""

from __future__ import annotations

import argparse

from trunk_ros.console.arguments import Parser

PARTS = ("servo_driver", "wire_elasticity", "compensator", "recorder")
TRAJECTORIES = (
    "default",
    "sweeps",
    "fast",
    "reversals",
    "holds",
    "slow",
)  # motion.NAMES, which is slow to import


def parser() -> argparse.ArgumentParser:
    """The arguments of bringup."""
    parse = Parser(
        prog="bringup",
        description="Runs servo_driver, wire_elasticity, compensator and recorder with a trajectory.",
    )
    add = parse.add_argument
    add("--output", metavar="BAG", help="folder of the recording; must not exist")
    add("--overwrite", action="store_true", help="replace an existing recording")
    add("--seconds", type=float, default=20.0, metavar="S", help="length of the run, 20 by default")
    add(
        "--trajectory",
        default="default",
        metavar="NAME|FILE",
        help=f"YAML file, or one of {', '.join(TRAJECTORIES)}",
    )
    add("--without", nargs="+", default=[], metavar="NODE", help=f"nodes to leave out, of {', '.join(PARTS)}")
    add(
        "--model",
        metavar="MODEL",
        help="the arm, and what the compensator believes of it: file or name in config/, trunk by default",
    )
    add(
        "--plant-model",
        metavar="MODEL",
        help="what the simulated arm is; by default the arm of --model, without the effects in that file",
    )
    add("--rate", type=float, default=100.0, metavar="HZ", help="control rate, 100 by default")
    add("--sim-time", action="store_true", help="simulated time with /clock, as fast as the machine goes")
    add("--processes", action="store_true", help="each node in a process of its own")
    return parse
