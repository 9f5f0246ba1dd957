"""Neutral bodies that a pipe's flow carries

Source: H. S. Ellis, The pipeline flow of capsules, part 3: an experimental investigation of the transport by water of single
cylindrical and spherical capsules with density equal to that of the water, Canadian Journal of Chemical Engineering 42
(1964), from the abstract: in a pipe of 1 1/4 inches, bodies as dense as water were carried at 1.05 to 1.5 times the mean
velocity of the flow, the smaller the faster. In turbulent flow, a small body on the axis cannot be faster than the water
there.

Driftform: bodies as dense as the water, released on the axis with the mean velocity, in the logarithmic law at 1 m/s in a
smooth pipe, with `drag = "strips"`; the velocity after 3 s. Cylinders are 4 diameters long.

Left out: the flow through the narrow gap around a body that fills the bore, which Ellis' largest bodies had: the body does not
change the velocity profile. It is therefore checked up to a diameter of 0.3 of the bore.
"""

from dataclasses import replace

from solids import solid_agent

from driftform.agent import solid_of_revolution
from driftform.motion.forces.body_drag import estimate_drag, wake_factor
from driftform.testing.bodies import cylinder_body, spheroid_body
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import LogLawFlow
from driftform.water.scenario import FlightLimits, Release
from driftform_native.simulator import NativeOptions, NativeSimulator
from driftform_panels.coefficients import PanelMethod
from driftform_panels.solve import PanelOptions

BORE = 1.25 * 0.0254
FLUID = Fluid(density=998.0, viscosity=1.0e-6)


def carried(body, density=FLUID.density):
    """Return velocity over the mean velocity of the flow."""
    coefficients = PanelMethod(PanelOptions()).coefficients(body, FLUID)
    factor = wake_factor(coefficients, FLUID.density * solid_of_revolution(body.outer).volume)
    coefficients = replace(coefficients, drag=estimate_drag(body, FLUID.viscosity, factor))
    scenario = Scenario(
        pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(10.0, 0.0, 0.0), radius=BORE / 2),)),
        flow=LogLawFlow(speed=1.0),
        fluid=FLUID,
        release=Release(velocity=(1.0, 0.0, 0.0)),
        flight=FlightLimits(horizon=3.0),
    )
    flight = NativeSimulator(NativeOptions()).simulate(solid_agent(body, density, coefficients), scenario)
    assert not flight.end.failed
    return float(flight.position[-1, 0] - flight.position[len(flight.t) // 2, 0]) / float(
        flight.t[-1] - flight.t[len(flight.t) // 2]
    )


def measure():
    """Return rows of what is compared, measured and found."""
    rows = []
    for ratio in (0.1, 0.2, 0.3):
        r = ratio * BORE / 2
        rows.append((f"sphere, d/D {ratio}", "1.05 to 1.5", carried(spheroid_body(r, r, edges=100))))
    for ratio in (0.1, 0.2, 0.3):
        r = ratio * BORE / 2
        rows.append((f"cylinder, d/D {ratio}", "1.05 to 1.5", carried(cylinder_body(8 * r, r))))
    return rows
