"""Demand: arrival processes, routes and trips of files as arrays of vehicles."""

from dmil.demand.poisson import PAPER_RATE_VEH_PER_MIN, PoissonDemand
from dmil.demand.vehicles import Demand, Vehicles

__all__ = ["PAPER_RATE_VEH_PER_MIN", "Demand", "PoissonDemand", "Vehicles"]
