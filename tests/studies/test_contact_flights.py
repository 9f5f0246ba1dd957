"""Is the fitness of flights that hit the wall a property of the agent, and not of the integrator?"""

import time
from dataclasses import dataclass
from itertools import repeat

import numpy as np
import pytest

from driftform.motion.path.interpolation import interpolate_positions
from driftform.study import load_study
from driftform.testing.simulator import largest_distance
from driftform.types import FloatArray, Trajectory

pytestmark = pytest.mark.slow

SIMULATORS = ("native", "exudyn")
SHARP = 0.1
"""Percentage points of fitness that must not hang on the integrator."""

ENOUGH = 0.95
"""Share of agents of which that is asked."""

MILLIMETRE = 1e-3

IN_WATER = ("flow.kind=log_law", "hydrodynamics.use=panels", "hydrodynamics.drag=strips")
SHORT = 5.0
"""Horizon of flights with friction, s: a body that sticks takes thousands of explicit steps in a second."""


@dataclass(frozen=True, eq=False)
class Flown:
    """Flights of all agents with one setting of a simulator, and their fitness; infinite where a flight failed."""

    flights: list[Trajectory]
    fitness: FloatArray


@pytest.fixture(scope="module")
def agents():
    pipeline, rng = load_study("paper").make_pipeline(), np.random.default_rng(2)
    genomes = [pipeline.grammar.random(rng) for _ in range(1000)]
    return lambda count: [pipeline.make_agent(genome) for genome in genomes[:count]]


@pytest.fixture
def fly(agents, workers, count_of):
    """Fly all agents."""
    drawn = agents(count_of("AGENTS", 100))

    def fly_all(use, divisor=1.0, *more):
        usual = load_study("paper", use={"simulator": use}).document["simulator"]["tolerance"]
        settings = [f"simulator.tolerance={usual / divisor!r}", *more]
        pipeline = load_study("paper", settings, use={"simulator": use}).make_pipeline()
        flights = list(workers.map(pipeline.simulator.simulate, drawn, repeat(pipeline.scenario)))
        fitness = [
            pipeline.fitness.score(trajectory, pipeline.scenario, agent)
            for trajectory, agent in zip(flights, drawn, strict=True)
        ]
        failed = np.array([trajectory.end.failed for trajectory in flights])
        return Flown(flights, np.where(failed[:, None], np.nan, fitness))

    return fly_all


def changes(a, b):
    """Largest change of any target's fitness for each agent, percentage points; infinite where a flight failed."""
    change = np.abs(a.fitness - b.fitness).max(axis=1)
    return np.where(np.isnan(change), np.inf, change)


def distance(a, b, until=np.inf):
    """How far (m) two flights get apart before either ends."""
    until = min(until, a.t[-1], b.t[-1])
    times = np.linspace(0, until, int(100 * until) + 2)
    return largest_distance(interpolate_positions(a, times), interpolate_positions(b, times))


def row(simulator, what, change):
    sound = change[np.isfinite(change)]
    return (
        f"| {simulator} | {what} | {np.median(sound):.1g} | {np.quantile(sound, 0.95):.1g} | {sound.max():.1g} "
        f"| {(change < SHARP).sum()} of {len(change)} | {len(change) - len(sound)} |"
    )


HEAD = ("| simulator | change | median | 95 % | largest | below 0.1 | failed |", "|---|---|---|---|---|---|---|")


def test_both_simulators_find_the_same_fitness(fly, publish):
    native, exudyn = (fly(use) for use in SIMULATORS)
    change = changes(native, exudyn)
    away = [
        distance(a, b, min(np.inf if trajectory.contact is None else trajectory.contact for trajectory in (a, b)))
        for a, b in zip(native.flights, exudyn.flights, strict=True)
    ]
    lines = [
        *HEAD,
        row("both", "native instead of exudyn", change),
        "",
        f"Up to the wall the two trajectories differ by less than {1e3 * max(away):.2g} mm.",
    ]
    publish("backends", lines)
    assert max(away) < MILLIMETRE
    assert (change < SHARP).mean() >= ENOUGH


def test_both_simulators_fly_the_same_in_water_with_drag_and_friction(agents, publish, count_of):
    genomes, kept = [agent.genome for agent in agents(count_of("AGENTS", 20))], []
    lines = [
        "| friction | agents | not converged | apart: median mm | worst mm | flights per CPU second: native | exudyn |",
        "|---|---|---|---|---|---|---|",
    ]
    for friction in (0.0, 0.3):
        paths, rates = [], []
        for use in SIMULATORS:
            settings = [*IN_WATER, f"contact.friction={friction}", f"flight.horizon={SHORT}"]
            pipeline = load_study("paper", settings, use={"simulator": use}).make_pipeline()
            flyers = [pipeline.make_agent(genome) for genome in genomes]
            pipeline.fly(flyers[:1])
            began = time.process_time()
            paths.append(pipeline.fly(flyers))
            rates.append(len(flyers) / (time.process_time() - began))
        sound = [pair for pair in zip(*paths, strict=True) if not any(flight.end.failed for flight in pair)]
        apart = np.array([distance(*pair) for pair in sound])
        assert all(gap <= sum(flight.error for flight in pair) for gap, pair in zip(apart, sound, strict=True))
        lines.append(
            f"| {friction:g} | {len(genomes)} | {len(genomes) - len(sound)} | {1e3 * np.median(apart):.2g} "
            f"| {1e3 * apart.max():.2g} | {rates[0]:.3g} | {rates[1]:.2g} |"
        )
        kept.append((friction, (apart <= MILLIMETRE).sum() / len(genomes)))
    publish("both simulators in water", lines)
    for friction, share in kept:
        assert share >= ENOUGH, friction


def test_the_stiffness_of_the_wall_matters_more_than_the_integrator(fly, publish):
    base, tighter = fly("native"), fly("native", 10)
    stiffer = fly("native", 1, "contact.frequency=600")
    rough = fly("native", 1, "contact.friction=0.3")
    lines = [
        *HEAD,
        row("native", "contact.frequency from 300 to 600 rad/s", changes(base, stiffer)),
        row("native", "contact.friction from 0 to 0.3", changes(base, rough)),
    ]
    publish("wall", lines)
    assert np.median(changes(base, stiffer)) > np.median(changes(base, tighter))
