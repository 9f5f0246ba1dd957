"""Flying an agent again with other masses: what becomes of its fitness."""

from collections.abc import Sequence
from dataclasses import dataclass

from driftform.errors import WorkFailedError
from driftform.geometry.mass_elements import reweigh
from driftform.pipeline import Pipeline
from driftform.types import Agent, FloatArray, Trajectory

GRAM = 1e-3
"""kg"""


@dataclass(frozen=True, eq=False)
class Flown:
    """A flight and its fitness for each target, (targets,)."""

    flight: Trajectory
    fitness: FloatArray


def flown(pipeline: Pipeline, agents: Sequence[Agent], name: str) -> list[Flown]:
    """Fly agents in the pipeline's scenario.

    Raises
    ------
    WorkFailedError
        where a flight cannot be computed; the message begins with ``name``.
    """
    try:
        flights = pipeline.fly(agents)
    except (ArithmeticError, RuntimeError) as error:
        raise WorkFailedError(f"{name}: cannot be flown: {type(error).__name__}: {error}") from None
    for flight in flights:
        if flight.end.failed:
            raise WorkFailedError(f"{name}: the flight ended after {flight.t[-1]:.3g} s: {flight.end}")
    return [Flown(flight, pipeline.fitness.score(flight, pipeline.scenario)) for flight in flights]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Errors (100 less the fitness) for each target, (targets,): as simulated, and a gram lighter and heavier."""

    as_simulated: FloatArray
    lighter: FloatArray
    heavier: FloatArray


def gram_sensitivity(pipeline: Pipeline, agent: Agent, name: str) -> Sensitivity | None:
    """Fly the agent with a gram less and a gram more of hull; ``None`` where its hull has no gram to lose.

    The two are told apart and not made one slope: about the mass that was evolved for a target the error grows on
    either side.

    Raises
    ------
    WorkFailedError
        as :func:`flown`.
    """
    if agent.mass.mass - agent.body.core.mass <= GRAM:
        return None
    others = [reweigh(agent, agent.mass.mass + change) for change in (-GRAM, GRAM)]
    return Sensitivity(*(100 - one.fitness for one in flown(pipeline, [agent, *others], name)))
