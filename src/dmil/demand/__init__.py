"""Demand: arrival processes, routes and trips of files as arrays of vehicles."""

from dmil.demand.arrivals import ArrivalProcess, CompoundPoissonDemand, PoissonDemand, ProfileDemand
from dmil.demand.cityflow import CityflowDemand, read_cityflow_flow
from dmil.demand.destinations import PAPER_RATE_VEH_PER_MIN, Ties
from dmil.demand.levels import DemandLevels
from dmil.demand.recorded import FileDemand, ResampledDemand
from dmil.demand.sumo import DemandRemark, SumoDemand, read_sumo_routes
from dmil.demand.vehicles import Demand, ScalableDemand, Vehicles

__all__ = [
    "PAPER_RATE_VEH_PER_MIN",
    "ArrivalProcess",
    "CityflowDemand",
    "CompoundPoissonDemand",
    "Demand",
    "DemandLevels",
    "DemandRemark",
    "FileDemand",
    "PoissonDemand",
    "ProfileDemand",
    "ResampledDemand",
    "ScalableDemand",
    "SumoDemand",
    "Ties",
    "Vehicles",
    "read_cityflow_flow",
    "read_sumo_routes",
]
