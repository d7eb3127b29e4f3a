"""Checks for those who write their own controller, simulator or reward.

Call one of them in a test of your own::

    from dmil.testing import check_controller


    def test_my_controller():
        check_controller(MyController)

They raise `ConformanceError`, an `AssertionError` that names the rule that is broken, where it is
broken, what was found and what was expected.
"""

from dmil.testing.conformance import ConformanceError
from dmil.testing.controllers import check_controller
from dmil.testing.drives import SimulatorRule
from dmil.testing.rewards import RewardRule, check_reward
from dmil.testing.simulators import check_simulator
from dmil.testing.trials import ControllerRule

__all__ = [
    "ConformanceError",
    "ControllerRule",
    "RewardRule",
    "SimulatorRule",
    "check_controller",
    "check_reward",
    "check_simulator",
]
