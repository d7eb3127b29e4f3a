"""SUMO road networks: reader of a ``.net.xml``, and writer of networks that have none."""

from dmil.network.sumo.reader import read_sumo_network
from dmil.network.sumo.records import Remark, SumoNetwork, SumoSignals
from dmil.network.sumo.writer import WrittenNetwork, sumo_lane, write_sumo_network

__all__ = [
    "Remark",
    "SumoNetwork",
    "SumoSignals",
    "WrittenNetwork",
    "read_sumo_network",
    "sumo_lane",
    "write_sumo_network",
]
