from driftform.testing import BuilderContract, ExporterContract
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.exporters import ScadExporter, StlExporter
from driftform_frusta.parts import PartOptions


class TestFrusta(BuilderContract):
    def plugin(self) -> FrustaBuilder:
        return FrustaBuilder(FrustaOptions())


class TestFrustaWithThePapersWall(BuilderContract):
    def plugin(self) -> FrustaBuilder:
        return FrustaBuilder(FrustaOptions(wall_model="paper"))


class TestFrustaWithAThickWall(BuilderContract):
    def plugin(self) -> FrustaBuilder:
        return FrustaBuilder(FrustaOptions(wall=0.003, min_radius=0.006, core_radius=0.015))


class TestStl(ExporterContract):
    def plugin(self) -> StlExporter:
        return StlExporter(PartOptions())


class TestScad(ExporterContract):
    def plugin(self) -> ScadExporter:
        return ScadExporter(PartOptions())
