"""Road networks: frozen data, a grid builder, readers of files, checks."""

from dmil.network.grid import grid
from dmil.network.model import (
    Intersection,
    Link,
    Movement,
    RoadNetwork,
    Turn,
    shape_signature,
)

__all__ = [
    "Intersection",
    "Link",
    "Movement",
    "RoadNetwork",
    "Turn",
    "grid",
    "shape_signature",
]
