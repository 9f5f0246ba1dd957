"""Solid bodies that turbulent water carries through a straight pipe: flights with inertia, drag and lift, and where they end."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from tracers import spread_evenly, straight_pipe

from driftform.agent import mass_properties
from driftform.motion.forces.body_drag import estimate_drag, wake_factor
from driftform.motion.path.clearance import wall_clearances
from driftform.types import Agent, Body, FloatArray, Trajectory
from driftform.water import Scenario
from driftform.water.velocity import flow_array, pipe_rows, water_motion
from driftform_native.simulator import NativeOptions, NativeSimulator
from driftform_panels.coefficients import PanelMethod, PanelOptions

NEAR = 1e-4
"""Distance from the wall, m, below which a body counts as touching: it may have rebounded a moment ago."""


def make_carried_agent(body: Body, scenario: Scenario, ratio: float = 1.0) -> Agent:
    """Return an agent with this body, of ``ratio`` times the mass of the water that it displaces, and no righting moment."""
    water, mass = scenario.fluid, mass_properties(body)
    factor = ratio * water.density * mass.volume / mass.mass
    mass = replace(mass, mass=factor * mass.mass, inertia=factor * mass.inertia, cog=mass.cob)
    added = PanelMethod(PanelOptions()).coefficients(body, water)
    drag = estimate_drag(body, water.viscosity, wake_factor(added, water.density * mass.volume))
    return Agent(body, mass, replace(added, drag=drag))


RANKS = 400
"""Places of a section among which that of a body is ranked."""


@dataclass(frozen=True)
class Carried:
    """Where bodies are after some diameters of the pipe.

    They are the share in the outer tenth of the area that their origins can reach, each in its own attitude, the share that
    touches the wall, the mean speed over that of evenly spread ones, and the height (m) of each above the axis, (n,).
    """

    outer: float
    touching: float
    speed: float
    heights: FloatArray


@dataclass(frozen=True)
class Carrying:
    """Bodies in a pipe of ``radius`` (m) and mean ``speed`` (m/s), observed after each of ``diameters`` of it."""

    body: Body
    radius: float
    speed: float
    diameters: tuple[float, ...]
    ratio: float = 1.0

    @property
    def scenario(self) -> Scenario:
        times = 2 * self.radius / self.speed * np.array(self.diameters)
        return straight_pipe(
            self.radius, self.speed, length=6 * self.speed * times[-1] + 1.0, flight={"horizon": 1.01 * times[-1]}
        )

    @property
    def room(self) -> float:
        """The radius that the body's centre can reach, m."""
        return self.radius - self.body.max_diameter / 2

    def fly(self, seed: int, place: list[float]) -> FloatArray:
        """Return x, z, clearance (m) and the share of the area that is nearer to the axis after each time, (k, 4)."""
        scenario = self.scenario
        release = scenario.release.model_copy(update={"position": tuple(place), "frame": "world"})
        agent = make_carried_agent(self.body, scenario, self.ratio)
        there = scenario.with_gusts(seed).model_copy(update={"release": release})
        flight = NativeSimulator(NativeOptions(accuracy=0.1)).simulate(agent, there)
        assert not flight.end.failed
        rows = np.searchsorted(flight.t, 2 * self.radius / self.speed * np.array(self.diameters))
        part = replace(
            flight, **{name: getattr(flight, name)[rows] for name in ("t", "position", "quaternion", "velocity")}
        )
        nearer = [self.rank(part, k, there, agent) for k in range(len(rows))]
        return np.column_stack([part.position[:, [0, 2]], wall_clearances(part, there, agent), nearer])

    def rank(self, flight: Trajectory, k: int, scenario: Scenario, agent: Agent) -> float:
        """Return how much of the area that the origin can reach in the attitude of sample ``k`` is nearer to the axis."""
        places = spread_evenly(RANKS, self.radius)
        t, turned = np.zeros(RANKS), np.tile(flight.quaternion[k], (RANKS, 1))
        there = replace(flight, t=t, position=places, quaternion=turned, velocity=np.zeros((RANKS, 6)))
        free = places[wall_clearances(there, scenario, agent) > 0.0]
        return float(np.mean(np.hypot(*free[:, 1:].T) < np.hypot(*flight.position[k, 1:])))

    def observe(self, count: int, run: Callable[..., Iterable[Any]] = map) -> list[Carried]:
        """Return what ``count`` bodies do that are released evenly over the room of their centres; ``run`` is a map."""
        places = [place.tolist() for place in spread_evenly(count, self.room)]
        found = np.array(list(run(self.fly, range(count), places)))
        times = 2 * self.radius / self.speed * np.array(self.diameters)
        even, carried = self.even_speed(), []
        for k, time in enumerate(times):
            x, z, clear, nearer = found[:, k].T
            carried.append(
                Carried(float(np.mean(nearer > 0.9)), float(np.mean(clear < NEAR)), float(x.mean() / time / even), z)
            )
        return carried

    def even_speed(self) -> float:
        """Return the mean speed of the water, as such bodies meet it, over the room of their centres, m/s."""
        scenario = self.scenario
        pipe, flow = pipe_rows(scenario), flow_array(scenario)
        across, along = estimate_drag(self.body, scenario.fluid.viscosity).spread
        spread, r = ((1.0, 0.0, 0.0), across, along), self.room * np.sqrt((np.arange(2000) + 0.5) / 2000)
        return float(np.mean([water_motion((0.0, y, 0.0), 0.0, pipe, flow, spread)[0][0] for y in r.tolist()]))
