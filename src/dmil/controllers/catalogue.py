"""The catalogue of controllers: all that is said of one, from its class to its colour."""

from __future__ import annotations

from dmil.controllers.deep import on_demand
from dmil.controllers.deep import settings as deep
from dmil.controllers.entry import Entry, Range
from dmil.controllers.episodic import mfec, plmp
from dmil.controllers.lanes import combined, factored, lookahead
from dmil.controllers.planner import foresight
from dmil.controllers.rules import baselines, gap_out, sotl, webster
from dmil.controllers.tabular import dual_memory, sarsa
from dmil.controllers.tabular import settings as tabular

RECOMMENDED = "combined"
"""What to take where nothing speaks for another: no worse than any rule or memory of ours on nearly
all networks that were measured (docs/decisions/0009), and it needs no training."""
_ADAM = Range(1e-4, 1e-2, log=True)

CONTROLLERS: dict[str, Entry] = {
    "random": Entry(
        baselines.RandomController, None, "uniformly random phases", colour="#b5b5b5", dash=(2, 2)
    ),
    "fixed-cycle": Entry(
        baselines.FixedCycleController,
        baselines.FixedCycleSettings,
        "the same phases in the same order",
        label="fixed cycle",
        colour="#b5b5b5",
    ),
    "webster": Entry(
        webster.WebsterController,
        webster.WebsterSettings,
        "fixed cycle and splits from the run's mean flows (Webster 1958)",
        label="Webster",
        dash=(5, 3),
        ranges={"min_cycle_s": Range(0, 60), "max_cycle_s": Range(60, 180)},
    ),
    "program": Entry(
        baselines.ProgramController,
        None,
        "the network's own signal program",
        label="own program",
        short="program",
        colour="#222222",
        dash=(8, 2, 2, 2),
        shows_plan=True,
    ),
    "actuated": Entry(
        baselines.ActuatedController,
        None,
        "SUMO's actuated control of that program; in SUMO only",
        dash=(8, 2, 2, 2),
        shows_plan=True,
        sumo_only=True,
    ),
    "gap-out": Entry(
        gap_out.GapOutController,
        gap_out.GapOutSettings,
        "actuated control: green while vehicles come",
        ranges={
            "min_green_s": Range(0, 20, whole=True),
            "max_green_s": Range(20, 90, whole=True),
            "extend_veh": Range(1, 10, whole=True),
        },
    ),
    "sotl": Entry(
        sotl.SotlController,
        sotl.SotlSettings,
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
        baselines.LongestQueueFirstController,
        baselines.LongestQueueFirstSettings,
        "the phase with the most vehicles queued",
        label="longest queue first",
        short="longest queue",
        colour="#6b6b6b",
        shades={"approaching": "#222222"},
    ),
    "max-pressure": Entry(
        baselines.MaxPressureController,
        baselines.MaxPressureSettings,
        "the phase with the highest pressure (Varaiya 2013)",
        colour="#7a7a7a",
        dash=(5, 3),
    ),
    "foresight": Entry(
        foresight.ForesightController,
        foresight.ForesightSettings,
        "plans one intersection, all arrivals known: a limit, no rival",
        label="foresight (planner)",
        colour="#222222",
        oracle=True,
    ),
    "combined": Entry(
        combined.CombinedController,
        combined.CombinedSettings,
        "values of lanes and two decisions of look-ahead; knows yielding, shared lanes, long waits",
        colour="#D4145A",
        learns=True,
        online=True,
    ),
    "factored": Entry(
        factored.FactoredController,
        factored.FactoredSettings,
        "factored dual memory: one small table of lanes, neighbours announce their phases",
        colour="#D55E00",
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
        lookahead.LookaheadController,
        lookahead.LookaheadSettings,
        "model memory: a learned model of lanes, two decisions ahead",
        colour="#EE3377",
        dash=(5, 3),
        learns=True,
        online=True,
    ),
    "sarsa": Entry(
        sarsa.SarsaController,
        tabular.SarsaSettings,
        "the paper's non-memory agent, for any embedding",
        label="SARSA",
        colour="#E69F00",
        shades={"simple": "#B3701A", "complex": "#8A6D3B", "complex-scaled": "#8A6D3B"},
        learns=True,
        from_prior=True,
    ),
    "dual-memory": Entry(
        dual_memory.DualMemoryController,
        tabular.DualMemorySettings,
        "the paper's memory-based agent",
        label="Dual memory",
        short="dual memory",
        colour="#0072B2",
        shades={"simple": "#56B4E9", "cells": "#1F3B73"},
        ranges={"least_tried": Range(1, 8, log=True, whole=True)},
        learns=True,
        from_prior=True,
    ),
    "mfec": Entry(
        mfec.MfecController,
        mfec.MfecSettings,
        "model-free episodic control (Blundell 2016)",
        label="MFEC",
        colour="#009E73",
        learns=True,
    ),
    "nec": Entry(
        on_demand("nec", "NecController"),
        deep.NecSettings,
        "neural episodic control: a learned embedding over returns (Pritzel 2017)",
        label="NEC",
        colour="#00684C",
        dash=(5, 3),
        ranges={"learning_rate": _ADAM, "value_rate": Range(0.01, 1.0, log=True)},
        learns=True,
    ),
    "plmp": Entry(
        plmp.PlmpController,
        plmp.PlmpSettings,
        "pattern learning with memory and prediction (Han 2023), reconstructed",
        label="PLMP",
        colour="#7CB518",
        dash=(2, 2),
        ranges={"reach": Range(0, 3, whole=True)},
        learns=True,
    ),
    "dqn": Entry(
        on_demand("dqn", "DqnController"),
        deep.DqnSettings,
        "deep Q-network with experience replay (Mnih 2015)",
        label="DQN",
        colour="#8250C4",
        ranges={"learning_rate": _ADAM},
        learns=True,
    ),
    "dqn-prioritised": Entry(
        on_demand("dqn", "PrioritisedController"),
        deep.PrioritisedSettings,
        "the same with prioritised replay (Schaul 2016)",
        label="DQN, prioritised replay",
        colour="#A77BDC",
        dash=(5, 3),
        ranges={"learning_rate": _ADAM},
        learns=True,
    ),
    "dqn-hindsight": Entry(
        on_demand("dqn_hindsight", "HindsightController"),
        deep.HindsightSettings,
        "the same with goals and hindsight replay (Andrychowicz 2017); an ablation",
        label="DQN, hindsight replay",
        colour="#C3A8EA",
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
        deep.VdnSettings,
        "value decomposition network: one error on the sum of all values (Sunehag 2018)",
        label="VDN",
        colour="#CC79A7",
        ranges={"learning_rate": _ADAM},
        learns=True,
    ),
}
"""The named controllers."""
