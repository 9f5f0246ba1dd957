"""A captive submarine hull at a small angle and on a circle."""

import numpy as np
from scipy.interpolate import CubicSpline

from driftform.agent import solid_of_revolution
from driftform.motion.forces.body_drag import estimate_drag, wake_factor
from driftform.motion.forces.drag import still_water_wrench
from driftform.motion.forces.inertia import added_mass_at
from driftform.testing.bodies import make_body
from driftform.water import Fluid
from driftform_panels.solve import PanelMethod, PanelOptions

LENGTH, RADIUS, STATION, ORIGIN, SCALE = 4.356, 0.254, 0.21336, 2.013, 4.2608
SPEED = 6.5 * 1852 / 3600
OFFSETS = (
    (0, 0), (0.1, 0.29058), (0.2, 0.39396), (0.3, 0.46600), (0.4, 0.52147), (0.5, 0.56627), (0.6, 0.60352),
    (0.7, 0.63514), (1, 0.70744), (2, 0.84713), (3, 0.94066), (4, 0.99282), (7.7143, 1), (15.1429, 1),
    (16, 0.97598), (17, 0.81910), (18, 0.55025), (19, 0.26835), (20, 0.11724), (20.1, 0.11243), (20.2, 0.10074),
    (20.3, 0.07920), (20.4, 0.03178), (20.4167, 0),
)  # fmt: skip
"""Station from the nose, and radius over the greatest one."""

MEASURED = {"Y_v'": -5.948, "N_v'": -12.795, "Y_r'": 1.811, "N_r'": -1.597}
"""In thousandths."""


def make_hull():
    """Return the hull, its moment origin at x = 0."""
    station, radius = np.array(OFFSETS).T
    run = slice(13, 19)
    faired = CubicSpline(station[run], radius[run], bc_type=((1, 0.0), (2, 0.0)))
    bow = np.linspace(0, 1, 60) ** 2 * station[12]
    s = np.unique(np.concatenate([station, bow, np.linspace(15.1429, 20, 60)]))
    r = np.interp(np.sqrt(s), np.sqrt(station), radius)
    tail = (s > 15.1429) & (s < 20)
    r[tail] = faired(s[tail])
    return make_body(np.column_stack([ORIGIN - s * STATION, r * RADIUS])[::-1])


def derivatives(without=()):
    """Return Y_v', N_v', Y_r' and N_r' of the model, in thousandths."""
    body, fluid = make_hull(), Fluid(density=1000.0, viscosity=SPEED * LENGTH / 1.4e7)
    coefficients = PanelMethod(PanelOptions()).coefficients(body, fluid)
    factor = wake_factor(coefficients, fluid.density * solid_of_revolution(body.outer).volume)
    drag = estimate_drag(body, fluid.viscosity, factor, without)
    added = added_mass_at(coefficients, np.zeros(3))

    def sway_and_yaw(v, r):
        nu = np.array([SPEED, v, 0, 0, 0, r])
        momentum = added @ nu
        force = np.cross(momentum[:3], nu[3:])
        torque = np.cross(momentum[3:], nu[3:]) + np.cross(momentum[:3], nu[:3])
        friction = still_water_wrench(drag, (SPEED, v, 0.0), (0.0, 0.0, r), fluid.density, fluid.viscosity)
        return np.array([force[1], torque[2]]) + friction[[1, 5]]

    v, r = 1e-4 * SPEED, 1e-4 * SPEED / SCALE
    unit = 0.5 * fluid.density * SPEED * SCALE**2
    Y_v, N_v = (sway_and_yaw(v, 0) - sway_and_yaw(-v, 0)) / (2 * v) / [unit, unit * SCALE]
    Y_r, N_r = (sway_and_yaw(0, r) - sway_and_yaw(0, -r)) / (2 * r) / [unit * SCALE, unit * SCALE**2]
    return dict(zip(MEASURED, 1e3 * np.array([Y_v, N_v, Y_r, N_r]), strict=True))


def measure():
    """Return rows of what is compared, measured and found."""
    found, ideal = derivatives(), derivatives(("wake",))
    rows = [(f"{name}, thousandths", value, found[name]) for name, value in MEASURED.items()]
    return rows + [(f"{name} without the wake term, thousandths", v, ideal[name]) for name, v in MEASURED.items()]
