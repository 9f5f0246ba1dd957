"""Each checker keeps to the contract of its seam."""

from driftform.testing import CheckerContract
from driftform_kit.checks.admesh import AdmeshChecker, AdmeshOptions
from driftform_kit.checks.mesh import MeshChecker, MeshOptions
from driftform_kit.checks.openscad import OpenScadChecker, OpenScadOptions
from driftform_kit.checks.prusaslicer import PrusaSlicerChecker, PrusaSlicerOptions


class TestMesh(CheckerContract):
    def plugin(self) -> MeshChecker:
        return MeshChecker(MeshOptions())


class TestAdmesh(CheckerContract):
    def plugin(self) -> AdmeshChecker:
        return AdmeshChecker(AdmeshOptions())


class TestOpenScad(CheckerContract):
    def plugin(self) -> OpenScadChecker:
        return OpenScadChecker(OpenScadOptions())


class TestPrusaSlicer(CheckerContract):
    def plugin(self) -> PrusaSlicerChecker:
        # A cube is solid: filled as far as its walls, it has the filament of its volume.
        return PrusaSlicerChecker(PrusaSlicerOptions(infill=1.0, layer_height=0.0004))
