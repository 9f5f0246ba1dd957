"""Forces along an agent's own flight -> coefficients of terms that a program has.

The flight is that of the first seconds after the release, in open water: along it the terms come nearest to drag by strips
and to the lift of the tail, which no program has. Other motions have weights that keep their forces passive.
"""

import numpy as np
import numpy.typing as npt

from driftform.interfaces import ExportJob
from driftform.types import FloatArray
from driftform_robotics.models.gap import list_motions, quadratic_products
from driftform_robotics.models.link import MIN_SPEED, Link, list_single_motions, quadratic_wrench

RIDGE = 1e-3
"""Weight that keeps coefficients small which the flight does not determine."""

SINGLE = 0.1
"""Weight of motions along or about one axis, relative to all of the flight."""

_TERMS = ((0, 2, 2), (0, 2, 0), (1, 2, 0), (0, 2, 4), (0, 4, 2), (0, 4, 4), (0, 4, 0), (1, 4, 0))
"""Products of rates j and |k| (0), and j and k (1), in the plane of pitch: surge 0, heave 2, pitch 4."""

_YAW = {0: (0, 1.0), 2: (1, 1.0), 4: (5, -1.0)}
"""Component in the plane of yaw, and its sign, for each in the plane of pitch: a quarter of a turn about the axis."""


def solve_bounded(matrix: FloatArray, target: FloatArray, lower: npt.ArrayLike, upper: npt.ArrayLike) -> FloatArray:
    """Return x between bounds with ``matrix @ x`` nearest to ``target``; x is small where the matrix does not say it."""
    from scipy.optimize import lsq_linear

    norms = np.linalg.norm(matrix, axis=0)
    norms[norms <= 1e-9 * norms.max()] = np.inf
    ridge = RIDGE * max(float(np.linalg.norm(target)), 1e-300) * np.eye(len(norms))
    whole = np.concatenate((matrix / norms, ridge))
    scale = np.where(np.isfinite(norms), norms, 1.0)
    bounds = np.array(lower) * scale, np.array(upper) * scale
    found: FloatArray = lsq_linear(whole, np.concatenate((target, np.zeros(len(norms)))), bounds).x / norms
    return found


def weigh_motions(job: ExportJob, link: Link) -> tuple[FloatArray, FloatArray]:
    """Return motions to which forces are fitted, (n, 6), and their weights, (n,)."""
    single, flown = list_single_motions(job.agent, link.drag_speed or MIN_SPEED), list_motions(job, link)
    share = np.sqrt(SINGLE * max(1, len(flown)) / len(single))
    return np.concatenate((flown, single)), np.repeat([1.0, share], [len(flown), len(single)])


def fit_products(job: ExportJob, link: Link) -> FloatArray:
    """Return the forces per product of rates j and |k|, and of j and k, that are nearest to the agent's drag, (2, 6, 6, 6).

    Force and moment i about the centre of gravity are [0, i, j, k] nu_j |nu_k| + [1, i, j, k] nu_j nu_k. Without drag by
    strips they are those of the link's quadratic damping.
    """
    products = quadratic_products(link.quadratic_damping)
    if job.agent.coefficients.drag is None:
        return products
    motions, weights = weigh_motions(job, link)
    lacking = np.array([quadratic_wrench(job.agent, job.scenario.fluid, nu) for nu in motions])
    lacking += (np.abs(motions) * motions) @ link.quadratic_damping.T

    def turn(rates: FloatArray) -> FloatArray:
        """Return vectors of the plane of yaw as those of the plane of pitch."""
        return np.array([sign * rates[:, i] for i, sign in _YAW.values()])

    planes = np.concatenate((motions[:, [0, 2, 4]].T, turn(motions)), axis=1)
    forces = np.concatenate((lacking[:, [0, 2, 4]].T, turn(lacking)), axis=1)
    twice, rates = np.tile(weights, 2), dict(zip((0, 2, 4), planes, strict=True))
    columns = np.column_stack([rates[j] * (rates[k] if kind else abs(rates[k])) for kind, j, k in _TERMS])
    for row, target in ((2, forces[1]), (4, forces[2])):
        # Damping along and about an axis remains damping.
        upper = [link.quadratic_damping[row, j] if row == j == k else np.inf for _, j, k in _TERMS]
        found = solve_bounded(columns * twice[:, None], target * twice, [-np.inf] * len(_TERMS), upper)
        for (kind, j, k), value in zip(_TERMS, found.tolist(), strict=True):
            products[kind, row, j, k] += value
            # The second rate is a magnitude, or that of surge, which both planes share: its sign is no other.
            (i, a), (m, b), (n, _) = _YAW[row], _YAW[j], _YAW[k]
            products[kind, i, m, n] += a * b * value
    surge = np.column_stack((motions[:, 0] * abs(motions[:, 0]), motions[:, 0] ** 2)) * weights[:, None]
    limit = link.quadratic_damping[0, 0]
    products[:, 0, 0, 0] += solve_bounded(surge, lacking[:, 0] * weights, [-np.inf] * 2, [limit, np.inf])
    return products
