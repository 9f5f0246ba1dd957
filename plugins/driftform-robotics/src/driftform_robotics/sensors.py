"""What sensors on an agent would read along its flight: plain functions of the samples.

All act at one ``point`` of the body (m, body frame). Noise is none of their business: see :func:`noisy`.
"""

import numpy as np

from driftform.dynamics.model import touching_rims
from driftform.dynamics.rotations import matrix_from_quaternion
from driftform.scenario import Fluid, Pipe, Scenario
from driftform.trajectory.forces import acceleration_at
from driftform.types import Body, FloatArray, Trajectory
from driftform_robotics.atmosphere import ATMOSPHERE
from driftform_robotics.models.pipe import make_bore


def point_positions(trajectory: Trajectory, point: FloatArray) -> FloatArray:
    """Return where a point of the body is at each sample, world frame, m, (k, 3)."""
    return np.asarray(
        trajectory.position + matrix_from_quaternion(trajectory.quaternion) @ point, dtype=np.float64
    )


def surface_height(scenario: Scenario) -> float:
    """Return the height where the pressure is that of the atmosphere, world frame, m.

    It is that of the free surface; where the pipe is full, that of its highest point at the inlet, as if a manhole
    stood open there; in open water without a surface, that of the origin.
    """
    if scenario.fluid.water_level is not None:
        return scenario.fluid.water_level
    if not scenario.pipe.segments:
        return 0.0
    segment = scenario.pipe.segments[0]
    # The end disc is tilted as much as the pipe: its rim rises by the radius times the cosine of the slope.
    slope = scenario.direction()[2]
    return float(segment.start[2] + segment.radius * np.sqrt(1 - slope**2))


def pressure(heights: FloatArray, surface: float, fluid: Fluid, atmosphere: float = ATMOSPHERE) -> FloatArray:
    """Return the absolute hydrostatic pressure p = p0 + rho g (surface - z), Pa, (k,).

    Above the surface it is that of the air. The pressure that the current's speed or the wall's friction adds is left
    out: rho U^2 / 2 is as much as 5 cm of water at 1 m/s.
    """
    return np.asarray(
        atmosphere + fluid.density * fluid.gravity * np.maximum(surface - heights, 0.0), dtype=np.float64
    )


def specific_force(
    trajectory: Trajectory, accelerations: FloatArray, point: FloatArray, gravity: float
) -> FloatArray:
    """Return what an accelerometer at a point of the body reads, R^T (a - g), in body axes, m/s2, (k, 3).

    At rest it reads g upward, and in free fall nothing. ``accelerations`` (k, 6) are those of the equations of motion
    (:func:`driftform.trajectory.forces.accelerations_along`), carried over to the point with the body's turning.
    """
    up = matrix_from_quaternion(trajectory.quaternion)[:, 2]
    return np.asarray(acceleration_at(trajectory, accelerations, point) + gravity * up, dtype=np.float64)


def wall_distance(points: FloatArray, pipe: Pipe) -> FloatArray:
    """Return how far points (k, 3) are from the wall of the pipe's bore, m, (k,), negative in the wall."""
    across = (points - pipe.segments[0].start) @ _cross_axes(pipe)
    return np.asarray(pipe.segments[0].radius - np.linalg.norm(across, axis=1), dtype=np.float64)


def clearance(trajectory: Trajectory, body: Body, pipe: Pipe) -> FloatArray:
    """Return the smallest distance of the hull from the wall at each sample, m, (k,), negative where it presses in.

    The bore is convex, so that one of the rims that :func:`driftform.dynamics.model.touching_rims` finds is nearest.
    Seen along the pipe a rim is an ellipse, c + p cos(a) + q sin(a): its greatest distance from the pipe's axis is
    sought by Newton's method from the farthest of sixteen of its points.
    """
    across = _cross_axes(pipe)
    R = matrix_from_quaternion(trajectory.quaternion)
    x, r = touching_rims(body).T
    c = ((trajectory.position - pipe.segments[0].start) @ across)[:, None] + x[:, None] * (
        R[:, None, :, 0] @ across
    )
    p, q = (r[:, None] * (R[:, None, :, i] @ across) for i in (1, 2))

    def dot(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray((a * b).sum(axis=-1), dtype=np.float64)

    # Half of the squared distance is a constant and a cos(t) + b sin(t) + d cos(2 t) + e sin(2 t).
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
    return np.asarray(
        pipe.segments[0].radius - np.linalg.norm(farthest, axis=-1).max(axis=1), dtype=np.float64
    )


def _cross_axes(pipe: Pipe) -> FloatArray:
    """Two unit vectors across the pipe, as the columns of a matrix, (3, 2)."""
    rotation: FloatArray = make_bore(pipe.segments[0]).rotation
    return rotation[:, 1:]


def add_noise(values: FloatArray, deviation: float, rng: np.random.Generator) -> FloatArray:
    """Return readings with white Gaussian noise of a standard deviation; with none they are the same."""
    return np.asarray(values + deviation * rng.standard_normal(values.shape), dtype=np.float64)
