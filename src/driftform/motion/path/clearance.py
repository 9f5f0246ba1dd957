"""How far an agent stays from the wall."""

import numpy as np

from driftform.motion.forces.surfaces import refined_surfaces, touching_surfaces
from driftform.types import Agent, FloatArray, Trajectory
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Scenario
from driftform.water.fittings import wall_array
from driftform.water.parts.walls import wall_gaps

RIMS = 20
"""Parts of a body's length between which it has a rim where the wall may bulge."""

DIRECTIONS = 8
"""Directions around the axis in which the point nearest to the wall is looked for at first."""

ROUNDS = 2
"""Times that this point is found anew, along the wall's normal at the last one."""


def wall_clearances(trajectory: Trajectory, scenario: Scenario, agent: Agent) -> FloatArray:
    """Return the distance between the agent's surface and the wall at each time, m, (times,); negative in the wall.

    It works in any pipe, with bends and tees, and is infinite in open water. Between two times an agent may come nearer;
    ``trajectory.contact`` is the exact time of the first contact.
    """
    pipe = scenario.pipe
    if pipe.is_open:
        return np.full(len(trajectory.t), np.inf)
    body, walls = agent.body, wall_array(pipe)
    surfaces = touching_surfaces(body) if pipe.straight is not None else refined_surfaces(body, body.length / RIMS)
    x, rim, dome, low, high = (surfaces[:, k, None] for k in range(5))
    rotation = matrix_from_quaternion(trajectory.quaternion)[:, None]
    axis = rotation[..., 0]
    centres = trajectory.position[:, None, :] + x * axis

    def find_points(direction: FloatArray) -> FloatArray:
        """Return the points of the surfaces that are farthest in a direction, world frame, m, (times, surfaces, 3)."""
        sine = (direction * axis).sum(axis=2, keepdims=True)
        across = direction - sine * axis
        across = across / np.maximum(np.linalg.norm(across, axis=2, keepdims=True), 1e-12)
        part = np.where(dome > 0, np.clip(sine, low, high), 0.0)
        return np.asarray(centres + dome * part * axis + (rim + dome * np.sqrt(1 - part**2)) * across)

    nearest, normals = np.full(centres.shape[:2], np.inf), np.zeros_like(centres)
    _, outward, _ = wall_gaps(centres.reshape(-1, 3), walls)
    nearest, normals = _choose_nearer(nearest, normals, find_points(outward.reshape(centres.shape)), walls)
    for angle in 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        direction = np.cos(angle) * rotation[..., 1] + np.sin(angle) * rotation[..., 2]
        nearest, normals = _choose_nearer(nearest, normals, find_points(direction), walls)
    for _ in range(ROUNDS):
        nearest, normals = _choose_nearer(nearest, normals, find_points(normals), walls)
    return np.asarray(nearest.min(axis=1))


def _choose_nearer(
    nearest: FloatArray, normals: FloatArray, points: FloatArray, walls: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return gaps (m) and normals, replaced by those of points (times, surfaces, 3) that are nearer to the wall."""
    gaps, found, _ = wall_gaps(points.reshape(-1, 3), walls)
    gaps = gaps.reshape(nearest.shape)
    nearer = gaps < nearest
    return np.where(nearer, gaps, nearest), np.where(nearer[..., None], found.reshape(points.shape), normals)
