"""Meshes: STL and PLY for one solid; OBJ, whose parts are groups; and GLB, the binary form of glTF 2.0.

Formats: 3D Systems, "StereoLithography Interface Specification" (1989); G. Turk, "The PLY Polygon File Format" (1994);
Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1; Khronos Group, "glTF 2.0
Specification" (ISO/IEC 12113:2022), sections 3 and 4.
"""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from driftform.types import FloatArray
from driftform_frusta.colours import colour_of, decode_srgb
from driftform_frusta.exporters.base import JoinedFile, PartFiles
from driftform_frusta.triangles import Mesh, write_obj

FRAME = 1e-3 * np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""From the printed frame, mm with z up, to that of glTF, m with y up: a turn by -90 degrees about x."""


class StlExporter(PartFiles):
    """The hull as a binary STL mesh, for slicers, in mm; several parts are several files, each upright."""

    name = "stl"
    suffix = ".stl"

    def encode(self, mesh: Mesh) -> bytes:
        """Return loose triangles with their normals."""
        return mesh.to_stl()


class PlyExporter(PartFiles):
    """The hull as a binary PLY mesh, in mm, oriented as in STL; several parts are several files."""

    name = "ply"
    suffix = ".ply"

    def encode(self, mesh: Mesh) -> bytes:
        """Return the mesh with its vertices shared."""
        import trimesh
        from trimesh.exchange.ply import export_ply

        made = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        return bytes(export_ply(made, vertex_normal=False))


class ObjExporter(JoinedFile):
    """The hull as an OBJ mesh in mm, an object for each part at its place in the assembled hull; without colours."""

    name = "obj"
    suffix = ".obj"

    def encode(self, title: str, meshes: Mapping[str, Mesh]) -> str:
        """Return the objects; OBJ has no place for a title."""
        return write_obj(meshes, "mm")


class GlbExporter(JoinedFile):
    """The hull as GLB (glTF 2.0) in metres with y up, a named node for each part at its place in the hull."""

    name = "glb"
    suffix = ".glb"
    frame: ClassVar[FloatArray | None] = FRAME

    def encode(self, title: str, meshes: Mapping[str, Mesh]) -> bytes:
        """Return the scene; its title has no place in what trimesh writes.

        Normals are left out: a viewer then shades each triangle flat, as the printed facets are.
        """
        import trimesh

        scene: Any = trimesh.Scene()
        visual: Any = trimesh.visual
        for index, (name, mesh) in enumerate(meshes.items()):
            material = visual.material.PBRMaterial(
                name=name,
                baseColorFactor=[*decode_srgb(colour_of(index)), 1.0],
                metallicFactor=0.0,
                roughnessFactor=0.8,
            )
            look = visual.TextureVisuals(material=material)
            part = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False, visual=look)
            scene.add_geometry(part, node_name=name, geom_name=name)
        return bytes(scene.export(file_type="glb", include_normals=False))
