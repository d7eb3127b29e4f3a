"""Learners with a table of values for every agent: SARSA and the paper's dual memory."""
