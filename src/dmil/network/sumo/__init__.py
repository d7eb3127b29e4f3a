"""Reader of SUMO road networks: roads, signals, programs and right of way of a ``.net.xml``."""

from dmil.network.sumo.reader import read_sumo_network
from dmil.network.sumo.records import Remark, SumoNetwork, SumoSignals

__all__ = ["Remark", "SumoNetwork", "SumoSignals", "read_sumo_network"]
