"""What a sealed hull withstands from outside: formulas of its parts, and the parts of a body.

Pressures are gauge, Pa, and higher outside; radii are those of the outer surface, m. A wall yields where the greatest stress
of elastic theory reaches the strength. It buckles at the classical pressure of a perfect shell times a knock-down. Sources:

- Lame: S. P. Timoshenko and J. N. Goodier, Theory of Elasticity, on thick cylinders and spheres; walls of any thickness.
- von Mises 1929, in D. F. Windenburg and C. Trilling, Trans. ASME 56 (1934) 819.
- SP-8007, SP-8019, SP-8032: NASA's design criteria for buckling of cylinders, cones and doubly curved shells, 1968 and 1969.
- S. P. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells, on round plates and long tubes.
"""

import math
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from driftform.agent import distance_from
from driftform.types import Body, FloatArray
from driftform.water import Fluid
from driftform_frusta.materials import MATERIALS, Material, find_material
from driftform_frusta.pockets import cut_end

KNOCK_DOWN = 0.75
"""Pressure at which cylinders and cones buckle, over that of perfect ones (SP-8007, SP-8019)."""

NECK = 0.7
"""A part that is narrower than this share of another holds that one round: it ends the length that buckles."""


def cylinder_yield(material: Material, radius: FloatArray, wall: FloatArray) -> FloatArray:
    """Return the pressure at which the bore of a closed cylinder yields: its stress is 2 p / (1 - (1 - t/R)^2) (Lame)."""
    return np.asarray(material.creep * material.across * (1 - (1 - wall / radius) ** 2) / 2)


def sphere_yield(material: Material, radius: FloatArray, wall: FloatArray) -> FloatArray:
    """Return the pressure at which the inside of a sphere yields: its stress is 3/2 p / (1 - (1 - t/R)^3) (Lame)."""
    return np.asarray(material.creep * material.across * (1 - (1 - wall / radius) ** 3) / 1.5)


def cylinder_buckling(material: Material, radius: FloatArray, wall: FloatArray, length: FloatArray) -> FloatArray:
    """Return the pressure at which a perfect closed cylinder buckles between ends that stay round (von Mises).

    A cone with tilts up to 75 degrees is the cylinder of its slant length, and of its mean radius over the cosine of its tilt
    (SP-8019). The radius is that of the middle of the wall, which is up to a fifth of it thick; of any length.
    """
    lobes = np.arange(2, 41)[:, None]
    wave, bending = np.pi * radius / length, (wall / radius) ** 2 / (12 * (1 - material.poisson**2))
    shape = (lobes**2 / wave**2 + 1.0) ** -2 + bending * (lobes**2 - 1 + wave**2) ** 2
    pressures = material.creep * material.modulus * wall / radius * shape / (lobes**2 - 1 + wave**2 / 2)
    return np.asarray(pressures.min(axis=0))


def sphere_buckling(material: Material, radius: FloatArray, wall: FloatArray) -> FloatArray:
    """Return the pressure at which a sphere buckles: Zoelly's, knocked down (SP-8032, lambda from 2); radius of the middle."""
    slope = np.sqrt(12 * (1 - material.poisson**2))
    knock_down = np.minimum(0.14 + 0.8 * wall / radius / slope, 1.0)
    return np.asarray(knock_down * 4 * material.creep * material.modulus * (wall / radius) ** 2 / slope)


def hold_rim(material: Material, radius: float, plate: float, wall: float) -> float:
    """Return the moment by which a tube holds the rim of a plate that closes it, over that of a clamped rim, 0 to 1."""
    return float(1 / (1 + (plate / wall) ** 3 * (1 + material.poisson) / (2 * _decay(material, radius / wall))))


def plate_yield(material: Material, radius: float, plate: float, held: float = 1.0) -> float:
    """Return the pressure at which a flat round plate yields at its rim or in its middle; ``held`` as by :func:`hold_rim`.

    Clamped, its stress is 3/4 p (R/t)^2, and free to turn 3/8 (3 + nu) p (R/t)^2. Plates up to a third of the radius thick; for
    skins, which bend by more than half their thickness, the pressure is too low.
    """
    stress = max(0.75 * held, 0.375 * (3 + material.poisson - 2 * held)) * (radius / plate) ** 2
    return material.creep * material.across / stress


def rim_yield(material: Material, radius: float, wall: float, held: float, across: float) -> float:
    """Return the pressure at which a long tube yields at a plate of a radius ``across`` that bends it, and keeps its edge round."""
    around = radius * wall * (1 - material.poisson / 2) / math.sqrt(12 * (1 - material.poisson**2))
    moment = held * across**2 / 8 + (1 - held) * around
    return material.creep * material.across / (6 * moment / wall**2 + radius / (2 * wall))


def plate_loss(material: Material, radius: float, plate: float, held: float = 1.0) -> float:
    """Return the volume (m3/Pa) by which a plate gives way, less than its thickness; clamped it is pi R^6 / (192 D)."""
    stiffness = material.modulus * plate**3 / (12 * (1 - material.poisson**2))
    return math.pi * radius**6 / (192 * stiffness) * (1 + 6 * (1 - held) / (1 + material.poisson))


