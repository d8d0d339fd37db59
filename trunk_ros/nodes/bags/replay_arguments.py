"""The arguments of replay."""

from __future__ import annotations

import argparse

from trunk_ros.console.arguments import Parser, add_namespace

NODES = ("wire_elasticity",)  # that can be run over a bag


def parser() -> argparse.ArgumentParser:
    """The arguments of replay."""
    parse = Parser(prog="replay", description="Publishes a bag's messages again.")
    add = parse.add_argument
    add("bag", metavar="BAG", help="rosbag2 folder or file")
    add("--rate", type=float, default=1.0, metavar="R", help="so many times as fast as recorded")
    add("--from-time", "--start", metavar="T", help="begin there: s since the start, or %% of the bag")
    add("--until", "--end", metavar="T", help="end there")
    add("--topics", nargs="+", default=[], metavar="TOPIC", help="only these")
    add("--exclude", nargs="+", default=[], metavar="TOPIC", help="not these")
    add("--remap", nargs="+", default=[], metavar="OLD:=NEW", help="publish under another name")
    add(
        "--clock",
        nargs="?",
        type=float,
        const=100.0,
        metavar="HZ",
        help="publish /clock, at 100 Hz by default",
    )
    add("--wait", type=float, default=4.0, metavar="S", help="wait so long for subscribers, 4 s by default")
    add("--loop", action="store_true", help="begin again at the end")
    add("--paused", action="store_true", help="stand still until the service ~/pause says otherwise")
    add(
        "--step",
        action="store_true",
        help="one message for each line on the standard input, or each call of ~/step",
    )
    again = parse.add_argument_group("comparing", "recompute what a node said, and publish nothing")
    again.add_argument(
        "--through", choices=list(NODES), help="compare what this node says with what was recorded"
    )
    again.add_argument(
        "-m", "--model", metavar="MODEL", help="of that node; by default what the bag says it had"
    )
    add_namespace(again)
    again.add_argument(
        "--tolerance", type=float, metavar="X", help="exit with 1 where a quantity differs by more [SI]"
    )
    return parse
