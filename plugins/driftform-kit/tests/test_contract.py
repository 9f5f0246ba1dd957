"""Each checker keeps to the contract of its seam."""

import pytest

from driftform.plugins.registry import registry
from driftform.testing import CheckerContract

# A cube is solid: filled as far as its walls, it has the filament of its volume.
OPTIONS = {"prusa-slicer": {"infill": 1.0, "layer_height": 0.0004}}


class TestCheckers(CheckerContract):
    @pytest.fixture(autouse=True, params=["mesh", "admesh", "openscad", "prusa-slicer"])
    def _choose(self, request):
        self.chosen = registry().create("checker", request.param, OPTIONS.get(request.param, {}))

    def plugin(self):
        return self.chosen
