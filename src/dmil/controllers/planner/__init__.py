"""A planner that knows all arrivals: the limit at a single intersection."""
