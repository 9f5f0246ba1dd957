"""What kind of body won: one that rides the crown or rolls on the floor, a plain body, a saucer, a cylinder, or another slender body."""

import numpy as np

from driftform.types import Agent, Trajectory
from driftform.water import Scenario

FLAT = 1.5
"""Length over diameter below which a body is a saucer."""

EVEN = 0.1
"""Scatter of the radius along a cylinder, relative to its mean."""

_STATIONS = 101


def name_kind(agent: Agent, trajectory: Trajectory, scenario: Scenario, t: float) -> str:
    """Return the kind of an agent that passes its target at the time ``t`` (s)."""
    body, pipe = agent.body, scenario.pipe.straight
    if pipe is not None and trajectory.contact is not None and trajectory.contact <= t:
        position = np.array([np.interp(t, trajectory.t, column) for column in trajectory.position.T])
        axis = np.subtract(pipe.end, pipe.start) / np.linalg.norm(np.subtract(pipe.end, pipe.start))
        off = position - pipe.start
        across = off - (off @ axis) * axis
        if np.linalg.norm(across) > pipe.radius - body.max_diameter:
            return "crown rider" if across[2] > 0 else "floor roller"
    if agent.morphology is not None and not agent.morphology.modules:
        return "plain body"
    if body.length < FLAT * body.max_diameter:
        return "saucer"
    x = np.linspace(float(body.outer[0, 0]), float(body.outer[-1, 0]), _STATIONS)[5:-5]
    radii = np.interp(x, body.outer[:, 0], body.outer[:, 1])
    return "cylinder" if radii.std() < EVEN * radii.mean() else "slender body"
