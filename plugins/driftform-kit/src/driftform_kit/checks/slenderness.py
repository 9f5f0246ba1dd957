"""Whether a part resists the push of the nozzle: as a beam that is clamped to the bed by its first layer.

A nozzle pushes the part sideways wherever material has curled up or leaked. At the top, where its lever is longest, a
push F bends a part of height H by

    F int (H - z)^2 / (E I(z)) dz

(Euler and Bernoulli), stresses the section at z by F (H - z) / W(z), and its adhesion to the bed by F H / W(0), with the
second moment of area I and the section modulus W = I / c, in whichever direction is weakest. A layer that lands half a
line off the one below holds on by half its width.

The push, the strength and the adhesion are those by which PrusaSlicer decides where a part needs support
(``SupportSpotsGenerator.hpp``): 10 gram-force, and 65 more where material has curled; 33 MPa, the yield strength of ABS;
an adhesion to the bed of 0.1 MPa for ABS, 0.02 MPa for PLA and 0.3 MPa for PETG.
"""

from dataclasses import dataclass

import numpy as np
from manifold3d import CrossSection, Error, JoinType

from driftform_frusta.solid import integrate_solid
from driftform_frusta.triangles import Mesh

_STATIONS = 160
"""Sections over the height of a part."""

_FIRST = 0.1
"""mm: height of the section that sticks to the bed, the middle of the first layer."""

PUSH, ADHESION = 0.098, 1e5
"""N and Pa: the push of a nozzle, and the adhesion of ABS."""

FOOT, STEADY = 10.0, 0.1
"""mm2 of contact with the bed, and its least root over the height, below which a part falls over."""

BRIMS = (0.0, 3.0, 5.0, 8.0, 12.0, 16.0)
"""Widths of brims, mm."""

_TIP = 0.05
"""Share of the height below the top that does not count as a neck: pointed tips are thin, but have no lever."""


@dataclass(frozen=True)
class Slenderness:
    """A part as a beam on the bed; lengths in mm, forces in N, for the material that it was computed for.

    ``base`` is the least width of its first layer, ``neck`` that of the section with the greatest stress. A push at the top
    bends it by ``bending`` mm/N; the neck yields under ``break_force``, and ``lift_force`` lifts it off the bed.
    """

    height: float
    base: float
    neck: float
    neck_height: float
    bending: float
    break_force: float
    lift_force: float


def measure_slenderness(mesh: Mesh, stiffness: float, strength: float, adhesion: float) -> Slenderness | None:
    """Return how slender a part is as placed, mm, with z up; ``None`` if it is not a solid, or not higher than its first layer.

    The mesh faces outward, and into its hollows. Stiffness and yield strength are those of the material, and the adhesion
    is the stress at which it comes off the bed; Pa.
    """
    solid = mesh.to_manifold()
    low, high = mesh.bounds[:, 2].tolist()
    height = high - low
    if solid.status() != Error.NoError or height <= 2 * _FIRST:
        return None
    # Middles of equal steps, which no flat face is in, but the first.
    step = (height - _FIRST) / _STATIONS
    z = np.concatenate(([_FIRST], _FIRST + (np.arange(_STATIONS) + 0.5) * step))
    sections = [measure_section(solid.slice(low + at)) for at in z.tolist()]
    if any(second <= 0 for second, _ in sections):
        return None
    second, width = np.array(sections).T
    modulus = second / (width / 2)
    lever = height - z
    # Pa are N/m2: 1e-6 N/mm2.
    weakest = int(np.argmax(np.where(lever > _TIP * height, lever / modulus, 0.0)))
    return Slenderness(
        height=height,
        base=float(width[0]),
        neck=float(width[weakest]),
        neck_height=float(z[weakest]),
        bending=float((lever[1:] ** 2 / second[1:]).sum() * step / (1e-6 * stiffness)),
        break_force=1e-6 * strength * float(modulus[weakest] / lever[weakest]),
        lift_force=1e-6 * adhesion * float(modulus[0]) / height,
    )


def find_brim(mesh: Mesh, push: float = PUSH, adhesion: float = ADHESION) -> float:
    """Return the width of the brim (mm) with which a part, as placed, is steady and not pushed off the bed (N, Pa).

    It is the least of :data:`BRIMS` that does, 0 if the part needs none, and the widest if none is enough.
    """
    low, high = mesh.bounds[:, 2].tolist()
    solid = mesh.to_manifold()
    foot = solid.slice(low + _FIRST)
    # A rounded foot touches the bed with less than it has in the middle of the first layer.
    lacks = max(FOOT, (STEADY * (high - low)) ** 2) - solid.slice(low + _FIRST / 2).area()
    for width in BRIMS:
        around = foot.offset(width, JoinType.Round) if width else foot
        second, across = measure_section(around)
        lifted = second <= 0 or 1e-6 * adhesion * 2 * second / across / (high - low) < push
        if not lifted and around.area() - foot.area() >= lacks:
            break
    return width


def measure_section(section: CrossSection) -> tuple[float, float]:
    """Return the least second moment of area of a section (mm4), and its width across that direction (mm); 0 if empty."""
    rings = [np.asarray(ring, dtype=np.float64) for ring in section.to_polygons()]
    if not rings:
        return 0.0, 0.0
    integrals = integrate_solid(section.extrude(1.0))
    centre = integrals[0, 1:3] / integrals[0, 0]
    values, axes = np.linalg.eigh(integrals[1:3, 1:3] - integrals[0, 0] * np.outer(centre, centre))
    across = (np.concatenate(rings) - centre) @ axes[:, 0]
    return float(values[0]), 2 * float(np.abs(across).max())
