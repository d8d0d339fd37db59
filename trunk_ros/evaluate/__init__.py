"""Scores of models and of other simulators on recordings."""

from trunk_ros.evaluate.score import Row, score
from trunk_ros.evaluate.source import Prediction, of_model, of_simulator

__all__ = ["Prediction", "Row", "of_model", "of_simulator", "score"]
