"""CSG tree -> boundary representation by Open CASCADE: true circles, cones and spheres instead of facets.

Needs the extra ``step``; Open CASCADE is imported inside functions, because that takes seconds.
"""

import math
from collections.abc import Sequence
from typing import Any, assert_never

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_frusta import csg
from driftform_frusta.csg import Node
from driftform_frusta.solid import half_section


def require_opencascade() -> None:
    """Check that Open CASCADE is installed.

    Raises WorkFailedError if it is not; the message has the command that installs it.
    """
    try:
        import OCP.gp  # noqa: F401
    except ImportError:
        raise WorkFailedError(
            'STEP files need Open CASCADE, which is not installed; run: uv sync --extra step, or pip install "driftform[step]"'
        ) from None


def to_brep(node: Node) -> Any:
    """Return the solid of a tree as an Open CASCADE shape, mm.

    Raises WorkFailedError if the result is not valid.
    """
    from OCP.BRepCheck import BRepCheck_Analyzer

    shape = _interpret(node)
    if not BRepCheck_Analyzer(shape).IsValid():
        raise WorkFailedError("the solid has no valid boundary representation")
    return shape


def volume_of(shape: Any) -> float:
    """Return the volume of a shape, mm3; negative if it is inside out."""
    return _measure(shape, "Volume")


def _measure(shape: Any, what: str) -> float:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    getattr(BRepGProp, f"{what}Properties_s")(shape, properties)
    return float(properties.Mass())


def _interpret(node: Node) -> Any:
    match node:
        case csg.Revolve():
            shape = _revolve(half_section(node), math.radians(node.angle_deg), node.rise)
        case csg.Extrude():
            shape = _extrude(node)
        case csg.Union():
            shape = _combine("Fuse", [_interpret(child) for child in node.children])
        case csg.Difference():
            shape = _combine("Cut", [_interpret(child) for child in (node.base, *node.tools)])
        case csg.Intersection():
            shape = _combine("Common", [_interpret(child) for child in node.children])
        case csg.Translate() | csg.Rotate():
            shape = _move(node)
        case _:
            assert_never(node)
    return shape


def _combine(operation: str, shapes: Sequence[Any]) -> Any:
    from OCP import BRepAlgoAPI

    result = shapes[0]
    for shape in shapes[1:]:
        done = getattr(BRepAlgoAPI, f"BRepAlgoAPI_{operation}")(result, shape)
        if not done.IsDone():
            raise WorkFailedError("Open CASCADE cannot combine the parts of the solid")
        result = done.Shape()
    return result


def _move(node: csg.Translate | csg.Rotate) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec

    transform = gp_Trsf()
    if isinstance(node, csg.Translate):
        transform.SetTranslation(gp_Vec(*node.offset))
    else:
        for axis, angle in zip(np.eye(3).tolist(), np.deg2rad(node.angles_deg).tolist(), strict=True):
            turn = gp_Trsf()
            turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(*axis)), angle)
            transform.PreMultiply(turn)
    return BRepBuilderAPI_Transform(_interpret(node.child), transform, True).Shape()


def _revolve(polygons: Sequence[FloatArray], angle: float, rise: float) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt

    axis = gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    face = _make_face([np.column_stack([p[:, 0], np.zeros(len(p)), p[:, 1]]) for p in polygons])
    return _turn_outside_out(_wind(face, angle, rise) if rise else BRepPrimAPI_MakeRevol(face, axis, angle).Shape())


def _wind(face: Any, angle: float, rise: float) -> Any:
    """The solid that a face sweeps while it turns and rises: along a helix."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
    from OCP.BRepLib import BRepLib
    from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipeShell
    from OCP.BRepTools import BRepTools
    from OCP.Geom import Geom_CylindricalSurface
    from OCP.Geom2d import Geom2d_Line
    from OCP.gp import gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d

    cylinder = Geom_CylindricalSurface(gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), 1.0)
    line = Geom2d_Line(gp_Pnt2d(0, 0), gp_Dir2d(angle, rise))
    helix = BRepBuilderAPI_MakeEdge(line, cylinder, 0.0, math.hypot(angle, rise)).Edge()
    BRepLib.BuildCurves3d_s(helix)
    pipe = BRepOffsetAPI_MakePipeShell(BRepBuilderAPI_MakeWire(helix).Wire())
    pipe.SetMode(gp_Dir(0, 0, 1))
    pipe.Add(BRepTools.OuterWire_s(face))
    pipe.Build()
    pipe.MakeSolid()
    return pipe.Shape()


def _extrude(node: csg.Extrude) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Vec

    face = _make_face([np.column_stack([p, np.zeros(len(p))]) for p in map(np.array, (node.outline, *node.holes))])
    return _turn_outside_out(BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, node.height)).Shape())


def _make_face(polygons: Sequence[FloatArray]) -> Any:
    """Faces in one plane between closed polygons of (n, 3); what an odd number of them surrounds is inside."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.gp import gp_Pnt

    def face(polygon: FloatArray) -> Any:
        wire = BRepBuilderAPI_MakePolygon()
        for point in polygon.tolist():
            wire.Add(gp_Pnt(*point))
        wire.Close()
        return BRepBuilderAPI_MakeFace(wire.Wire(), True).Face()

    def area(polygon: FloatArray) -> float:
        return float(np.linalg.norm(np.cross(polygon, np.roll(polygon, -1, axis=0)).sum(axis=0)))

    result: Any = None
    for polygon in sorted(polygons, key=area, reverse=True):
        if result is None:
            result = face(polygon)
            continue
        common = _combine("Common", [result, face(polygon)])
        operation = "Cut" if _measure(common, "Surface") > 0 else "Fuse"
        result = _combine(operation, [result, face(polygon)])
    return result


def _turn_outside_out(shape: Any) -> Any:
    """The shape with its outside out: which way a face is swept depends on its sense of rotation."""
    return shape if volume_of(shape) > 0 else shape.Reversed()
