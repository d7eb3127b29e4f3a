"""Learners that remember lanes: one small table serves every lane of the network."""
