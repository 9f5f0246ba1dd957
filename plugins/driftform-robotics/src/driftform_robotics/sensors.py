"""Readings of sensors on an agent along its flight, as functions of the samples.

The sensors are at one ``point`` of the body (m, body frame). The readings have no noise; :func:`add_noise` adds it.
"""

import numpy as np

from driftform.motion import path
from driftform.types import FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Fluid, Scenario
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


def add_noise(values: FloatArray, deviation: float, rng: np.random.Generator) -> FloatArray:
    """Return readings with white Gaussian noise of a standard deviation; 0 leaves them unchanged."""
    return np.asarray(values + deviation * rng.standard_normal(values.shape), dtype=np.float64)
