"""Early warnings: what the first flights of a run show of its study, that agents come to rest."""

from collections.abc import Sequence

import numpy as np

from driftform.types import End, Evaluation
from driftform.water.misfit import show_length

FIRST = 20
"""Number of evaluations that are looked at: the first of a run, of random agents with most strategies."""

MAX_AT_REST = 0.9
"""Share of the flights that may last to the horizon: if half of all arrived, more than 17 of 20 would in one study of 5000."""


def warn_of_rest(first: Sequence[Evaluation], horizon: float) -> str | None:
    """Return a line if nearly all of the first flights last to the horizon (s), ``None`` if not, or if most failed."""
    flights = [one.trajectory for one in first if one.failure is None and one.trajectory is not None]
    held = [flight.position for flight in flights if flight.end == End.HORIZON]
    if len(flights) < len(first) / 2 or len(held) < MAX_AT_REST * len(flights):
        return None
    median = float(np.median([np.linalg.norm(position[-1] - position[0]) for position in held]))
    return (
        f"{len(held)} of the first {len(flights)} flights last to flight.horizon = {horizon:g} s, and half of them end within "
        f"{show_length(median)} of the release: agents come to rest on the wall, or need longer; raise flow.speed or "
        "flight.horizon, or evolve agents nearer to the density of the water (builder, grammar)"
    )
