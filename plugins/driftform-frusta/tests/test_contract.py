import pytest

from driftform.testing import BuilderContract, ExporterContract
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.exporters.meshes import GlbExporter, ObjExporter, PlyExporter, StlExporter
from driftform_frusta.exporters.scad import ScadExporter
from driftform_frusta.exporters.step import StepExporter
from driftform_frusta.exporters.svg import SvgExporter, SvgOptions
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.kit_options import PartOptions


class TestFrusta(BuilderContract):
    def plugin(self) -> FrustaBuilder:
        return FrustaBuilder(FrustaOptions())


class TestFrustaWithThePapersWall(BuilderContract):
    def plugin(self) -> FrustaBuilder:
        return FrustaBuilder(FrustaOptions(wall_model="paper"))


class TestFrustaWithAThickWall(BuilderContract):
    def plugin(self) -> FrustaBuilder:
        return FrustaBuilder(FrustaOptions(wall=0.003, min_radius=0.006, core_radius=0.015))


class TestFrustaAroundACapsule(BuilderContract):
    def plugin(self) -> FrustaBuilder:
        profile = ((0.0, 0.0), (0.0, 0.01), (0.003, 0.0125), (0.057, 0.0125), (0.06, 0.01), (0.06, 0.0))
        return FrustaBuilder(FrustaOptions(core_profile=profile, core_radius=0.0125, core_mass=0.02, core_cog=0.03))


class TestStl(ExporterContract):
    def plugin(self) -> StlExporter:
        return StlExporter(PartOptions())


class TestScad(ExporterContract):
    def plugin(self) -> ScadExporter:
        return ScadExporter(PartOptions())


class TestGlb(ExporterContract):
    def plugin(self) -> GlbExporter:
        return GlbExporter(PartOptions())


class TestObj(ExporterContract):
    def plugin(self) -> ObjExporter:
        return ObjExporter(PartOptions())


class TestPly(ExporterContract):
    def plugin(self) -> PlyExporter:
        return PlyExporter(PartOptions())


@pytest.mark.peers
class TestStep(ExporterContract):
    def plugin(self) -> StepExporter:
        return StepExporter(PartOptions())


class TestSvg(ExporterContract):
    def plugin(self) -> SvgExporter:
        return SvgExporter(SvgOptions())


class TestThreeMf(ExporterContract):
    def plugin(self) -> ThreeMfExporter:
        return ThreeMfExporter(PartOptions())
