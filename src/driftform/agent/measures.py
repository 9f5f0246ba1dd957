"""What is measured of each evaluation besides its fitness: of the agent, and of its flight."""

from collections.abc import Sequence

import numpy as np

from driftform.agent.mass import hull_mass
from driftform.types import Agent, End, Trajectory

FILAMENT = 1.75e-3
"""Diameter of the filament that most printers take, m."""

STATIONS = (0.25, 0.5, 0.75)
"""Where heights are measured, in shares of the length of a straight pipe."""


def measure_evaluation(
    agent: Agent, trajectory: Trajectory, density: float, ends: Sequence[Sequence[float]] | None = None
) -> dict[str, float]:
    """Return the measures of an agent and its flight in water of a ``density`` (kg/m3), by name, in SI units.

    ``net_weight`` (kg) sinks if it is positive; ``print_mass`` (kg) is that of the hull, and ``filament`` (m) what it
    takes of one of 1.75 mm; ``arrival`` (s) is when it left by an outlet, and ``contact`` when it first touched a wall, NaN
    if it never did. ``height_0.5`` and the like (m) are how high above the axis of a straight pipe between two ``ends`` (m) it
    first passed these stations, or ended before.
    """
    body, mass, printed = agent.body, agent.mass, hull_mass(agent.body)
    left = trajectory.end is End.OUTLET
    heights = {}
    if ends is not None:
        way, off = np.subtract(ends[1], ends[0]), trajectory.position - ends[0]
        along = off @ way / (way @ way)
        reached, up = np.maximum.accumulate(along), off[:, 2] - along * way[2]
        heights = {f"height_{share:g}": float(np.interp(share, reached, up)) for share in STATIONS}
    return {
        "mass": mass.mass,
        "length": body.length,
        "max_diameter": body.max_diameter,
        "volume": mass.volume,
        "net_weight": mass.mass - density * mass.volume,
        "print_mass": printed,
        "filament": printed / (body.hull_density * np.pi / 4 * FILAMENT**2) if body.hull_density else 0.0,
        "modules": float(len(agent.morphology.modules)) if agent.morphology else 0.0,
        "arrival": float(trajectory.t[-1]) if left else float("nan"),
        "contact": float("nan") if trajectory.contact is None else trajectory.contact,
        **heights,
    }
