"""Each checker keeps to the contract of its seam."""

from typing import Any

import pytest

from driftform.interfaces import Checker
from driftform.plugins.registry import registry
from driftform.testing import CheckerContract

# A cube is solid: filled as far as its walls, it has the filament of its volume.
OPTIONS = {"prusa-slicer": {"infill": 1.0, "layer_height": 0.0004}}


class TestCheckers(CheckerContract):
    @pytest.fixture(autouse=True, params=["mesh", "admesh", "openscad", "prusa-slicer"])
    def _choose(self, request: pytest.FixtureRequest) -> None:
        self.chosen: Checker[Any] = registry().create("checker", request.param, OPTIONS.get(request.param, {}))

    def plugin(self) -> Checker[Any]:
        return self.chosen
