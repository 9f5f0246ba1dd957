"""Sensitivity to mass: how far off an agent is when it weighs a gram more or less than simulated."""

from dataclasses import dataclass

from driftform.agent import MassElement, hull_mass
from driftform.pipeline import Pipeline
from driftform.types import Agent, FloatArray

GRAM = 1e-3
"""kg"""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Errors (100 less the fitness) for each target, (targets,): as simulated, and a gram lighter and heavier."""

    as_simulated: FloatArray
    lighter: FloatArray
    heavier: FloatArray


def measure_gram_sensitivity(pipeline: Pipeline, agent: Agent, name: str) -> Sensitivity | None:
    """Fly the agent with a gram less and a gram more of hull; ``None`` if its hull has no gram to lose.

    The two are given apart and not as one slope: about the mass that was evolved for a target the error grows on
    either side.

    Raises WorkFailedError as :meth:`driftform.pipeline.Pipeline.simulate`.
    """
    if hull_mass(agent.body) <= GRAM:
        return None
    others = [
        MassElement.reweigh(agent, (MassElement.of_agent(agent), MassElement.of_hull(agent.body, gram)))
        for gram in (-GRAM, GRAM)
    ]
    return Sensitivity(*(100 - one.fitness for one in pipeline.simulate([agent, *others], name)))
