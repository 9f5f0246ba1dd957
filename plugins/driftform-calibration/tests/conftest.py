"""A small agent that sinks, filmed in worlds that are known."""

import numpy as np
import pytest
from made_films import film_flight, place_drop

from driftform.design.opening import open_agent

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


@pytest.fixture(scope="session")
def design():
    return open_agent(WORD, "tank")


@pytest.fixture(scope="session")
def film(design):
    """Film the agent in a world: one film for each pitch."""

    def make(world, filming, pitches=(-45.0, 0.0, 45.0), depth=0.5):
        rng = np.random.default_rng(5)
        morphology = design.agent.morphology
        return [
            film_flight(place_drop(design.pipeline, morphology, pitch, depth), world, rng, filming, f"{number}.csv")
            for number, pitch in enumerate(pitches, 1)
        ]

    return make


@pytest.fixture(scope="session")
def write_track():
    """Write the track of a film as plain CSV."""

    def write(path, film):
        rows = zip(film.track.t.tolist(), film.track.points[0].tolist(), strict=True)
        lines = ["t,x,y", *(f"{t:.6f},{x:.6f},{y:.6f}" for t, (x, y) in rows)]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path

    return write
