"""Memory-based multi-agent traffic-signal control: train, compare, inspect."""

__version__ = "0.1.0"
