"""The catalogue of controllers: all that is said of one, from its class to its colour."""

from __future__ import annotations

from dmil.controllers.deep import on_demand
from dmil.controllers.deep.settings import (
    DqnSettings,
    HindsightSettings,
    NecSettings,
    PrioritisedSettings,
    VdnSettings,
)
from dmil.controllers.entry import Entry, Range
from dmil.controllers.episodic.mfec import MfecController, MfecSettings
from dmil.controllers.episodic.plmp import PlmpController, PlmpSettings
from dmil.controllers.lanes.factored import FactoredController, FactoredSettings
from dmil.controllers.lanes.lookahead import LookaheadController, LookaheadSettings
from dmil.controllers.planner.foresight import ForesightController, ForesightSettings
from dmil.controllers.rules.baselines import (
    ActuatedController,
    FixedCycleController,
    LongestQueueFirstController,
    MaxPressureController,
    ProgramController,
    RandomController,
)
from dmil.controllers.rules.gap_out import GapOutController, GapOutSettings
from dmil.controllers.rules.settings import (
    FixedCycleSettings,
    LongestQueueFirstSettings,
    MaxPressureSettings,
)
from dmil.controllers.rules.sotl import SotlController, SotlSettings
from dmil.controllers.rules.webster import WebsterController, WebsterSettings
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings

_ADAM = Range(1e-4, 1e-2, log=True)

CONTROLLERS: dict[str, Entry] = {
    "random": Entry(
        RandomController, None, "uniformly random phases", own_colour="#b5b5b5", dash=(2, 2)
    ),
    "fixed-cycle": Entry(
        FixedCycleController,
        FixedCycleSettings,
        "the same phases in the same order",
        label="fixed cycle",
        own_colour="#b5b5b5",
    ),
    "webster": Entry(
        WebsterController,
        WebsterSettings,
        "fixed cycle and splits from the run's mean flows (Webster 1958)",
        label="Webster",
        dash=(5, 3),
        ranges={"min_cycle_s": Range(0, 60), "max_cycle_s": Range(60, 180)},
    ),
    "program": Entry(
        ProgramController,
        None,
        "the network's own signal program",
        label="own program",
        short="program",
        own_colour="#222222",
        dash=(8, 2, 2, 2),
        shows_plan=True,
    ),
    "actuated": Entry(
        ActuatedController,
        None,
        "SUMO's actuated control of that program; in SUMO only",
        dash=(8, 2, 2, 2),
        shows_plan=True,
        sumo_only=True,
    ),
    "gap-out": Entry(
        GapOutController,
        GapOutSettings,
        "actuated control: green while vehicles come",
        ranges={
            "min_green_s": Range(0, 20, whole=True),
            "max_green_s": Range(20, 90, whole=True),
            "extend_veh": Range(1, 10, whole=True),
        },
    ),
    "sotl": Entry(
        SotlController,
        SotlSettings,
        "self-organising traffic lights (Gershenson 2005)",
        label="SOTL",
        dash=(2, 2),
        ranges={
            "theta_veh_s": Range(1, 200, log=True),
            "min_green_s": Range(0, 20, whole=True),
            "mu_veh": Range(0, 5, whole=True),
        },
    ),
    "longest-queue-first": Entry(
        LongestQueueFirstController,
        LongestQueueFirstSettings,
        "the phase with the most vehicles queued",
        label="longest queue first",
        short="longest queue",
        own_colour="#6b6b6b",
        shades={"approaching": "#222222"},
    ),
    "max-pressure": Entry(
        MaxPressureController,
        MaxPressureSettings,
        "the phase with the highest pressure (Varaiya 2013)",
        own_colour="#7a7a7a",
        dash=(5, 3),
    ),
    "foresight": Entry(
        ForesightController,
        ForesightSettings,
        "plans one intersection, all arrivals known: a limit, no rival",
        label="foresight (planner)",
        oracle=True,
    ),
    "factored": Entry(
        FactoredController,
        FactoredSettings,
        "factored dual memory: one small table of lanes, neighbours announce their phases",
        ranges={
            "rate_step": Range(0.005, 0.2, log=True),
            "trust": Range(0.005, 0.5, log=True),
            "trust_veh": Range(0.1, 10, log=True),
            "vehicle": Range(0.5, 8, log=True),
            "wave": Range(0.0, 2.0),
        },
        learns=True,
        online=True,
    ),
    "lookahead": Entry(
        LookaheadController,
        LookaheadSettings,
        "model memory: a learned model of lanes, two decisions ahead",
        own_colour="#EE3377",
        dash=(5, 3),
        learns=True,
        online=True,
    ),
    "sarsa": Entry(
        SarsaController,
        SarsaSettings,
        "the paper's non-memory agent, for any embedding",
        label="SARSA",
        shades={"simple": "#B3701A", "complex": "#8A6D3B"},
        learns=True,
        from_prior=True,
    ),
    "dual-memory": Entry(
        DualMemoryController,
        DualMemorySettings,
        "the paper's memory-based agent",
        label="Dual memory",
        short="dual memory",
        own_colour="#0072B2",
        shades={"simple": "#56B4E9", "cells": "#1F3B73"},
        ranges={"least_tried": Range(1, 8, log=True, whole=True)},
        learns=True,
        from_prior=True,
    ),
    "mfec": Entry(
        MfecController,
        MfecSettings,
        "model-free episodic control (Blundell 2016)",
        label="MFEC",
        learns=True,
    ),
    "nec": Entry(
        on_demand("nec", "NecController"),
        NecSettings,
        "neural episodic control: a learned embedding over returns (Pritzel 2017)",
        label="NEC",
        own_colour="#00684C",
        dash=(5, 3),
        ranges={"learning_rate": _ADAM, "value_rate": Range(0.01, 1.0, log=True)},
        learns=True,
    ),
    "plmp": Entry(
        PlmpController,
        PlmpSettings,
        "pattern learning with memory and prediction (Han 2023), reconstructed",
        label="PLMP",
        own_colour="#7CB518",
        dash=(2, 2),
        ranges={"reach": Range(0, 3, whole=True)},
        learns=True,
    ),
    "dqn": Entry(
        on_demand("dqn", "DqnController"),
        DqnSettings,
        "deep Q-network with experience replay (Mnih 2015)",
        label="DQN",
        ranges={"learning_rate": _ADAM},
        learns=True,
    ),
    "dqn-prioritised": Entry(
        on_demand("dqn_prioritised", "PrioritisedController"),
        PrioritisedSettings,
        "the same with prioritised replay (Schaul 2016)",
        label="DQN, prioritised replay",
        own_colour="#A77BDC",
        dash=(5, 3),
        ranges={"learning_rate": _ADAM},
        learns=True,
    ),
    "dqn-hindsight": Entry(
        on_demand("dqn_hindsight", "HindsightController"),
        HindsightSettings,
        "the same with goals and hindsight replay (Andrychowicz 2017); an ablation",
        label="DQN, hindsight replay",
        own_colour="#C3A8EA",
        dash=(2, 2),
        ranges={
            "learning_rate": _ADAM,
            "goal_veh": Range(1, 20, log=True, whole=True),
            "relabelled": Range(1, 8, whole=True),
        },
        learns=True,
    ),
    "vdn": Entry(
        on_demand("vdn", "VdnController"),
        VdnSettings,
        "value decomposition network: one error on the sum of all values (Sunehag 2018)",
        label="VDN",
        own_colour="#CC79A7",
        ranges={"learning_rate": _ADAM},
        learns=True,
    ),
}
"""The named controllers."""
