"""Learners that remember returns or patterns: one memory for all agents of a shape."""
