"""Do random agents fly as the textbook's equations say: for 9 s in open water, and in the pipe up to the wall?"""

from itertools import repeat

import numpy as np
import pytest
from closed_forms import wall_depths
from textbook import textbook_states

from driftform.motion.path.interpolation import interpolate_positions
from driftform.study import load_study
from driftform.testing.simulator import largest_distance
from driftform.types import End, Trajectory
from driftform.water import Pipe

pytestmark = pytest.mark.slow

SIMULATORS = ("native", "exudyn")
HORIZON = 9.0
MILLIMETRE = 1e-3
DRAG_IN_LOG_LAW = ["flow.kind=log_law", "hydrodynamics.use=panels", "hydrodynamics.drag=strips"]


@pytest.fixture(scope="module")
def pipelines():
    return {use: load_study("paper", use={"simulator": use}).make_pipeline() for use in SIMULATORS}


@pytest.fixture
def agents(pipelines, count_of):
    """Random agents; another seed gives others."""

    def drawn(seed):
        pipeline, rng = pipelines["native"], np.random.default_rng(seed)
        return [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(count_of("AGENTS", 100))]

    return drawn


def row(where, use, flights, errors):
    known = sum(trajectory.error >= error for trajectory, error in zip(flights, errors, strict=True))
    beyond = sum(error > MILLIMETRE for error in errors)
    return (
        f"| {where} | {use} | {len(errors)} | {1e3 * np.median(errors):.2g} | {1e3 * max(errors):.2g} "
        f"| {beyond} | {known} |"
    )


HEAD = (
    "| flights | simulator | agents | median mm | worst mm | beyond 1 mm | estimated error at least this |",
    "|---|---|---|---|---|---|---|",
)


def test_free_flights_agree_with_the_textbook_to_a_millimetre(pipelines, agents, workers, publish):
    drawn = agents(0)
    scenario = pipelines["native"].scenario
    scenario = scenario.model_copy(
        update={"pipe": Pipe(), "targets": {}, "flight": scenario.flight.model_copy(update={"horizon": HORIZON})}
    )
    times = np.linspace(0, HORIZON, round(100 * HORIZON) + 1)
    expected = list(workers.map(textbook_states, drawn, repeat(scenario), repeat(times)))
    # The book's own error: the same to a hundred times less.
    few = drawn[:10]
    tighter = workers.map(textbook_states, few, repeat(scenario), repeat(times), repeat(1e-13))
    doubt = max(largest_distance(a[:, :3], b[:, :3]) for a, b in zip(expected, tighter, strict=False))

    lines, errors = list(HEAD), {}
    for use, pipeline in pipelines.items():
        flights = list(workers.map(pipeline.simulator.simulate, drawn, repeat(scenario)))
        assert {trajectory.end for trajectory in flights} <= {End.HORIZON, End.NOT_CONVERGED}
        errors[use] = [
            largest_distance(interpolate_positions(f, times), e[:, :3]) for f, e in zip(flights, expected, strict=True)
        ]
        failed = [index for index, trajectory in enumerate(flights) if trajectory.end.failed]
        print(f"{use}: not converged: {failed}")
        lines.append(row("9 s in open water", use, flights, errors[use]))
    fastest = [float(np.abs(trajectory[:, 10:]).max()) for trajectory in expected]
    lines += [
        "",
        f"The error of the textbook's flights is below {doubt:.1g} m. Half of the agents reach a spin of more than "
        f"{np.median(fastest):.0f} rad/s, one {max(fastest):.0f} rad/s, because there is no damping.",
    ]
    publish("free flights", lines)
    assert doubt < 1e-6
    for use in SIMULATORS:
        assert max(errors[use]) < MILLIMETRE, use


@pytest.mark.parametrize(
    ("title", "where", "seed", "settings", "tolerances"),
    [
        ("flights up to the wall", "in the pipe, up to the wall", 1, [], (1e-11, 1e-13)),
        ("flights with drag", "log law with drag, up to the wall", 2, DRAG_IN_LOG_LAW, (1e-9, 1e-11)),
    ],
)
def test_flights_agree_with_the_textbook_up_to_the_wall(
    title, where, seed, settings, tolerances, agents, workers, publish
):
    pipelines = {use: load_study("paper", settings, use={"simulator": use}).make_pipeline() for use in SIMULATORS}
    native, rng = pipelines["native"], np.random.default_rng(3)
    radius = native.scenario.pipe.segments[0].radius
    drawn = [native.make_agent(agent.genome) for agent in agents(seed)]
    # With drag, every second one leaves the vertical plane.
    yaws = rng.uniform(-60, 60, len(drawn)) * (np.arange(len(drawn)) % 2) * bool(settings)
    scenarios = [turned(native.scenario, yaw) for yaw in yaws.tolist()]
    lines, worst, reached = list(HEAD), {}, {}
    for use, pipeline in pipelines.items():
        flights = list(workers.map(pipeline.simulator.simulate, drawn, scenarios))
        untils = [flight.t[-1] if flight.contact is None else flight.contact for flight in flights]
        instants = [np.linspace(0, until, int(100 * until) + 2) for until in untils]
        expected = list(workers.map(textbook_states, drawn, scenarios, instants, *map(repeat, tolerances)))
        errors = [
            largest_distance(interpolate_positions(flight, times), path[:, :3])
            for flight, times, path in zip(flights, instants, expected, strict=True)
        ]
        # Where a simulator tells of the first contact, the textbook's agent must touch the wall as well.
        touching = [
            wall_depths(agent, as_trajectory(times[-1:], path[-1:]), radius)[0]
            for agent, flight, times, path in zip(drawn, flights, instants, expected, strict=True)
            if flight.contact is not None
        ]
        worst[use], reached[use] = max(errors), max(map(abs, touching))
        lines.append(row(where, use, flights, errors))
        print(f"{use}: {len(touching)} reach the wall; at its first contact the textbook's agent is off it by")
        print(f"    {1e3 * reached[use]:.3g} mm at most; {sum(f.end.failed for f in flights)} fail later on")
    publish(title, lines)
    for use in SIMULATORS:
        assert worst[use] < MILLIMETRE, use
        assert reached[use] < MILLIMETRE, use


def turned(scenario, yaw_deg):
    release = scenario.release.model_copy(update={"yaw_deg": yaw_deg})
    return scenario.model_copy(update={"release": release})


def as_trajectory(t, states):
    return Trajectory(t, states[:, :3], states[:, 3:7], states[:, 7:], End.HORIZON)
