"""Measurements of speed, printed and never asserted."""

from dmil.benchmarks.figures import Figure

__all__ = ["Figure"]
