"""Flights along straight lines in a pipe with one tee, whose branch leads up."""

from itertools import pairwise

import numpy as np

from driftform.types import End, Trajectory
from driftform.water import Scenario

PARTS = [
    {"length": 1.0},
    {
        **{"kind": "tee", "name": "T", "branch_radius": 0.05, "share": 0.3, "roll_deg": 0},
        "branch": [{"length": 0.5}, {"length": 0.5, "outlet": "up"}],
    },
    {"length": 0.5},
    {"length": 1.0, "outlet": "on"},
]


def junction_scenario(**targets):
    """Return the scenario of the pipe, with targets that are points or outlets."""
    return Scenario.model_validate({"pipe": {"radius": 0.1, "parts": PARTS}, "targets": targets})


def fly_along(*corners, end=End.OUTLET):
    """Return a flight along straight lines at 1 m/s, with a sample every 20 mm."""
    points = [np.array(p, dtype=float) for p in corners]
    lines = [np.linspace(a, b, 1 + round(np.linalg.norm(b - a) / 0.02)) for a, b in pairwise(points)]
    positions = np.concatenate([lines[0], *(line[1:] for line in lines[1:])])
    t = 0.02 * np.arange(len(positions))
    velocity = np.zeros((len(t), 6))
    velocity[:, :3] = np.gradient(positions, t, axis=0)
    return Trajectory(t, positions, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1)), velocity, end)
