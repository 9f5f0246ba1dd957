"""Velocity profiles of pipe flow, at a point and averaged over a body.

All profiles are axisymmetric. ``U`` is the bulk velocity, R the bore's radius, y the distance from the wall, x the distance
from the inlet along the pipe.
"""

import math
from typing import TypeAlias

from driftform.util.compiled import compiled
from driftform.util.small_vectors import ZERO, Vector, dot

UNIFORM, POWER_LAW, LOG_LAW, DEVELOPING, GRID, PARABOLA = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0

Spread: TypeAlias = tuple[Vector, float, float]
"""Where a body is: unit vector along its axis, variance of its volume across the axis and along it (m2)."""

AT_A_POINT: Spread = (ZERO, 0.0, 0.0)

Bore: TypeAlias = tuple[Vector, float, float, float]
"""Around a point: unit vector to the wall, radius (m), distance from the axis (m), friction velocity (m/s)."""

MIN_WALL_DISTANCE = 1e-3
"""Distance from the wall over R below which the profiles are constant.

The centre of an agent does not come as near as that, and the laws do not hold there.
"""


@compiled
def spread_across(spread: Spread, axis: Vector) -> float:
    """Return the mean square distance (m2) of a body from a line along ``axis`` through its centre."""
    along = dot(axis, spread[0])
    return 2.0 * spread[1] + (spread[2] - spread[1]) * max(0.0, 1.0 - along * along)


@compiled
def spread_profile(
    radius: float, x: float, r: float, square: float, kind: float, U: float, parameter: float
) -> tuple[float, float, float, float]:
    """Return what :func:`velocity_profile` does at sqrt(r^2 + ``square``), with derivatives with respect to r."""
    if square == 0.0:
        return velocity_profile(radius, x, r, kind, U, parameter)
    distance = math.sqrt(r * r + square)
    along, shear, stretch, radial = velocity_profile(radius, x, distance, kind, U, parameter)
    return along, shear * r / distance, stretch, radial * r / distance


@compiled
def velocity_profile(
    radius: float, x: float, r: float, kind: float, U: float, parameter: float
) -> tuple[float, float, float, float]:
    """Return the axial velocity u, du/dr, du/dx, and the radial velocity at r from the axis, x from the inlet.

    * power law: u/U = (n + 1)(2n + 1) / (2 n^2) (y/R)^(1/n);
    * log law: u/U = 1 + u* / (kappa U) (3/2 + ln(y/R)), the velocity-defect law over the whole bore;
    * parabola of laminar flow: u/U = 2 (1 - r^2/R^2) (Hagen and Poiseuille);
    * developing: a layer of thickness d = 0.37 x Re_x^(-1/5) (Schlichting) with u ~ (y/d)^(1/7), and a core whose
      speed U / (1 - d/(4R) + d^2/(15 R^2)) keeps the volume flow.
    """
    if kind == UNIFORM:
        return U, 0.0, 0.0, 0.0
    y = max(radius - r, MIN_WALL_DISTANCE * radius)
    moving = 1.0 if radius - r > MIN_WALL_DISTANCE * radius else 0.0
    if kind == POWER_LAW:
        power = parameter
        n = 1.0 / power
        u = U * (n + 1) * (2 * n + 1) / (2 * n * n) * (y / radius) ** power
        return u, -moving * power * u / y, 0.0, 0.0
    if kind == LOG_LAW:
        defect = U * parameter
        u = U + defect * (1.5 + math.log(y / radius))
        # Near a very rough wall the law would give a negative velocity.
        return (u, -moving * defect / y, 0.0, 0.0) if u > 0.0 else (0.0, 0.0, 0.0, 0.0)
    if kind == PARABOLA:
        share = min(1.0, r / radius)
        return 2.0 * U * (1.0 - share * share), -4.0 * U * share / radius if share < 1.0 else 0.0, 0.0, 0.0
    x = max(x, MIN_WALL_DISTANCE * radius)
    layer = 0.37 * x**0.8 * parameter**0.2
    growth = 0.8 * layer / x
    if layer > radius:
        layer, growth = radius, 0.0
    ratio = layer / radius
    narrowing = 1 - ratio / 4 + ratio * ratio / 15
    core = U / narrowing
    core_stretch = core / narrowing * (0.25 - ratio * 2 / 15) * growth / radius
    if y >= layer:
        return core, 0.0, core_stretch, -0.5 * core_stretch * r
    shape = (y / layer) ** (1 / 7)
    factor = core_stretch - core * growth / (7 * layer)
    # r v = integral from r to R of s du/dx ds, with du/dx = factor (y / d)^(1/7) and s = R - y.
    radial = factor * shape * y * (7 / 8 * radius - 7 / 15 * y) / r
    return core * shape, -moving * core * shape / (7 * y), factor * shape, radial
