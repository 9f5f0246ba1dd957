"""A small agent that sinks, filmed in worlds that are known."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from made_films import Filming, film_flight, place_drop

from driftform.design.design import Design
from driftform.design.opening import open_agent
from driftform.water import Factors
from driftform_calibration.problem import Filmed

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


@pytest.fixture(scope="session")
def design() -> Design:
    return open_agent(WORD, "tank")


@pytest.fixture(scope="session")
def film(design: Design) -> Callable[..., list[Filmed]]:
    """Film the agent in a world: one film for each pitch."""

    def make(
        world: Factors, filming: Filming, pitches: Sequence[float] = (-45.0, 0.0, 45.0), depth: float = 0.5
    ) -> list[Filmed]:
        rng = np.random.default_rng(5)
        morphology = design.agent.morphology
        assert morphology is not None
        return [
            film_flight(place_drop(design.pipeline, morphology, pitch, depth), world, rng, filming, f"{number}.csv")
            for number, pitch in enumerate(pitches, 1)
        ]

    return make


@pytest.fixture(scope="session")
def write_track() -> Callable[[Path, Filmed], Path]:
    """Write the track of a film as plain CSV."""

    def write(path: Path, film: Filmed) -> Path:
        rows = zip(film.track.t.tolist(), film.track.points[0].tolist(), strict=True)
        lines = ["t,x,y", *(f"{t:.6f},{x:.6f},{y:.6f}" for t, (x, y) in rows)]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path

    return write
