"""Does every flight of a random agent end soundly, or say that it did not?

``AGENTS=300 pytest -m slow -s tests/studies/test_robust_flights.py`` takes fewer than the thousand of the page.
"""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
import pytest
from closed_forms import wall_depths

from driftform.agent.slices import slice_solid
from driftform.motion.path.interpolation import interpolate_positions
from driftform.study import load_study
from driftform.testing.simulator import largest_distance
from driftform.types import Agent, Drag, End, Trajectory
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Scenario
from driftform.water.scenario import evaluation_seed

pytestmark = pytest.mark.slow

SEED = 3
BLOCK = 400
"""Flights that are kept in memory at a time."""

STRIPS = 24
FRICTION, SURFACE = "contact.friction=0.3", "fluid.water_level=0.3"
TURBULENCE = "flow={kind='turbulent', speed=1.0}"
SURROUNDINGS = {
    "plain": (),
    "drag strips": (),
    "friction of the wall 0.3": (FRICTION,),
    "water up to 0.3 m above the axis": (SURFACE,),
    "turbulent flow": (TURBULENCE,),
    "all of these": (FRICTION, SURFACE, TURBULENCE),
}
WITH_DRAG = ("drag strips", "all of these")

ACCURACY = 1e-3
"""m: what the default settings ask of flights without gusts."""

DEEPEST = 1.5e-3
"""m: what no impact passes."""

SPOT_CHECK = 20
"""One sound flight of so many is flown again as exactly as can be."""

ENOUGH = 0.95
"""Share of the flights flown again of which it is asked that they are as exact as they say: it is an estimate."""

LOOKED_AT = 10
"""Failed flights that are evaluated as a run does."""


@dataclass(frozen=True, eq=False)
class Flown:
    """One flight, with all that it takes to repeat it."""

    index: int
    agent: Agent
    scenario: Scenario
    trajectory: Trajectory


def with_drag(agent):
    """The agent with strips as wide as its slices, friction on all that is wet, and blunt ends."""
    x, volume, width = slice_solid(agent.body.outer, STRIPS).T
    strips = np.column_stack([x, 2 * np.sqrt(volume / (np.pi * width)), width, np.ones(STRIPS)])
    edges, radii = np.diff(agent.body.outer, axis=0), agent.body.outer[:, 1]
    wetted = float(np.pi * ((radii[1:] + radii[:-1]) * np.hypot(*edges.T)).sum())
    blunt = 0.8 * np.pi / 4 * agent.body.max_diameter**2
    drag = Drag(strips, friction_area=wetted, length=agent.body.length, ahead=blunt, astern=blunt)
    return replace(agent, coefficients=replace(agent.coefficients, drag=drag))


def flights_of(study, dragged, count, workers):
    pipeline, rng = study.make_pipeline(), np.random.default_rng(SEED)
    for start in range(0, count, BLOCK):
        indices = range(start, min(start + BLOCK, count))
        agents = [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in indices]
        if dragged:
            agents = [with_drag(agent) for agent in agents]
        scenarios = [pipeline.scenario.of_evaluation(SEED, index) for index in indices]
        flights = workers.map(pipeline.simulator.simulate, agents, scenarios, chunksize=4)
        yield from map(Flown, indices, agents, scenarios, flights)


def find_sides(flown, radius):
    """Return how far (m) the sides of the widest rim are beyond a bore that its middle touches, at each sample, (k,).

    The axis has the cosine c to the wall's tangent plane. The rim's point at the angle phi from its middle is farther out than
    its centre by r c cos(phi) + (r sin(phi))^2 / 2R: by most at cos(phi) = c R / r, which is (r - c R)^2 / 2R more than at
    the middle, and at the middle itself if c R > r.
    """
    across, r = flown.trajectory.position[:, 1:], flown.agent.body.max_diameter / 2
    normal = across / np.maximum(np.linalg.norm(across, axis=1), 1e-12)[:, None]
    axis = matrix_from_quaternion(flown.trajectory.quaternion)[:, 1:, 0]
    c = np.sqrt(np.maximum(0.0, 1 - (axis * normal).sum(axis=1) ** 2))
    return np.maximum(0.0, r - c * radius) ** 2 / (2 * radius)


