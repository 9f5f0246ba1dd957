"""Orientations of a part on the bed: its contact with the bed and its overhangs."""

from dataclasses import dataclass

import numpy as np

from driftform.types import FloatArray
from driftform_frusta.triangles import Mesh
from driftform_kit.checks.slenderness import FOOT, STEADY

MAX_OVERHANG = np.radians(45)
"""Overhang, from the vertical, that prints without support."""

_FIRST_LAYER = 0.05
"""mm: surfaces up to this height above the bed belong to the first layer."""

TURNS: dict[str, FloatArray] = {
    "as placed": np.eye(3),
    "upside down": np.diag([1.0, -1.0, -1.0]),
    "lying": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "on its other side": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
}
"""Rotations by name, for a part whose axis is along z."""


@dataclass(frozen=True, eq=False)
class Orientation:
    """One orientation of :data:`TURNS`: width, depth and height of the part (mm, (3,)), and areas, mm2.

    They are in ``contact`` with the bed, or ``overhang`` by more than :data:`MAX_OVERHANG`; of these some are ``enclosed`` in
    hollows, from which support cannot be removed.
    """

    name: str
    size: FloatArray
    contact: float
    overhang: float
    enclosed: float

    @property
    def steady(self) -> bool:
        """True if the contact with the bed holds it without a brim."""
        return self.contact >= max(FOOT, (STEADY * float(self.size[2])) ** 2)

    def fits(self, bed: FloatArray) -> bool:
        """Return whether it fits a bed (mm, (3,)), turned about the vertical by a right angle if necessary."""
        across, along = sorted(self.size[:2]), sorted(bed[:2])
        room = 1e-6 * float(bed.max())
        return bool((np.array([*across, self.size[2]]) <= np.array([*along, bed[2]]) + room).all())


def list_orientations(mesh: Mesh, hollow: int = 0) -> tuple[Orientation, ...]:
    """Return the orientations of a mesh, mm, that faces outward; its last ``hollow`` triangles are walls of closed hollows."""
    triangles, normals = mesh.triangles, mesh.area_vectors
    area = np.linalg.norm(normals, axis=1)
    sound = area > 0
    normals, area, corners = normals[sound] / area[sound, None], area[sound], triangles[sound]
    enclosed = (np.arange(len(triangles)) >= len(triangles) - hollow)[sound]
    found = []
    for name, turn in TURNS.items():
        turned = mesh.vertices @ turn.T
        lowest, highest = turned.min(axis=0), turned.max(axis=0)
        down = -(normals @ turn.T)[:, 2]
        on_bed = (turned[corners, 2] <= lowest[2] + _FIRST_LAYER).all(axis=1)
        # A hundredth of a degree more, so that rounding does not make a slope of exactly 45 degrees an overhang.
        hanging = (down > np.sin(MAX_OVERHANG + 2e-4)) & ~on_bed
        found.append(
            Orientation(
                name=name,
                size=highest - lowest,
                contact=float((area * down)[on_bed & (down > 0)].sum()),
                overhang=float(area[hanging].sum()),
                enclosed=float(area[hanging & enclosed].sum()),
            )
        )
    return tuple(found)


def choose_orientation(found: tuple[Orientation, ...], bed: FloatArray) -> Orientation:
    """Return the orientation that fits the bed, is steady, and overhangs least; the first of those equal within 1 %."""
    return min(found, key=lambda each: _rank(each, found, bed))


def prints_upside_down(mesh: Mesh) -> bool:
    """Return whether a part that stands on the bed, mm, is better turned over; of two equal ends the bed takes the larger."""
    found = list_orientations(mesh)
    as_placed, turned = ((*_rank(each, found, each.size), -round(each.contact, 1)) for each in found[:2])
    return turned < as_placed


def _rank(each: Orientation, found: tuple[Orientation, ...], bed: FloatArray) -> tuple[bool, bool, int]:
    least = min(other.overhang for other in found)
    slack = 0.01 * max(least, 10.0)
    return not each.fits(bed), not each.steady, round((each.overhang - least) / slack)