def cone_loss(
    material: Material, radius: FloatArray, wall: FloatArray, slant: FloatArray, tilt: FloatArray
) -> FloatArray:
    """Return the volume (m3/Pa) that closed cones lose, by Lame's strains of the cylinder of their radius over cos(tilt).

    A thin cylinder loses (5/2 - 2 nu) R / (E t) of its own. ``radius`` is that in the middle of the slant; tilts up to 45 degrees,
    rad. What edges bend is left out; ``even`` is the mean of r^3.
    """
    cos, sin, nu = np.cos(tilt), np.sin(tilt), material.poisson
    m = 1 / (1 - (1 - wall * cos / radius) ** 2)
    hoop, along = (2 - nu) * m - (1 + nu), (1 - 2 * nu) * m
    turned = sin**2 * (hoop + (2 - nu) * m)
    even = 1 + (slant * sin / (2 * radius)) ** 2
    return np.asarray(np.pi * radius**2 * slant * even * (2 * hoop * cos + (along - turned) / cos) / material.modulus)


def kink_stress(material: Material, radius: FloatArray, wall: FloatArray, turn: FloatArray) -> FloatArray:
    """Return the greatest stress at kinks of a wall over the hoop stress p R / t beside them, at least 1.

    ``turn`` is the sine of the tilt before each kink less that after it. The force along the wall pushes on the kink like a ring, and
    bends long tubes beside it (Timoshenko and Woinowsky-Krieger); kinks in a row bend each other less.
    """
    decay = _decay(material, radius / wall)
    bent = 0.5 + 0.75 * np.abs(turn) * radius / wall / decay
    return np.asarray(np.maximum(1 + decay * np.maximum(-turn, 0) / 4, bent))


def _decay(material: Material, thin: Any) -> Any:
    """Return the radius over the length at which a bent edge of a tube fades, by its radius over its wall."""
    return (3 * (1 - material.poisson**2)) ** 0.25 * thin**0.5


class HullPart(NamedTuple):
    """A part of a hull: thickness and outer radius, m, pressures at which it fails, Pa (plates do not buckle), and loss, m3/Pa."""

    name: str
    thickness: float
    radius: float
    yields: float
    buckles: float | None
    loss: float

    @property
    def holds(self) -> float:
        """Pressure at which it fails, Pa."""
        return self.yields if self.buckles is None else min(self.yields, self.buckles)


def describe_strength(body: Body, fluid: Fluid) -> dict[str, Any] | None:
    """Return what a hull withstands as ``driftform inspect --json`` prints it; ``None`` if :func:`list_parts` has none."""
    parts = list_parts(body)
    if not parts:
        return None
    # Of parts that buckle together the widest.
    weakest = min(parts, key=lambda part: (round(part.holds), -part.radius))
    fails = "yields" if weakest.holds == weakest.yields else "buckles"
    where = f"{weakest.name} {fails} at {weakest.holds / 1e5:.3g} bar"
    lost = 1e5 * fluid.density * sum(part.loss for part in parts)
    gradient = fluid.density * fluid.gravity
    depth = f", {weakest.holds / gradient:.3g} m down" if gradient else ""
    return {
        "pressure": weakest.holds,
        "part": weakest.name,
        "fails": fails,
        "lost_per_bar": lost,
        "summary": f"{where}{depth}; a bar takes {1000 * lost:.2g} g of buoyancy",
        "parts": [part._asdict() for part in parts],
    }


