"""Solid bodies that the water of a smooth pipe carries."""

from dataclasses import replace

from solids import solid_agent

from driftform.agent import solid_of_revolution
from driftform.motion.forces.body_drag import estimate_drag, wake_factor
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import LogLawFlow
from driftform.water.scenario import Contact, FlightLimits, Release
from driftform_native.simulator import NativeOptions, NativeSimulator
from driftform_panels.solve import PanelMethod, PanelOptions

BORE = 1.25 * 0.0254
"""Inner diameter of Ellis' pipe, m."""

FOOT = 0.3048

FLUID = Fluid(density=998.0, viscosity=1.0e-6)


def make_pipe(speed, bore, horizon, friction=0.3, fall=0.0, **release):
    """Return a smooth pipe with the logarithmic law; lengths in m, ``speed`` in m/s, ``fall`` in m for each m of length."""
    length = 2 * speed * horizon + 1.0
    return Scenario(
        pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(length, 0.0, -fall * length), radius=bore / 2),)),
        flow=LogLawFlow(speed=speed),
        fluid=FLUID,
        release=Release.model_validate(release),
        contact=Contact(friction=friction),
        flight=FlightLimits(horizon=horizon),
    )


def carry(body, density, scenario):
    """Return the flight of a solid of ``density`` times the water's."""
    added = PanelMethod(PanelOptions()).coefficients(body, FLUID)
    factor = wake_factor(added, FLUID.density * solid_of_revolution(body.outer).volume)
    coefficients = replace(added, drag=estimate_drag(body, FLUID.viscosity, factor))
    flight = NativeSimulator(NativeOptions()).simulate(
        solid_agent(body, density * FLUID.density, coefficients), scenario
    )
    assert not flight.end.failed
    return flight


def carry_along_floor(body, density, speed, bore, horizon, friction=0.3, fall=0.0):
    """Return the flight of a solid from rest on the floor; see :func:`make_pipe`."""
    place = {"position": (0.0, 0.0, (body.max_diameter - bore) / 2), "velocity": "rest"}
    return carry(body, density, make_pipe(speed, bore, horizon, friction, fall, **place))


def last_speed(flight, share=0.2):
    """Return the mean speed over ground in the last ``share`` of a flight, m/s."""
    first = int(flight.t.searchsorted((1 - share) * flight.t[-1]))
    way = flight.position[-1] - flight.position[first]
    return float((way @ way) ** 0.5 / (flight.t[-1] - flight.t[first]))
