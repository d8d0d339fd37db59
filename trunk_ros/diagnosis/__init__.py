"""Find what a simulation leaves out of a recording."""

from trunk_ros.diagnosis.diagnose import diagnose
from trunk_ros.diagnosis.verdict.answer import Unexplained
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.diagnosis.verdict.result import Diagnosis

__all__ = ["Diagnosis", "Finding", "Unexplained", "diagnose"]
