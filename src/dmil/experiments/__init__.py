"""Experiments: trials that are planned, run in parallel, kept, resumed, compared and tuned."""
