"""Contract tests that a plugin inherits: one class for each seam.

A plugin's whole test of its seam is a subclass that says how the plugin is made::

    from driftform.testing import SimulatorContract
    from my_package import MyOptions, MySimulator


    class TestMySimulator(SimulatorContract):
        def plugin(self) -> MySimulator:
            return MySimulator(MyOptions())

pytest then runs every ``test_`` method of the contract on it. Each method's docstring is one sentence of what the
seam demands; attributes of the class are tolerances, which a subclass may tighten.

This package is the only one of driftform that imports pytest, which is no runtime dependency of driftform:
install it where the tests run.
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
)

# pytest rewrites the assertions of test files only, unless told: the values behind a failure would not be shown.
pytest.register_assert_rewrite(*(f"{__name__}.{module}" for module in _CONTRACTS))

from driftform.testing.builder import BuilderContract  # noqa: E402
from driftform.testing.checker import CheckerContract  # noqa: E402
from driftform.testing.exporter import ExporterContract  # noqa: E402
from driftform.testing.fitness import FitnessContract  # noqa: E402
from driftform.testing.grammar import GrammarContract  # noqa: E402
from driftform.testing.hydrodynamics import HydrodynamicsContract  # noqa: E402
from driftform.testing.recorder import RecorderContract  # noqa: E402
from driftform.testing.renderer import RendererContract  # noqa: E402
from driftform.testing.simulator import SimulatorContract  # noqa: E402
from driftform.testing.strategy import StrategyContract  # noqa: E402

__all__ = [
    "BuilderContract",
    "CheckerContract",
    "ExporterContract",
    "FitnessContract",
    "GrammarContract",
    "HydrodynamicsContract",
    "RecorderContract",
    "RendererContract",
    "SimulatorContract",
    "StrategyContract",
]
