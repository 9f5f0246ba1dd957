"""What a flight costs, and how exact it is, beside other ways to integrate the same equations.

Times are compared with those of the least that could be done: 300 equal steps of the classical Runge-Kutta method in
compiled code, which nothing controls.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from driftform.motion.forces.model import flight_model
from driftform.motion.forces.rates import fill_rate
from driftform.motion.forces.state import SAMPLE, release_state
from driftform.motion.path.interpolation import interpolate_positions
from driftform.motion.path.trajectory import finish_trajectory
from driftform.motion.solver.error import Accuracy, integrate
from driftform.runs.compression import encode
from driftform.study import load_study
from driftform.testing.simulator import largest_distance
from driftform.water.outlets import has_left_pipe

pytestmark = pytest.mark.slow

STEPS = 300
TRIM = 0.004
"""Largest net buoyancy of a trimmed agent, relative to its displacement."""

TOLERANCE = 1e-6
"""Of the peer."""


@njit
def rate(t, y, model):
    out = np.empty(SAMPLE - 1)
    fill_rate(t, y, model, out)
    return out


@njit
def runge_kutta(model, start, horizon, steps):
    h, t, y = horizon / steps, 0.0, start.copy()
    samples = np.empty((steps + 1, SAMPLE))
    samples[0, 0], samples[0, 1:] = t, y
    for k in range(steps):
        a = rate(t, y, model)
        b = rate(t + h / 2, y + h / 2 * a, model)
        c = rate(t + h / 2, y + h / 2 * b, model)
        d = rate(t + h, y + h * c, model)
        y = y + h / 6 * (a + 2 * b + 2 * c + d)
        y[3:7] /= np.sqrt((y[3:7] ** 2).sum())
        t += h
        samples[k + 1, 0], samples[k + 1, 1:] = t, y
    return samples


class Course:
    """One agent in its scenario, with its flight as exact as can be."""

    def __init__(self, agent, scenario) -> None:
        self.agent, self.scenario = agent, scenario
        self.model = flight_model(agent, scenario)
        self.start = release_state(self.model, scenario)
        exact = Accuracy(position=1e-6, tolerance=1e-9, tightest=1e-12)
        found = integrate(self.model, self.start, scenario.flight.horizon, exact)
        self.exact, self.doubt = self.finished(found.samples), found.error

    def finished(self, samples):
        return finish_trajectory(samples, self.model, self.scenario.flight.horizon, len(samples))

    def error(self, trajectory) -> float:
        """How far a flight gets from the exact one, m; infinite where it stops before."""
        if trajectory.t[-1] < self.exact.t[-1] - 0.1:
            return math.inf
        times = np.arange(0, min(trajectory.t[-1], self.exact.t[-1]), 0.01)
        return largest_distance(interpolate_positions(trajectory, times), interpolate_positions(self.exact, times))

    def by_runge_kutta(self):
        return runge_kutta(self.model, self.start, self.exact.t[-1], STEPS)

    def by_scipy(self):
        def outlet(_, y):
            return -1.0 if has_left_pipe((y[0], y[1], y[2]), self.model.pipe) else 1.0

        outlet.terminal = True
        # The first trial of a step may end deep in the wall, where the next stages overflow; SciPy then shortens it.
        with np.errstate(all="ignore"):
            solution = solve_ivp(
                lambda t, y: rate(t, y, self.model),
                (0, self.scenario.flight.horizon),
                self.start,
                "DOP853",
                rtol=TOLERANCE,
                atol=TOLERANCE,
                max_step=0.05,
                events=outlet,
            )
        return np.column_stack([solution.t, solution.y.T])


def ellipsoid(agent, scenario):
    """The agent as MuJoCo can hold it: an ellipsoid of its size and mass, free in its model of a fluid."""
    import mujoco

    body, mass, fluid = agent.body, agent.mass, scenario.fluid
    half, radius = body.length / 2, body.max_diameter / 2
    inertia = " ".join(f"{value:.9g}" for value in np.diag(mass.inertia))
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
          <option density="{fluid.density}" viscosity="{fluid.density * fluid.viscosity}"
                  gravity="0 0 -{fluid.gravity}" wind="{scenario.flow.speed} 0 0"/>
          <worldbody><body gravcomp="{fluid.density * mass.volume / mass.mass}">
            <freejoint/>
            <inertial pos="0 0 0" mass="{mass.mass}" diaginertia="{inertia}"/>
            <geom type="ellipsoid" size="{half} {radius} {radius}" fluidshape="ellipsoid"/>
          </body></worldbody>
        </mujoco>"""
    )
    return model, mujoco.MjData(model), scenario.flow.speed


def by_mujoco(ready) -> None:
    import mujoco

    model, data, speed = ready
    mujoco.mj_resetData(model, data)
    data.qvel[0] = speed
    mujoco.mj_step(model, data, nstep=round(9.0 / model.opt.timestep))


@pytest.fixture(scope="module")
def pipelines():
    return {use: load_study("paper", use={"simulator": use}).make_pipeline() for use in ("native", "exudyn")}


