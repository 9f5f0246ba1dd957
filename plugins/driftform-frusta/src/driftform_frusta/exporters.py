"""Agent -> files of its hull: a mesh for printers, source for OpenSCAD.

Files are in the printed frame of :mod:`driftform_frusta.hull`: millimetres, axis along z, fore end up, lowest
point at z = 0. A solid is written only after it was compared with the closed form of its section, because a
mesh with its cavity turned inside out is closed and manifold too, and only its volume tells.
"""

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from manifold3d import Manifold

from driftform.errors import WorkFailedError
from driftform.files import write_text
from driftform.interfaces import Exporter, Specimen
from driftform.options import Table
from driftform.types import Body, WrittenFile
from driftform_frusta.parts import PartOptions
from driftform_frusta.printable import MM3_PER_M3, printable_hull
from driftform_frusta.scad import to_scad
from driftform_frusta.stl import is_closed, signed_volume, surface_area, weld, write_binary_stl


class StlExporter(Exporter[PartOptions]):
    """The hull as a binary STL mesh, for slicers."""

    name = "stl"
    suffix = ".stl"
    Options: ClassVar[type[Table]] = PartOptions

    def write(self, specimen: Specimen, path: Path) -> tuple[WrittenFile, ...]:
        """Write the mesh, checked after rounding to the single precision that STL has.

        Facts: those of every solid (``volume_mm3`` and ``mass_kg`` of the mesh, ``size_mm``, ``shells``), its
        ``triangles``, and ``watertight``.

        Raises
        ------
        WorkFailedError
            where the body has no closed printable solid, or the file cannot be written.
        """
        body = specimen.agent.body
        _, solid, shells = printable_hull(body, self.options.segments)
        mesh = solid.to_mesh64()
        vertices, triangles = weld(mesh.vert_properties[:, :3], mesh.tri_verts)
        if not is_closed(triangles):
            raise WorkFailedError("the mesh of the hull does not stay closed in the single precision of STL")
        volume = signed_volume(vertices, triangles)
        # Rounding moves a vertex by half a unit in the last place at most, in each of three directions, and
        # so the volume by no more than the surface times that.
        rounding = (
            np.sqrt(3) / 2 * float(np.spacing(np.abs(vertices).max())) * surface_area(vertices, triangles)
        )
        if abs(volume - solid.volume()) > rounding:
            raise WorkFailedError(
                f"the mesh of the hull has {volume:.3f} mm3 in the single precision of STL, "
                f"its solid has {solid.volume():.3f} mm3"
            )
        try:
            write_binary_stl(path, vertices, triangles)
        except OSError as error:
            raise WorkFailedError(f"cannot write {path}: {error.strerror or error}") from error
        facts = _facts(body, solid, shells) | {
            "volume_mm3": volume,
            "mass_kg": volume / MM3_PER_M3 * body.hull_density,
            "triangles": len(triangles),
            "watertight": True,
        }
        return (WrittenFile(self.name, str(path), facts),)


class ScadExporter(Exporter[PartOptions]):
    """The hull as OpenSCAD source: its section, to be revolved."""

    name = "scad"
    suffix = ".scad"
    Options: ClassVar[type[Table]] = PartOptions

    def write(self, specimen: Specimen, path: Path) -> tuple[WrittenFile, ...]:
        """Write the source.

        Facts of what it renders to: ``volume_mm3``, ``mass_kg``, ``size_mm``, ``shells``.

        Raises
        ------
        WorkFailedError
            where the body has no closed printable solid, or the file cannot be written.
        """
        body = specimen.agent.body
        tree, solid, shells = printable_hull(body, self.options.segments)
        try:
            write_text(path, to_scad(tree, self.options.segments))
        except OSError as error:
            raise WorkFailedError(f"cannot write {path}: {error.strerror or error}") from error
        return (WrittenFile(self.name, str(path), _facts(body, solid, shells)),)


def _facts(body: Body, solid: Manifold, shells: int) -> dict[str, Any]:
    bounds = np.array(solid.bounding_box())
    return {
        "volume_mm3": solid.volume(),
        "mass_kg": solid.volume() / MM3_PER_M3 * body.hull_density,
        "size_mm": (bounds[3:] - bounds[:3]).tolist(),
        "shells": shells,
    }
