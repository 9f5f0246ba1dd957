import pytest

from driftform.testing import ExporterContract


class TestExporters(ExporterContract):
    @pytest.fixture(autouse=True, params=["sdf", "fortress", "uuv", "urdf", "mjcf", "fossen"])
    def _choose(self, request, make_exporter):
        options = {"gazebo": "fortress"} if request.param == "fortress" else {}
        self.chosen = make_exporter("sdf" if options else request.param, **options)

    def plugin(self):
        return self.chosen