def trimmed(agents, pipeline):
    """The agents that reach no wall when they weigh nearly what they displace."""
    rng = np.random.default_rng(5)
    for agent in agents:
        neutral = pipeline.scenario.fluid.density * agent.mass.volume
        light = replace(agent, mass=replace(agent.mass, mass=neutral * (1 + rng.uniform(-TRIM, TRIM))))
        if pipeline.fly([light])[0].contact is None:
            yield light


def make_courses(pipeline, kind, count):
    rng = np.random.default_rng(4)
    agents = (pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(100 * count))
    if kind == "without contact":
        agents = trimmed(agents, pipeline)
    courses = [Course(agent, pipeline.scenario) for _, agent in zip(range(count), agents, strict=False)]
    assert len(courses) == count
    runge_kutta(courses[0].model, courses[0].start, 0.1, 1)
    return courses


@pytest.mark.parametrize("kind", ["without contact", "with contact"])
def test_what_a_flight_costs_and_how_exact_it_is(kind, pipelines, count_of, milliseconds):
    native, count = pipelines["native"], count_of("AGENTS", 60)
    scenario, courses = native.scenario, make_courses(native, kind, count)

    def by(use: str):
        return lambda course: pipelines[use].simulator.simulate(course.agent, scenario)

    ways = {
        "300 steps of Runge-Kutta": lambda course: course.finished(course.by_runge_kutta()),
        "native": by("native"),
        "Exudyn": by("exudyn"),
        "SciPy's DOP853": lambda course: course.finished(course.by_scipy()),
    }
    timed = {"300 steps of Runge-Kutta": Course.by_runge_kutta, "SciPy's DOP853": Course.by_scipy}
    times = {name: milliseconds(timed.get(name, way), courses) for name, way in ways.items()}
    times["MuJoCo, an ellipsoid without walls"] = milliseconds(
        by_mujoco, [ellipsoid(course.agent, scenario) for course in courses]
    )
    plain = np.median(times["300 steps of Runge-Kutta"])
    lines = [
        "| flight | median ms | 90 % ms | over 300 plain steps | median error mm | worst error mm |",
        "|---|---|---|---|---|---|",
    ]
    for name, taken in times.items():
        errors = "| | |"
        if name in ways:
            found = [1e3 * course.error(ways[name](course)) for course in courses]
            errors = f"| {np.median(found):.2g} | {max(found):.2g} |"
        median, high = np.median(taken), np.quantile(taken, 0.9)
        lines.append(f"| {name} | {median:.3g} | {high:.3g} | {median / plain:.3g} {errors}")
    doubt = max(course.doubt for course in courses)
    lines += [
        "",
        f"{count} agents {kind}, each the best of three. The error of the exact flights is below {1e3 * doubt:.1g} mm. SciPy "
        f"and the plain steps integrate the compiled motion in space, SciPy with a tolerance of {TOLERANCE:g}; the "
        f"two simulators use the fact that these flights stay in the vertical plane. MuJoCo takes its usual steps of 2 ms "
        f"for 9 s.",
    ]
    print("", *lines, sep="\n")


@pytest.mark.parametrize("kind", ["without contact", "with contact"])
def test_what_an_evaluation_costs_over_plain_steps(kind, pipelines, count_of, milliseconds):
    native, count = pipelines["native"], count_of("AGENTS", 60)
    scenario, courses = native.scenario, make_courses(native, kind, count)
    agents = [course.agent for course in courses]
    genomes, flights = [agent.genome for agent in agents], native.fly(agents)
    # A pipeline keeps its bodies: each call gets another one.
    genome_to_agent = milliseconds(lambda genome: replace(native).make_agent(genome), genomes)
    model = milliseconds(lambda agent: flight_model(agent, scenario), agents)
    unchecked = milliseconds(lambda agent: native.simulator.screen_batch([agent], [scenario], lambda *_: False), agents)
    checked = milliseconds(lambda agent: native.fly([agent]), agents)
    score = milliseconds(lambda trajectory: native.score(trajectory, agents[0]), flights)
    code = milliseconds(encode, flights)
    plain = milliseconds(Course.by_runge_kutta, courses)
    rows = {
        "300 steps of Runge-Kutta": [plain],
        "genome to agent": [genome_to_agent],
        "flight model": [model],
        "encode for the store": [code],
        "these three: all that is neither flight nor score": [genome_to_agent, model, code],
        "genome to ten fitnesses, unchecked": [genome_to_agent, unchecked, score],
        "genome to ten fitnesses, checked": [genome_to_agent, checked, score],
    }
    lines = ["| part | median ms | over 300 plain steps |", "|---|---|---|"]
    for name, parts in rows.items():
        taken = np.sum(parts, axis=0)
        lines.append(f"| {name} | {np.median(taken):.3g} | {np.median(taken / plain):.3g} |")
    lines += ["", f"{count} agents {kind}, each the best of three; a flight includes its model."]
    print("", *lines, sep="\n")
