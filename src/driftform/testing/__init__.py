"""Contract tests that a plugin inherits: one class per seam, and one each for commands and scenarios.

To test a plugin against its seam, write a subclass that makes the plugin::

    from driftform.testing import SimulatorContract
    from my_package import MyOptions, MySimulator


    class TestMySimulator(SimulatorContract):
        def plugin(self) -> MySimulator:
            return MySimulator(MyOptions())

pytest then runs every ``test_`` method of the contract on the plugin. The docstring of a method states one requirement
of the seam; attributes of the class are tolerances, which a subclass may tighten.

Only this package of driftform imports pytest, which is not a runtime dependency of driftform: install it where the tests
run.
"""

import pytest

_CONTRACTS = (
    "grammar",
    "builder",
    "hydrodynamics",
    "simulator",
    "fitness",
    "strategy",
    "exporter",
    "recorder",
    "renderer",
    "checker",
    "inspector",
    "reporter",
    "commands",
    "scenarios",
)

# By default pytest rewrites assertions in test files only, and would not show the values of a failed one here.
pytest.register_assert_rewrite(*(f"{__name__}.{module}" for module in _CONTRACTS))

from driftform.testing.builder import BuilderContract  # noqa: E402
from driftform.testing.checker import CheckerContract  # noqa: E402
from driftform.testing.commands import CommandsContract  # noqa: E402
from driftform.testing.exporter import ExporterContract  # noqa: E402
from driftform.testing.fitness import FitnessContract  # noqa: E402
from driftform.testing.grammar import GrammarContract  # noqa: E402
from driftform.testing.hydrodynamics import HydrodynamicsContract  # noqa: E402
from driftform.testing.inspector import InspectorContract  # noqa: E402
from driftform.testing.recorder import RecorderContract  # noqa: E402
from driftform.testing.renderer import RendererContract  # noqa: E402
from driftform.testing.reporter import ReporterContract  # noqa: E402
from driftform.testing.scenarios import ScenariosContract  # noqa: E402
from driftform.testing.simulator import PointSimulatorContract, SimulatorContract  # noqa: E402
from driftform.testing.strategy import StrategyContract  # noqa: E402

__all__ = [
    "BuilderContract",
    "CheckerContract",
    "CommandsContract",
    "ExporterContract",
    "FitnessContract",
    "GrammarContract",
    "HydrodynamicsContract",
    "InspectorContract",
    "PointSimulatorContract",
    "RecorderContract",
    "RendererContract",
    "ReporterContract",
    "ScenariosContract",
    "SimulatorContract",
    "StrategyContract",
]
