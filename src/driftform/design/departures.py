"""In what an agent's surroundings and weight depart from those of its design."""

from collections.abc import Iterator

from driftform.pipeline import Pipeline
from driftform.types import Agent
from driftform.water import Scenario

DENSITY = 5e-4
"""Relative difference in the water's density that is worth a warning: a print of 200 cm3 floats by 0.1 g more."""

SPEED = 0.01
"""Relative difference in the speed of the current that is worth a warning: a third of the disturbance by default."""

WEIGHT = 1e-4
"""Difference in mass that is worth a warning, kg: what a kitchen scale shows."""


def list_departures(agent: Agent, pipeline: Pipeline, designed: Agent, design: Pipeline) -> list[str]:
    """Return one line per difference between an agent, its water, pipe or wall, and those of its design.

    Args:
        agent, pipeline: the agent as it flies now.
        designed, design: the agent as it was evolved.
    """
    now, before = pipeline.scenario, design.scenario
    lines = [*_compare_water(now, before), *_compare_pipes(now, before)]
    if now.contact != before.contact:
        lines.append("the wall's restitution or friction is not that of its design")
    if pipeline.hydrodynamics.options.drag != design.hydrodynamics.options.drag:
        lines.append(
            f"drag is '{pipeline.hydrodynamics.options.drag}', and '{design.hydrodynamics.options.drag}' in its design"
        )
    mass, planned = agent.mass.mass, designed.mass.mass
    if abs(mass - planned) > WEIGHT:
        lines.append(f"it weighs {1000 * mass:.1f} g, and {1000 * planned:.1f} g in its design")
    if not lines:
        return []
    net, wanted = agent.mass.net_buoyancy(now.fluid), designed.mass.net_buoyancy(before.fluid)
    effect = f"net buoyancy {net:+.3f} N, and {wanted:+.3f} N in its design"
    return [*lines, f"it was not evolved for this ({effect}): evolve again with these settings"]


def _compare_water(now: Scenario, before: Scenario) -> Iterator[str]:
    if abs(now.fluid.density / before.fluid.density - 1) > DENSITY:
        yield f"the water has {now.fluid.density:g} kg/m3, and {before.fluid.density:g} kg/m3 in its design"
    if now.flow.kind != before.flow.kind:
        yield f"flow.kind is '{now.flow.kind}', and '{before.flow.kind}' in its design"
    if abs(now.flow.speed - before.flow.speed) > SPEED * abs(before.flow.speed):
        yield f"the current has {now.flow.speed:g} m/s, and {before.flow.speed:g} m/s in its design"


def _compare_pipes(now: Scenario, before: Scenario) -> Iterator[str]:
    if now.pipe == before.pipe:
        return
    radii = [sorted({segment.radius for segment in scenario.pipe.segments}) for scenario in (now, before)]
    if radii[0] != radii[1]:
        shown, planned = (", ".join(f"{radius:g}" for radius in each) or "none" for each in radii)
        yield f"the pipe's radius is {shown} m, and {planned} m in its design"
    else:
        yield "the pipe's course is not that of its design"
