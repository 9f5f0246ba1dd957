import pytest

from driftform.testing import BuilderContract, ExporterContract
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.exporters.meshes import GlbExporter, ObjExporter, PlyExporter, StlExporter
from driftform_frusta.exporters.scad import ScadExporter
from driftform_frusta.exporters.step import StepExporter
from driftform_frusta.exporters.svg import SvgExporter
from driftform_frusta.exporters.threemf import ThreeMfExporter

CAPSULE = ((0.0, 0.0), (0.0, 0.01), (0.003, 0.0125), (0.057, 0.0125), (0.06, 0.01), (0.06, 0.0))
BUILDERS = {
    "default": {},
    "wall of the paper": {"wall_model": "paper"},
    "thick wall": {"wall": 0.003, "min_radius": 0.006, "core_radius": 0.015},
    "tuned by the cavity": {"tuning": "wall", "core_radius": 0.01, "core_mass": 0.033},
    "tuned by balls of steel": {"tuning": "ballast", "max_radius": 0.02},
    "capsule": {"core_profile": CAPSULE, "core_radius": 0.0125, "core_mass": 0.02, "core_cog": 0.03},
    "capsule that is tuned": {
        "core_profile": CAPSULE,
        "core_radius": 0.0125,
        "core_mass": 0.02,
        "core_cog": 0.03,
        "tuning": "wall",
    },
}
EXPORTERS = (GlbExporter, ObjExporter, PlyExporter, ScadExporter, StlExporter, SvgExporter, ThreeMfExporter)


class TestFrusta(BuilderContract):
    @pytest.fixture(autouse=True, params=BUILDERS)
    def _choose(self, request):
        self.chosen = FrustaBuilder(FrustaOptions(**BUILDERS[request.param]))

    def plugin(self):
        return self.chosen


class TestExporters(ExporterContract):
    @pytest.fixture(
        autouse=True,
        params=[*EXPORTERS, pytest.param(StepExporter, marks=pytest.mark.peers)],
        ids=lambda exporter: exporter.name,
    )
    def _choose(self, request):
        self.chosen = request.param(request.param.Options())

    def plugin(self):
        return self.chosen
