"""What studies share when they turn runs into tables: order, panels, verdicts."""
