"""Controllers that follow a rule: fixed cycles, actuated control, queues and pressures."""
