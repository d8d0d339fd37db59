"""The fleet on one page that needs no other file."""

from trunk_ros.fleet.report.page import render

__all__ = ["render"]
