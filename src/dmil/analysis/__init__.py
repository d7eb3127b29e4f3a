"""From results to tables to claims with verdicts."""
