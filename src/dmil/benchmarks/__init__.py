"""Measurements of speed, printed and never asserted."""

from dmil.benchmarks.figures import SpeedFigure

__all__ = ["SpeedFigure"]