def list_parts(body: Body) -> list[HullPart]:
    """Return the parts of a hull from aft to fore; none if it is solid, open, or of an unknown material.

    The wall is measured between outer contour and cavity. Strength and stiffness are those across the layers after 1000 h; the
    volume that it loses is that of the first minutes.
    """
    name = find_material(body.hull_density)
    if name is None or not len(body.cavity) or distance_from(body.cavity, body.outer).min() < 1e-6:
        return []
    material = MATERIALS[name]
    # Straight rows of modules are one edge.
    x = body.joints[np.abs(body.joints[:, None] - body.outer[:, 0]).min(axis=1) > 1e-9]
    x = x[(x > body.outer[0, 0]) & (x < body.outer[-1, 0])]
    added = np.column_stack([x, np.interp(x, *body.outer.T)])
    outer = np.insert(body.outer, np.searchsorted(body.outer[:, 0], x), added, axis=0)
    outer = outer[np.append(True, np.hypot(*np.diff(outer, axis=0).T) > 1e-9)]
    steps, middle, away = np.diff(outer, axis=0), (outer[1:] + outer[:-1]) / 2, np.hypot(*outer.T)
    slant, r = np.hypot(*steps.T), middle[:, 1]
    flat, ball = steps[:, 0] < 1e-6 * slant, np.abs(np.diff(away)) < 3e-4 * away[1:]
    tilt = np.where(flat, 0.0, np.arcsin(steps[:, 1] / slant))
    hoop, points = r / np.cos(tilt), (outer[:-1] + np.linspace(0.1, 0.9, 5)[:, None, None] * steps).reshape(-1, 2)
    measured = distance_from(points, body.cavity).reshape(-1, len(r)).min(axis=0)
    wall = np.minimum(measured, 0.999 * hoop)
    # A plate does not count as a kink: what it bends is that of its rim.
    turns = np.where(flat[1:] | flat[:-1], 0.0, -np.diff(np.sin(tilt)))
    kinks = kink_stress(material, (hoop[1:] + hoop[:-1]) / 2, np.minimum(wall[1:], wall[:-1]), turns)
    yields = cylinder_yield(material, hoop, wall) / np.maximum(np.append(1.0, kinks), np.append(kinks, 1.0))
    length, around = _find_bays(hoop, slant, flat)
    buckles = KNOCK_DOWN * cylinder_buckling(material, around - wall / 2, wall, length)
    dome = np.maximum(buckles, sphere_buckling(material, away[1:] - wall / 2, wall))
    yields, buckles = np.where(ball, sphere_yield(material, away[1:], wall), yields), np.where(ball, dome, buckles)
    loss = cone_loss(material, r, wall, slant, tilt)
    parts = []
    names = _name_edges(body.joints, middle[:, 0], flat, ball)
    for name, places in groupby(range(len(r)), names.__getitem__):
        i = np.array(list(places))
        if name.endswith("end"):
            beside = i[0] + 1 if steps[i[0], 1] > 0 else i[0] - 1
            tube = float(hoop[beside]), float(wall[beside])
            parts.append(_measure_end(material, name, np.sort(outer[i[0] : i[0] + 2, 1]), float(measured[i[0]]), *tube))
        else:
            at = i[np.argmin(np.minimum(yields[i], buckles[i]))]
            fails = float(yields[i].min()), float(buckles[i].min())
            parts.append(HullPart(name, float(wall[i].min()), float(r[at]), *fails, float(loss[i].sum())))
    return parts


def thicken_ends(body: Body, room: float, pressure: float, line: float) -> FloatArray:
    """Return the cavity of a body, of a known material, with plates of whole lines at flat ends, that withstand a pressure.

    The plates count as free to turn at the rim, and leave so much ``room`` beyond the ends of the core, m.
    """
    material, cut = MATERIALS[find_material(body.hull_density) or ""], body.cavity
    share = math.sqrt(pressure / plate_yield(material, 1.0, 1.0, 0.0))
    for way, core in ((1, body.core.ends[0] - room), (-1, body.core.ends[1] + room)):
        (end, _), (rim, radius) = body.outer[::way][:2].tolist()
        x = way * min(way * end + line * math.ceil(share * radius / line), way * core)
        if abs(rim - end) < 1e-9:
            cut = cut_end(cut, x, way)
    return cut


def _measure_end(material: Material, name: str, radii: FloatArray, plate: float, tube: float, wall: float) -> HullPart:
    """Return a flat end of two radii: a plate on a tube of a radius (over the cosine of its tilt) and a wall, m.

    A step, whose inner radius is not 0, is less than a round plate with a radius of its width: a long strip of a width w that
    is held at both edges has a stress of p (w/t)^2 / 2, at most 3/4 p (w/t)^2 if they turn (Timoshenko).
    """
    inner, radius = radii.tolist()
    across, strips = (radius - wall / 2, 1.0) if inner < 1e-6 else (radius - inner, 2 * radius / (radius - inner))
    held = hold_rim(material, tube, plate, wall)
    yields = min(plate_yield(material, across, plate, held), rim_yield(material, tube, wall, held, across))
    return HullPart(name, plate, radius, yields, None, strips * plate_loss(material, across, plate, held))


def _find_bays(hoop: FloatArray, slant: FloatArray, flat: npt.NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Return for each edge the slant length between the ends and necks that hold it round, and the mean radius over it, m."""
    count = np.arange(len(hoop))
    holds, before = flat | (hoop <= NECK * hoop[:, None]), count < count[:, None]
    first = np.where(holds & before, count, -1).max(axis=1) + 1
    last = np.where(holds & ~before, count, len(hoop)).min(axis=1)
    lengths, areas = (np.append(0.0, np.cumsum(along)) for along in (slant, slant * hoop))
    length = np.maximum(lengths[last] - lengths[first], 1e-9)
    return length, (areas[last] - areas[first]) / length


def _name_edges(
    joints: FloatArray, x: FloatArray, flat: npt.NDArray[np.bool_], ball: npt.NDArray[np.bool_]
) -> list[str]:
    """Return the part that each edge belongs to, by the x of its middle: an end, the dome, or a module, counted from the core."""
    inner = int((np.abs(joints) < 1e-9).any())
    fore, aft = np.sort(joints[joints > 1e-9]), np.sort(-joints[joints < -1e-9])
    number = inner + np.where(x > 0, np.searchsorted(fore, x), np.searchsorted(aft, -x))
    return [
        f"{side} end" if f else "dome" if b or not n else f"module {n} {side}"
        for side, n, f, b in zip(np.where(x > 0, "fore", "aft").tolist(), number.tolist(), flat, ball, strict=True)
    ]
