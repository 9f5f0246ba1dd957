"""Solid bodies that turbulent water carries through a straight pipe: flights with inertia, drag and lift, and where they end."""

from dataclasses import dataclass, replace

import numpy as np
from tracers import spread_evenly, straight_pipe

from driftform.agent import mass_properties
from driftform.motion.forces.body_drag import estimate_drag, wake_factor
from driftform.motion.forces.model import flight_model
from driftform.motion.forces.state import release_state
from driftform.motion.path.clearance import wall_clearances
from driftform.types import Agent, Body, End, FloatArray, Trajectory
from driftform.water.velocity import flow_array, pipe_rows, water_motion
from driftform_native.simulator import NativeOptions, NativeSimulator
from driftform_panels.solve import PanelMethod, PanelOptions

NEAR = 1e-4
"""Distance from the wall, m, below which a body counts as touching: it may have rebounded a moment ago."""


COUPLE = "couple"
"""The couple of creeping motion as a term to leave out, besides those of ``drag_without``."""


def make_carried_agent(body, scenario, ratio=1.0, without=()):
    """Return an agent with this body, of ``ratio`` times the mass of the water that it displaces, and no righting moment.

    ``without`` are terms of the drag to leave out.
    """
    water, mass = scenario.fluid, mass_properties(body)
    factor = ratio * water.density * mass.volume / mass.mass
    mass = replace(mass, mass=factor * mass.mass, inertia=factor * mass.inertia, cog=mass.cob)
    added = PanelMethod(PanelOptions()).coefficients(body, water)
    drag = estimate_drag(body, water.viscosity, wake_factor(added, water.density * mass.volume), without)
    if COUPLE in without:
        along, across, _, share = drag.creeping
        drag = replace(drag, creeping=(along, across, 0.0, share))
    return Agent(body, mass, replace(added, drag=drag))


RANKS = 400
"""Places of a section among which that of a body is ranked."""


def find_free_places(quaternion, scenario, agent):
    """Return those of :data:`RANKS` places of the section that the agent's origin can reach in an attitude, m, (n, 3)."""
    places = spread_evenly(RANKS, scenario.pipe.layout.inlet.radius)
    still = Trajectory(np.zeros(RANKS), places, np.tile(quaternion, (RANKS, 1)), np.zeros((RANKS, 6)), End.HORIZON)
    return places[wall_clearances(still, scenario, agent) > 0.0]


@dataclass(frozen=True)
class Carried:
    """Where bodies are after some diameters of the pipe.

    They are the share in the outer tenth of the area that their origins can reach, each in its own attitude, the share that
    touches the wall, the mean speed over that of ones which are spread evenly over that area in the attitudes of these, with its
    standard error, and the height (m) of each above the axis, (n,).
    """

    outer: float
    touching: float
    speed: float
    error: float
    heights: FloatArray


@dataclass(frozen=True)
class Carrying:
    """Bodies in a pipe of ``radius`` (m) and mean ``speed`` (m/s), observed after each of ``diameters`` of it.

    They are released along the pipe, or evenly in ``any_attitude``; their drag is ``without`` some terms.
    """

    body: Body
    radius: float
    speed: float
    diameters: tuple[float, ...]
    ratio: float = 1.0
    any_attitude: bool = False
    without: tuple[str, ...] = ()

    @property
    def scenario(self):
        times = 2 * self.radius / self.speed * np.array(self.diameters)
        return straight_pipe(
            self.radius, self.speed, length=6 * self.speed * times[-1] + 1.0, flight={"horizon": 1.01 * times[-1]}
        )

    @property
    def room(self):
        """The radius that the body's centre can reach, m."""
        return self.radius - self.body.max_diameter / 2

    def fly(self, seed, place):
        """Return x, z, clearance (m), the share of the area that is nearer to the axis, and its mean speed of water (m/s).

        They are for each time, (k, 5); the speed is the mean over the attitudes at the release and at all times up to it.
        """
        there = self.release_at(place).with_gusts(seed)
        agent = make_carried_agent(self.body, there, self.ratio, self.without)
        if self.any_attitude:
            rng = np.random.default_rng(seed)
            axis = rng.normal(size=3)
            there = self.release_at(place, axis).with_gusts(seed)
            attitude = release_state(flight_model(agent, there), there)[3:7]
            place = rng.choice(find_free_places(attitude, there, agent)).tolist()
            there = self.release_at(place, axis).with_gusts(seed)
        flight = NativeSimulator(NativeOptions(accuracy=0.1)).simulate(agent, there)
        assert not flight.end.failed
        rows = np.searchsorted(flight.t, 2 * self.radius / self.speed * np.array(self.diameters))
        part = replace(
            flight, **{name: getattr(flight, name)[rows] for name in ("t", "position", "quaternion", "velocity")}
        )
        attitudes = [flight.quaternion[0], *part.quaternion]
        release, *free = [np.hypot(*find_free_places(q, there, agent)[:, 1:].T) for q in attitudes]
        even = np.cumsum([self.mean_speed(r) for r in (release, *free)])[1:] / np.arange(2, len(free) + 2)
        off = np.hypot(*part.position[:, 1:].T)
        nearer = [np.mean(inner < r) for inner, r in zip(free, off, strict=True)]
        return np.column_stack([part.position[:, [0, 2]], wall_clearances(part, there, agent), nearer, even])

    def release_at(self, place, axis=(1.0, 0.0, 0.0)):
        """Return the scenario with a release of the body at ``place`` (m) with its ``axis``; world frame."""
        scenario, (x, y, z) = self.scenario, axis
        turned = {
            "yaw_deg": float(np.degrees(np.arctan2(y, x))),
            "pitch_deg": -float(np.degrees(np.arctan2(z, np.hypot(x, y)))),
        }
        release = scenario.release.model_copy(update={"position": tuple(place), "frame": "world", **turned})
        return scenario.model_copy(update={"release": release})

    def observe(self, count, run=map):
        """Return what ``count`` bodies do that are released evenly over the room of their centres; ``run`` is a map."""
        places = [place.tolist() for place in spread_evenly(count, self.room)]
        found = np.array(list(run(self.fly, range(count), places)))
        times = 2 * self.radius / self.speed * np.array(self.diameters)
        carried = []
        for k, time in enumerate(times):
            x, z, clear, nearer, even = found[:, k].T
            speeds = x / time / even.mean()
            error = float(speeds.std() / count**0.5)
            shares = float(np.mean(nearer > 0.9)), float(np.mean(clear < NEAR))
            carried.append(Carried(*shares, float(speeds.mean()), error, z))
        return carried

    def even_speed(self):
        """Return the mean speed of the water, as such bodies meet it, over the room of their centres, m/s."""
        return self.mean_speed(self.room * np.sqrt((np.arange(2000) + 0.5) / 2000))

    def mean_speed(self, r):
        """Return the mean speed of the water, as such bodies meet it along the pipe, at distances (m) from its axis, m/s."""
        scenario = self.scenario
        pipe, flow = pipe_rows(scenario), flow_array(scenario)
        across, along = estimate_drag(self.body, scenario.fluid.viscosity).spread
        spread = ((1.0, 0.0, 0.0), across, along)
        return float(np.mean([water_motion((0.0, y, 0.0), 0.0, pipe, flow, spread)[0][0] for y in r.tolist()]))
