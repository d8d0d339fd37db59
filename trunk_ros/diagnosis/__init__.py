"""Find what a simulation leaves out of a recording."""

from trunk_ros.diagnosis.diagnose import diagnose
from trunk_ros.diagnosis.verdict.result import Diagnosis, Finding, Unexplained

__all__ = ["Diagnosis", "Finding", "Unexplained", "diagnose"]
