"""Parts of a pipe -> one mesh of its wall, for display: tubes, and junctions with their rounded edge."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray
from driftform.water import Pipe
from driftform.water.parts import shapes
from driftform_frusta.triangles import Mesh
from driftform_robotics.models.meshes import SEGMENTS

STEP = math.pi / SEGMENTS
"""Angle between two rings of a bend, rad: half of that between two corners of a ring, as the bend's radius is larger."""

RINGS = 32
"""Number of steps along a reducer, and across the wall of a run from the edge of a junction to its ends."""

ARC = 8
"""Number of steps around the rounded edge of a junction."""

_WELD = 1e-7
"""Corners closer than this are one, in radii of the narrowest bore."""


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of the bore as a grid of points.

    Attributes:
        points, normals: local frame of the part, m, and unit vectors into the wall, (n, m, 3).
        ends: by the row of points that lies at an opening, 0 or -1, the direction out of the part there, (3,).
    """

    points: FloatArray
    normals: FloatArray
    ends: dict[int, FloatArray]


def make_parts_mesh(pipe: Pipe, thickness: float) -> Mesh:
    """Return the walls of all parts, each a closed mesh, in the world frame; ``thickness`` in m."""
    vertices: list[FloatArray] = []
    triangles: list[npt.NDArray[np.int64]] = []
    for placed in pipe.layout.parts:
        part = placed.part
        thinner = min(thickness, 0.5 * part.fillet) if isinstance(part, shapes.Tee) else thickness
        mesh = _make_part(part, thinner)
        triangles.append(mesh.triangles + sum(map(len, vertices)))
        vertices.append(part.to_world(mesh.vertices))
    return Mesh(np.concatenate(vertices), np.concatenate(triangles))


def _make_part(part: shapes.PipePart, thickness: float) -> Mesh:
    """Return the wall of a part in its local frame: the bore, the same moved into the wall, and a ring at each opening."""
    corners = []
    for patch in _tee_patches(part) if isinstance(part, shapes.Tee) else [_tube_patch(part)]:
        outside = patch.points + thickness * patch.normals
        corners += [_face(patch.points, -patch.normals), _face(outside, patch.normals)]
        for row, direction in patch.ends.items():
            ring = np.stack([patch.points[row], outside[row]])
            corners.append(_face(ring, np.broadcast_to(direction, ring.shape)))
    return _weld(np.concatenate(corners), _WELD * part.radius)


def _tube_patch(part: shapes.PipePart) -> Patch:
    """Return the bore of a straight, a bend or a reducer."""
    angles = np.linspace(0, 2 * np.pi, SEGMENTS + 1)
    match part:
        case shapes.Bend():
            turn = np.linspace(0, part.angle, 1 + max(1, math.ceil(part.angle / STEP)))
            radii = np.full(len(turn), part.radius)
            feet = part.bend_radius * np.column_stack([np.sin(turn), 0 * turn, 1 - np.cos(turn)])
        case shapes.Reducer():
            x = np.linspace(0, part.taper, 1 + RINGS)
            turn, radii, feet = 0 * x, part.bore_radii(x), np.column_stack([x, 0 * x, 0 * x])
        case _:
            turn, radii = np.zeros(2), np.full(2, part.radius)
            feet = np.array([[0.0, 0.0, 0.0], [part.length, 0.0, 0.0]])
    up = np.column_stack([-np.sin(turn), 0 * turn, np.cos(turn)])
    along = np.column_stack([np.cos(turn), 0 * turn, np.sin(turn)])
    normals = np.cos(angles)[:, None] * up[:, None] + np.sin(angles)[:, None] * [0.0, 1.0, 0.0]
    points = feet[:, None] + radii[:, None, None] * normals
    return Patch(points, normals, {0: -along[0], -1: along[-1]})


def _tee_patches(part: shapes.Tee) -> list[Patch]:
    """Return the run of a tee around its mouth, the rounded edge, and the branch.

    All three are grids over the angle ``phi`` of the rolling ball about the axis of the branch, 0 on the downstream side.
    """
    c, s = math.cos(part.angle), math.sin(part.angle)
    R, b, f = part.radius, part.branch_radius, part.fillet
    upstream, downstream, side = part.legs
    ray = np.array([c, 0.0, s])

    def roll(phi: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the centres of the ball, and where it touches the run and the branch, (k, 3) each."""
        near, aside = (b + f) * np.cos(phi), (b + f) * np.sin(phi)
        t = (np.sqrt(np.maximum((R + f) ** 2 - aside**2, 0.0)) + near * c) / s
        centres = np.column_stack([t * c + near * s, aside, t * s - near * c])
        on_run = centres * [1.0, R / (R + f), R / (R + f)]
        feet = t[:, None] * ray
        return centres, on_run, feet + b / (b + f) * (centres - feet)

    # The wall of the run, unrolled: x, and the arc from the crown. Rays lead from the mouth to the ends and to the bottom.
    fine = np.linspace(-np.pi, np.pi, 2049)
    mouth = _unroll(roll(fine)[1], R)
    middle = 0.5 * (mouth[:, 0].min() + mouth[:, 0].max())
    bearing = np.unwrap(np.arctan2(mouth[:, 1], mouth[:, 0] - middle))
    bearing -= bearing[len(fine) // 2]
    even = np.linspace(-np.pi, np.pi, SEGMENTS + 1)
    turns = [np.interp(np.arctan2(R * even, x), bearing, fine) for x in (downstream - middle, -upstream - middle)]
    phi = np.unique(np.concatenate([even, *turns]))

    centres, on_run, on_branch = roll(phi)
    edge = _unroll(on_run, R)
    rays = edge - [middle, 0.0]
    with np.errstate(divide="ignore"):
        reach = np.minimum(
            np.where(rays[:, 0] > 0, downstream - middle, upstream + middle) / np.abs(rays[:, 0]),
            np.pi * R / np.abs(rays[:, 1]),
        )
    far = [middle, 0.0] + reach[:, None] * rays
    ends = np.where(rays[:, 0] > 0, downstream, -upstream)
    corner = np.isin(phi, [t[k] for t in turns for k in (0, -1)])[:, None]
    far = np.where(corner, np.column_stack([ends, np.copysign(np.pi * R, rays[:, 1])]), far)
    share = np.linspace(0, 1, RINGS + 1)[:, None, None]
    x, arc = np.moveaxis((1 - share) * edge + share * far, -1, 0)
    out = np.stack([0 * arc, np.sin(arc / R), np.cos(arc / R)], axis=-1)
    run = Patch(np.stack([x, 0 * x, 0 * x], axis=-1) + R * out, out, {})

    start, end = (on_run - centres) / f, (on_branch - centres) / f
    angle = np.arccos(np.clip((start * end).sum(axis=1), -1, 1))
    share = np.linspace(0, 1, ARC + 1)[:, None]
    sine = np.maximum(np.sin(angle), 1e-12)
    first, last = np.sin((1 - share) * angle) / sine, np.sin(share * angle) / sine
    flat = angle < 1e-6
    first, last = np.where(flat, 1 - share, first), np.where(flat, share, last)
    inward = first[..., None] * start + last[..., None] * end
    rounding = Patch(centres + f * inward, -inward, {})

    outward = (on_branch - (on_branch @ ray)[:, None] * ray) / b
    tube = np.stack([on_branch, side * ray + b * outward])
    branch = Patch(tube, np.stack([outward, outward]), {-1: ray})
    return [run, rounding, branch, *_run_ends(part, phi, far)]


def _run_ends(part: shapes.Tee, phi: FloatArray, far: FloatArray) -> list[Patch]:
    """Return the two ends of the run of a tee, as patches without width, for their rings; ``far`` is where the rays end, (k, 2)."""
    patches = []
    for x, direction in ((-part.legs[0], -1.0), (part.legs[1], 1.0)):
        # The rays that end there, in the order of the angle about the run's axis.
        arcs = np.unique(far[np.abs(far[:, 0] - x) < 1e-9 * part.radius, 1]) / part.radius
        out = np.column_stack([0 * arcs, np.sin(arcs), np.cos(arcs)])
        points = part.radius * out + [x, 0.0, 0.0]
        axis = np.array([direction, 0.0, 0.0])
        patches.append(Patch(points[None], out[None], {0: axis}))
    return patches


def _unroll(points: FloatArray, radius: float) -> FloatArray:
    """Return x, and the arc from the crown, of points of a cylinder about the x axis, m, (k, 2)."""
    return np.column_stack([points[:, 0], radius * np.arctan2(points[:, 1], points[:, 2])])


def _face(grid: FloatArray, towards: FloatArray) -> FloatArray:
    """Return the triangles of a grid of points (n, m, 3), which face ``towards`` (n, m, 3), as their corners, (k, 3, 3)."""
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    corners = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 3)
    side = np.stack([towards[:-1, :-1] + towards[1:, 1:]] * 2).reshape(-1, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    back = (normals * side).sum(axis=1) < 0
    corners[back] = corners[back][:, ::-1]
    return corners


def _weld(corners: FloatArray, distance: float) -> Mesh:
    """Return the mesh of triangles given by their corners (k, 3, 3), without those that have no area."""
    keys = np.rint(corners.reshape(-1, 3) / distance).astype(np.int64)
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    triangles = index.reshape(-1, 3)
    a, b, c = triangles.T
    kept = (a != b) & (b != c) & (c != a)
    return Mesh(corners.reshape(-1, 3)[first], triangles[kept])
