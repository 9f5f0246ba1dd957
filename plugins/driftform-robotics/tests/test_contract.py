from collections.abc import Callable
from typing import Any

import pytest

from driftform.interfaces import Exporter
from driftform.testing import ExporterContract


class TestExporters(ExporterContract):
    @pytest.fixture(autouse=True, params=["sdf", "fortress", "uuv", "urdf", "mjcf", "fossen"])
    def _choose(self, request: pytest.FixtureRequest, make_exporter: Callable[..., Exporter[Any]]) -> None:
        options = {"gazebo": "fortress"} if request.param == "fortress" else {}
        self.chosen = make_exporter("sdf" if options else request.param, **options)

    def plugin(self) -> Exporter[Any]:
        return self.chosen