def complaints(flown, pipeline):
    """What is unsound about a flight: nothing, if it is as its end says."""
    trajectory, scenario = flown.trajectory, flown.scenario
    [pipe] = scenario.pipe.segments
    if not all(
        np.isfinite(v).all() for v in (trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity)
    ):
        yield "is not finite"
    if (np.diff(trajectory.t) <= 0).any() or np.abs(np.linalg.norm(trajectory.quaternion, axis=1) - 1).max() > 1e-9:
        yield "has times out of order, or quaternions of another length than 1"
    if trajectory.end.failed:
        return
    where = {
        End.OUTLET: abs(trajectory.position[-1, 0] - pipe.end[0]) < 1e-9,
        End.INLET: trajectory.position[-1, 0] < -pipe.radius,
        End.HORIZON: abs(trajectory.t[-1] - scenario.flight.horizon) < 1e-9,
    }
    if not where[trajectory.end]:
        yield f"ends as {trajectory.end} after {trajectory.t[-1]} s at {trajectory.position[-1]}"
    # In gusts a chaotic flight states how far it may be off.
    accepted = np.inf if scenario.has_gusts else ACCURACY
    if trajectory.error is None or not trajectory.error <= accepted:
        yield f"passes with an error of {trajectory.error} m"
    if (wall_depths(flown.agent, trajectory, pipe.radius) - find_sides(flown, pipe.radius)).max() > DEEPEST:
        yield "goes through the wall"
    fitness = pipeline.fitness.score(trajectory, scenario, flown.agent)
    if not (np.isfinite(fitness).all() and (fitness >= 0).all() and (fitness <= 100).all()):
        yield f"has the fitness {fitness}"


def true_errors(sound, settings, workers):
    """How far (m) flights are from the same flown again, and state at most; and how many cannot be flown exactly.

    They are flown again to 0.01 mm, in gusts to 0.1 mm. What no tolerance fixes has no exact flight.
    """
    tight = ("simulator.tolerance=1e-9", "simulator.accuracy=1e-5", "simulator.tightest=1e-12")
    exact = load_study("paper", [*settings, *tight]).make_pipeline()
    again = list(workers.map(exact.simulator.simulate, [f.agent for f in sound], [f.scenario for f in sound]))
    errors = []
    for flown, trajectory in zip(sound, again, strict=True):
        if not trajectory.end.failed and trajectory.error <= 1e-4:
            times = np.arange(0, min(flown.trajectory.t[-1], trajectory.t[-1]), 0.01)
            apart = largest_distance(
                interpolate_positions(flown.trajectory, times), interpolate_positions(trajectory, times)
            )
            stated = flown.trajectory.error if flown.scenario.has_gusts else 0.0
            errors.append((apart, max(stated, ACCURACY)))
    return errors, len(again) - len(errors)


@pytest.mark.parametrize("occupied", ["insert", "skip"])
def test_no_flight_of_a_random_agent_fails_unseen(occupied, count_of, workers, publish):
    count = count_of("AGENTS", 1000)
    ends = list(End)
    lines = [
        f"| surroundings | {' | '.join(ends)} | unsound | checked | worst error mm | beyond 1 mm, in gusts beyond what it states |",
        "|---" * (len(ends) + 5) + "|",
    ]
    unsound, beyond, checked = [], 0, 0
    for name, settings in SURROUNDINGS.items():
        study = load_study("paper", [f"grammar.occupied='{occupied}'", *settings], run={"seed": SEED})
        pipeline, counts = study.make_pipeline(), Counter()
        sound, failed, found = [], [], []
        for flown in flights_of(study, name in WITH_DRAG, count, workers):
            counts[flown.trajectory.end] += 1
            found += [f"{occupied}, {name}, agent {flown.index} {what}" for what in complaints(flown, pipeline)]
            if flown.trajectory.end.failed:
                failed.append(flown)
            elif flown.index % SPOT_CHECK == 0:
                sound.append(flown)
        if name not in WITH_DRAG:
            # What a run would store of them.
            for flown in failed[:LOOKED_AT]:
                [evaluation] = pipeline.evaluate([flown.agent.genome], [evaluation_seed(SEED, flown.index)])
                if evaluation.failure is None or evaluation.fitness.any():
                    found.append(f"{occupied}, {name}, agent {flown.index} is no failed evaluation")
        errors, unknown = true_errors(sound, settings, workers)
        far = sum(error > stated for error, stated in errors)
        worst = 1e3 * max((error for error, _ in errors), default=np.nan)
        lines.append(
            f"| {name} | {' | '.join(str(counts[end]) for end in ends)} "
            f"| {len(found)} | {len(errors)} | {worst:.2g} | {far} |"
        )
        print(f"{occupied}, {name}: {len(failed)} of {count} fail; of those checked {unknown} have no exact flight")
        print(f"    {' '.join(str(flown.index) for flown in failed)}")
        unsound += found
        beyond += far
        checked += len(errors)
    lines += ["", f"{count} random agents in each of these surroundings."]
    if occupied == "insert":
        publish("ends with insert", lines)
    else:
        print("", *lines, sep="\n")
    assert unsound == []
    assert beyond <= (1 - ENOUGH) * checked
