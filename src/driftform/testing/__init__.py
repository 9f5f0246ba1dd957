"""Contract tests that a plugin inherits: one class per seam, and one for commands.

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

from pathlib import Path

import pytest

# By default pytest rewrites assertions in test files only, and would not show the values of a failed one here.
pytest.register_assert_rewrite(*(f"{__name__}.{path.stem}" for path in Path(__file__).parent.glob("[a-z]*.py")))

from driftform.testing.builder import BuilderContract as BuilderContract  # noqa: E402
from driftform.testing.checker import CheckerContract as CheckerContract  # noqa: E402
from driftform.testing.commands import CommandsContract as CommandsContract  # noqa: E402
from driftform.testing.exporter import ExporterContract as ExporterContract  # noqa: E402
from driftform.testing.fitness import FitnessContract as FitnessContract  # noqa: E402
from driftform.testing.fitting import FittingContract as FittingContract  # noqa: E402
from driftform.testing.grammar import GrammarContract as GrammarContract  # noqa: E402
from driftform.testing.hydrodynamics import HydrodynamicsContract as HydrodynamicsContract  # noqa: E402
from driftform.testing.recorder import RecorderContract as RecorderContract  # noqa: E402
from driftform.testing.renderer import RendererContract as RendererContract  # noqa: E402
from driftform.testing.simulator import PointSimulatorContract as PointSimulatorContract  # noqa: E402
from driftform.testing.simulator import SimulatorContract as SimulatorContract  # noqa: E402
from driftform.testing.strategy import StrategyContract as StrategyContract  # noqa: E402

__all__ = [name for name in dir() if name.endswith("Contract")]
