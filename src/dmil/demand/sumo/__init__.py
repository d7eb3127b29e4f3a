"""Reader of SUMO's vehicles: the vehicles, trips, flows and vehicle types of ``.rou.xml`` files."""

from dmil.demand.sumo.demand import SumoDemand
from dmil.demand.sumo.reader import read_sumo_routes
from dmil.demand.sumo.remarks import DemandRemark

__all__ = ["DemandRemark", "SumoDemand", "read_sumo_routes"]
