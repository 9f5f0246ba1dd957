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
from driftform.geometry import distance_from, hull_volume
from driftform.interfaces import Exporter, Specimen
from driftform.options import Table, option
from driftform.types import Body, WrittenFile
from driftform_frusta.csg import Node
from driftform_frusta.hull import hull
from driftform_frusta.scad import to_scad
from driftform_frusta.solid import to_manifold
from driftform_frusta.stl import is_closed, signed_volume, surface_area, weld, write_binary_stl

_MM3_PER_M3 = 1e9

# Relative, between the mesh in double precision and the closed form.
_VOLUME_TOLERANCE = 1e-6

# m: a wall thinner than this is none.
_NO_WALL = 1e-6


class MeshOptions(Table):
    """How finely circles are divided."""

    segments: int = option(64, "corners of every circle of the mesh", ge=12, le=1024)


class StlExporter(Exporter[MeshOptions]):
    """The hull as a binary STL mesh, for slicers."""

    name = "stl"
    suffix = ".stl"
    Options: ClassVar[type[Table]] = MeshOptions

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
            "mass_kg": volume / _MM3_PER_M3 * body.hull_density,
            "triangles": len(triangles),
            "watertight": True,
        }
        return (WrittenFile(self.name, str(path), facts),)


class ScadExporter(Exporter[MeshOptions]):
    """The hull as OpenSCAD source: its section, to be revolved."""

    name = "scad"
    suffix = ".scad"
    Options: ClassVar[type[Table]] = MeshOptions

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


def printable_hull(body: Body, segments: int) -> tuple[Node, Manifold, int]:
    """Return the hull's tree, its solid, and how many closed surfaces that has: the outside and each hollow.

    The solid is checked: it is manifold, in one piece, and of the section's volume. A sealed hull has two
    surfaces.

    Raises
    ------
    WorkFailedError
        where the body has no such solid; the message tells why.
    """
    tree = hull(body)
    _refuse_without_wall(body)
    _refuse_pinched(body)
    solid = to_manifold(tree, segments)
    expected = hull_volume(body) * _MM3_PER_M3
    if not abs(solid.volume() - expected) <= _VOLUME_TOLERANCE * expected:
        raise WorkFailedError(
            f"the solid of the hull has {solid.volume():.3f} mm3, its section {expected:.3f} mm3: a contour "
            "crosses itself or the axis, or the cavity leaves the outer contour"
        )
    # Surfaces of hollows face inward: their volume is negative.
    shells = solid.decompose()
    pieces = sum(shell.volume() > 0 for shell in shells)
    if pieces != 1:
        raise WorkFailedError(f"the hull falls into {pieces} pieces")
    return tree, solid, len(shells)


def _facts(body: Body, solid: Manifold, shells: int) -> dict[str, Any]:
    bounds = np.array(solid.bounding_box())
    return {
        "volume_mm3": solid.volume(),
        "mass_kg": solid.volume() / _MM3_PER_M3 * body.hull_density,
        "size_mm": (bounds[3:] - bounds[:3]).tolist(),
        "shells": shells,
    }


def _refuse_without_wall(body: Body) -> None:
    if not len(body.cavity):
        return
    to_outer = distance_from(body.cavity, body.outer)
    to_cavity = distance_from(body.outer, body.cavity)
    if min(to_outer.min(), to_cavity.min()) >= _NO_WALL:
        return
    points, distances = (
        (body.cavity, to_outer) if to_outer.min() <= to_cavity.min() else (body.outer, to_cavity)
    )
    x = float(points[np.argmin(distances), 0])
    ends = (("aft", body.outer[0, 0]), ("fore", body.outer[-1, 0]))
    where = next((f"at its {name} end" for name, end in ends if abs(x - end) < _NO_WALL), f"at x = {x:.6f} m")
    raise WorkFailedError(
        f"the hull has no closed printable solid: the cavity touches the outer contour {where}, so that the "
        "hull is open there; give it a wall all round, and caps at its ends"
    )


def _refuse_pinched(body: Body) -> None:
    off_axis = np.flatnonzero(body.outer[:, 1] > _NO_WALL)
    gaps = np.flatnonzero(np.diff(off_axis) > 1)
    if len(gaps):
        x = body.outer[off_axis[gaps[0]] + 1, 0]
        raise WorkFailedError(
            f"the hull is no one printable part: its outer contour touches the axis at x = {x:.6f} m"
        )
