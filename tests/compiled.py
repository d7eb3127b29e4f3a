"""Compile what most tests need before there are two workers that would both compile it."""

from dmil.controllers import RunContext, make_controller
from dmil.experiments.warm_up import compile_kernels
from dmil.parallel import LocalExecutor
from dmil.scenarios import scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.training import vehicles_of_seed


def decide_once(name: str) -> None:
    """Let a memory of lanes decide once."""
    made = scenario("grid:1x2")
    controller = make_controller(name)
    controller.reset(RunContext(made.network, made.timing, stream(0)))
    controller.decide(QueueSimulator(made).reset(vehicles_of_seed(made, 0)), None)


if __name__ == "__main__":
    compile_kernels()
    for _ in LocalExecutor(2).map(decide_once, ["combined", "factored", "lookahead"]):
        pass
