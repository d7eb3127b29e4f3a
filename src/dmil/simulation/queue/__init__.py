"""The embedded queue simulator."""

from dmil.simulation.queue.simulator import QueueSimulator

__all__ = ["QueueSimulator"]
