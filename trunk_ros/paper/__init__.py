"""`paper`: the source of the nominal arm, checked number by number, and its further work done."""

from trunk_ros.paper.command import main

__all__ = ["main"]
