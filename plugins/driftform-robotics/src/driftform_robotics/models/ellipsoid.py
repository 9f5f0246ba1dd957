"""Link -> the ellipsoids by which MuJoCo computes the forces of water on a body.

The forces are those of MuJoCo's documentation, "Computation: fluid forces, ellipsoid model", and of
``mj_ellipsoidFluidModel`` in ``src/engine/engine_passive.c``: Coriolis forces of each ellipsoid's added mass, drag and lift.
"""

import numpy as np

from driftform.interfaces import ExportJob
from driftform.motion import forces
from driftform.types import FloatArray
from driftform_robotics.models.fitting import solve_bounded, weigh_motions
from driftform_robotics.models.link import Link, quadratic_wrench

STATIONS = 5
"""Number of needles along the body, which have its drag across the axis."""

_MAX_SLENDERNESS = 1e4
"""Greatest ratio of length to diameter, and of diameter to length, of the ellipsoid."""

_NEEDLE, _DISC = (0.05, 0.005), (0.0025, 0.025)
"""Half axes along and across the body's axis, over the body's length: what they add to the added mass is negligible."""


def added_mass_factors(ratio: float) -> tuple[float, float, float]:
    """Return the added mass along and across a spheroid's axis over the displaced one, and the inertia over that times a^2.

    ``ratio`` is its radius over its half length a. Lamb, Hydrodynamics (6th ed.), sections 114 and 115, with his alpha_0 as
    2/3 a b^2 R_D(b^2, b^2, a^2) by Carlson's integral (DLMF 19.16.5); alpha_0 and twice beta_0 sum to 2.

    >>> [round(k, 4) for k in added_mass_factors(0.5)]
    [0.21, 0.7042, 0.0599]
    """
    from scipy.special import elliprd

    s = ratio * ratio
    alpha = 2 / 3 * s * float(elliprd(s, s, 1.0))
    beta = (2 - alpha) / 2
    turning = 0.0
    if abs(1 - s) > 1e-9 * (1 + s):
        turning = (1 - s) ** 2 * (beta - alpha) / (2 * (1 - s) - (1 + s) * (beta - alpha)) / 5
    return alpha / (2 - alpha), beta / (2 - beta), turning


def added_mass(a: float, b: float, x: float, density: float) -> FloatArray:
    """Return the added mass of a spheroid with half axes a and b (m) at x (m), about the centre of gravity, (6, 6)."""
    along, across, turning = added_mass_factors(b / a)
    own = np.diag([along, across, across, 0.0, turning * a * a, turning * a * a])
    return density * 4 / 3 * np.pi * a * b * b * forces.shift_origin(own, np.array([-x, 0.0, 0.0]))


def fit_spheroid(along: float, across: float, density: float) -> tuple[float, float]:
    """Return the half axes (m) of the spheroid with these added masses (kg) in water of a density, kg/m3."""
    from scipy.optimize import brentq

    def excess(log_ratio: float) -> float:
        k1, k2, _ = added_mass_factors(float(np.exp(log_ratio)))
        return float(np.log(k1 / k2) - np.log(along / across))

    bound = float(np.log(_MAX_SLENDERNESS))
    ratio = float(np.exp(brentq(excess, -bound, bound, xtol=1e-12)))
    a = float(np.cbrt(along / added_mass_factors(ratio)[0] / (density * 4 / 3 * np.pi * ratio**2)))
    return a, ratio * a


def fit_ellipsoids(job: ExportJob, link: Link) -> FloatArray:
    """Return ellipsoids with the added mass of a link along and across its axis, and with the agent's drag, (n, 7).

    A row has the half axes along and across the body's axis, the place on it (m, from the centre of gravity), and
    MuJoCo's coefficients of blunt and angular drag, and of lift by Kutta and Magnus. The first has the added mass; a disc
    has drag along the axis, and needles have it across. The coefficients are those whose forces are nearest to the agent's
    (:func:`driftform_robotics.models.fitting.weigh_motions`); those of drag are not negative.
    """
    from driftform_robotics.models.stepping import add_ellipsoid

    agent, fluid = job.agent, job.scenario.fluid
    length, density, x = agent.body.length, fluid.density, float(link.added_mass[1, 5] / link.added_mass[1, 1])
    main = (*fit_spheroid(float(link.added_mass[0, 0]), float(link.added_mass[1, 1]), density), x)
    aft = float(agent.body.outer[:, 0].min() - agent.mass.cog[0])
    places = aft + length * (np.arange(STATIONS) + 0.5) / STATIONS
    small = [
        (*(length * axis for axis in _DISC), x),
        *((*(length * axis for axis in _NEEDLE), place) for place in places),
    ]
    rows = np.zeros((1 + len(small), 7))
    rows[:, :3] = [main, *small]
    unknown = [(0, column) for column in range(3, 7)] + [(row, 3) for row in range(1, len(rows))]
    motions, shares = weigh_motions(job, link)
    wanted = np.array([quadratic_wrench(agent, fluid, nu) for nu in motions])
    columns = np.zeros((len(motions), 6, len(unknown)))
    for k, (row, column) in enumerate(unknown):
        unit = np.where(np.arange(7) < 3, rows[row], 0.0)
        unit[column] = 1.0
        for nu, out in zip(motions, columns[:, :, k], strict=True):
            wrench = np.zeros(6)
            add_ellipsoid(unit, nu, density, wrench)
            out[:] = wrench
    # Forces count as accelerations, and moments as those of points half a length away.
    weights = 1 / np.array([link.mass] * 3 + [2 * inertia / length for inertia in np.diag(link.inertia)])
    weights = weights * shares[:, None]
    matrix, target = (columns * weights[:, :, None]).reshape(-1, len(unknown)), (wanted * weights).ravel()
    lower = [0.0, 0.0, -np.inf, -np.inf, *[0.0] * len(small)]
    found = solve_bounded(matrix, target, lower, [np.inf] * len(unknown))
    for (row, column), value in zip(unknown, found.tolist(), strict=True):
        rows[row, column] = value
    return rows
