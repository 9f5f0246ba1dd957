import pytest

from driftform.testing import ExporterContract
from driftform_robotics.models.exporter import ModelOptions
from driftform_robotics.models.fossen import FossenExporter, WaterOptions
from driftform_robotics.models.mjcf import MjcfExporter
from driftform_robotics.models.sdf import SdfExporter, SdfOptions
from driftform_robotics.models.urdf import UrdfExporter, UrdfOptions
from driftform_robotics.models.uuv import UuvExporter, UuvOptions


class TestSdf(ExporterContract):
    def plugin(self) -> SdfExporter:
        return SdfExporter(SdfOptions())


class TestSdfForFortress(ExporterContract):
    def plugin(self) -> SdfExporter:
        return SdfExporter(SdfOptions(gazebo="fortress"))


class TestUuv(ExporterContract):
    def plugin(self) -> UuvExporter:
        return UuvExporter(UuvOptions())


class TestUrdf(ExporterContract):
    def plugin(self) -> UrdfExporter:
        return UrdfExporter(UrdfOptions())


class TestMjcf(ExporterContract):
    def plugin(self) -> MjcfExporter:
        return MjcfExporter(ModelOptions())


class TestFossen(ExporterContract):
    def plugin(self) -> FossenExporter:
        return FossenExporter(WaterOptions())


@pytest.mark.parametrize("plugin", [SdfExporter, UuvExporter, UrdfExporter, MjcfExporter])
def test_a_format_is_a_folder(plugin: type) -> None:
    assert plugin.suffix == f"-{plugin.name}"
