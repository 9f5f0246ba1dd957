"""Readings of sensors on an agent along its flight, as functions of the samples.

The sensors are at one ``point`` of the body (m, body frame). The readings have no noise; :func:`add_noise` adds it.
"""

import numpy as np

from driftform.motion import path
from driftform.types import Body, FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Fluid, Pipe, Scenario
from driftform_robotics.models.pipe import make_bore
from driftform_robotics.options import ATMOSPHERE


def point_positions(trajectory: Trajectory, point: FloatArray) -> FloatArray:
    """Return the positions of a point of the body, one for each sample, world frame, m, (k, 3)."""
    return np.asarray(
        trajectory.position + rotations.matrix_from_quaternion(trajectory.quaternion) @ point, dtype=np.float64
    )


def surface_height(scenario: Scenario) -> float:
    """Return the height at which the pressure is that of the atmosphere, world frame, m.

    It is the height of the free surface; in a full pipe, that of the highest point of the inlet, as if a manhole were
    open there; in open water without a surface, that of the origin.
    """
    if scenario.fluid.water_level is not None:
        return scenario.fluid.water_level
    if scenario.pipe.is_open:
        return 0.0
    inlet = scenario.pipe.layout.inlet
    # The inlet's disc is tilted with the pipe: its rim rises by the radius times the cosine of the slope.
    slope = scenario.direction()[2]
    return float(inlet.centre[2] + inlet.radius * np.sqrt(1 - slope**2))


def pressure(heights: FloatArray, surface: float, fluid: Fluid, atmosphere: float = ATMOSPHERE) -> FloatArray:
    """Return the absolute hydrostatic pressure p = p0 + rho g (surface - z), Pa, (k,).

    Above the surface it is the pressure of the air. The contributions of the current's speed and of the wall's friction
    are left out: rho U^2 / 2 equals 5 cm of water at 1 m/s.
    """
    return np.asarray(atmosphere + fluid.density * fluid.gravity * np.maximum(surface - heights, 0.0), dtype=np.float64)


def specific_force(trajectory: Trajectory, accelerations: FloatArray, point: FloatArray, gravity: float) -> FloatArray:
    """Return the reading of an accelerometer at a point of the body, R^T (a - g), in body axes, m/s2, (k, 3).

    It is g upward at rest, and 0 in free fall. ``accelerations`` (k, 6) are those of the equations of motion
    (:func:`driftform.motion.accelerations_along`), transferred to the point with the body's rotation.
    """
    up = rotations.matrix_from_quaternion(trajectory.quaternion)[:, 2]
    return np.asarray(path.acceleration_at(trajectory, accelerations, point) + gravity * up, dtype=np.float64)


def clearance(trajectory: Trajectory, body: Body, pipe: Pipe) -> FloatArray:
    """Return the smallest distance of the hull from the wall of a straight pipe at each sample, m, (k,), negative in contact.

    The bore is convex, so the nearest point is on a rim of the hull's contour.
    Seen along the pipe a rim is an ellipse, c + p cos(a) + q sin(a). Newton's method finds its greatest distance from
    the pipe's axis, starting at the farthest of sixteen points of the rim.
    """
    if pipe.straight is None:
        raise ValueError("the distance from the wall needs a straight pipe")
    bore = pipe.straight
    across = make_bore(bore).rotation[:, 1:]
    R = rotations.matrix_from_quaternion(trajectory.quaternion)
    x, r = body.outer[body.outer[:, 1] > 0.0].T
    c = ((trajectory.position - bore.start) @ across)[:, None] + x[:, None] * (R[:, None, :, 0] @ across)
    p, q = (r[:, None] * (R[:, None, :, i] @ across) for i in (1, 2))

    def dot(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray((a * b).sum(axis=-1), dtype=np.float64)

    # Half of the squared distance is a constant plus a cos(t) + b sin(t) + d cos(2 t) + e sin(2 t).
    a, b, d, e = dot(c, p), dot(c, q), (dot(p, p) - dot(q, q)) / 4, dot(p, q) / 2
    t = np.zeros_like(a)
    best = np.full_like(a, -np.inf)
    for angle in np.arange(16) * (np.pi / 8):
        value = a * np.cos(angle) + b * np.sin(angle) + d * np.cos(2 * angle) + e * np.sin(2 * angle)
        t, best = np.where(value > best, angle, t), np.maximum(value, best)
    for _ in range(6):
        slope = b * np.cos(t) - a * np.sin(t) + 2 * e * np.cos(2 * t) - 2 * d * np.sin(2 * t)
        bend = -a * np.cos(t) - b * np.sin(t) - 4 * d * np.cos(2 * t) - 4 * e * np.sin(2 * t)
        t = t - np.where(bend < 0, slope / np.where(bend < 0, bend, 1.0), 0.0)
    farthest = c + p * np.cos(t)[..., None] + q * np.sin(t)[..., None]
    return np.asarray(bore.radius - np.linalg.norm(farthest, axis=-1).max(axis=1), dtype=np.float64)


def add_noise(values: FloatArray, deviation: float, rng: np.random.Generator) -> FloatArray:
    """Return readings with white Gaussian noise of a standard deviation; 0 leaves them unchanged."""
    return np.asarray(values + deviation * rng.standard_normal(values.shape), dtype=np.float64)
