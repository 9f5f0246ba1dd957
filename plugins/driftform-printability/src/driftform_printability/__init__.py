"""Checks of printable files, by their meshes and by the programs of a maker, as driftform plugins."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Checker


@hookimpl
def driftform_checker() -> "list[type[Checker[Any]]]":
    """Checks of the meshes, by their triangles and by OpenSCAD, PrusaSlicer and admesh."""
    from driftform_printability.admesh import AdmeshChecker
    from driftform_printability.mesh import MeshChecker
    from driftform_printability.openscad import OpenScadChecker
    from driftform_printability.prusaslicer import PrusaSlicerChecker

    return [MeshChecker, OpenScadChecker, PrusaSlicerChecker, AdmeshChecker]
