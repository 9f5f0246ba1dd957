"""Added mass of a body of revolution by panels: contour -> potential on its surface -> added mass."""

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from driftform.agent import solid_of_revolution
from driftform.interfaces import Hydrodynamics, HydrodynamicsOptions, option
from driftform.types import Body, Coefficients, FloatArray
from driftform.water import Fluid
from driftform_panels.meridian import Panels, make_panels

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


MIN_WALL = 0.02
"""Least thickness of a wall relative to the length of its panels: thinner walls are not resolved."""


class PanelOptions(HydrodynamicsOptions):
    """Resolution of the meridian."""

    panels: int = option(
        20, "number of panels of a straight meridian without corners; every edge has at least one", ge=4, le=400
    )
    corner: float = option(
        0.2, "length of the panels at a corner that turns by more than 35 degrees, relative to its radius", gt=0, le=1
    )


@dataclass(frozen=True)
class PanelSolution:
    """Added mass of a body of revolution in water of density 1, about the point of its axis at x = ``origin``, m.

    It is A11 of surge and A22 = A33 of sway, m3, A66 = A55 of yaw, m5, and A26 and A62, the sway force of yaw and the yaw moment
    of sway, m4, which are equal (Green's reciprocity) except for the error of the discretisation. ``unknowns`` is their number
    in each of the two systems of equations.
    """

    origin: float
    surge: float
    sway: float
    sway_of_yaw: float
    yaw_of_sway: float
    yaw: float
    unknowns: int

    def matrix(self) -> FloatArray:
        """Return the added mass for density 1, (6, 6): symmetric, and positive semi-definite.

        A26 is the mean of its two values. A rotating sphere moves no water, and the error of the discretisation may
        make A66 negative: A66 is therefore at least A26^2 / A22, the least value of a semi-definite matrix.
        """
        coupling = (self.sway_of_yaw + self.yaw_of_sway) / 2
        turning = max(self.yaw, coupling * coupling / self.sway)
        added = np.diag([self.surge, self.sway, self.sway, 0.0, turning, turning])
        added[1, 5] = added[5, 1] = coupling
        added[2, 4] = added[4, 2] = -coupling
        return added


def solve(contour: npt.ArrayLike, options: PanelOptions | None = None, origin: float | None = None) -> PanelSolution:
    """Compute the added mass of a body of revolution in unbounded potential flow, with some resolution of its contour.

    The contour is x and r of the meridian, m, (n, 2), from the aft axis point to the fore axis point. It may fold back along x,
    like that of a cup, but must not cross or touch itself. ``origin`` is x (m) of the point of the axis that the result refers
    to; ``None`` for the centroid of the volume.

    Raises ValueError if the contour does not run from axis to axis, touches itself, or has a wall that is too thin
    for its panels.
    """
    points: FloatArray = np.asarray(contour, dtype=np.float64)
    options = options or PanelOptions()
    centre = solid_of_revolution(points).centroid if origin is None else origin
    return solve_panels(make_panels(points - (centre, 0.0), options.panels, options.corner), centre)


def solve_panels(divided: Panels, origin: float = 0.0) -> PanelSolution:
    """Compute the added mass about x = 0 of the panels; ``origin`` (m) is the x of that point in the body frame.

    A_ij = - int phi_i n_j dS with the potential phi_i of motion i, where the integral over the circle is 2 pi r for
    m = 0 and pi r for m = 1 (Newman, Marine Hydrodynamics, section 4.14).
    """
    # Imported here, because compiled code loads the compiler, and listing the plugins must not.
    from driftform_panels.kernels import assemble_equations

    wall = divided.thinnest_wall()
    if wall < MIN_WALL:
        raise ValueError(
            f"a wall is {wall:.2g} times as thick as its panels are long, but must be at least {MIN_WALL:g} times: "
            "raise hydrodynamics.panels"
        )
    matrices, sides, (x, r, nx, nr) = assemble_equations(divided.x, divided.r, divided.lengths)
    # More than one thread makes systems of this size slower, and much slower on busy cores.
    with _find_libraries().limit(limits=1, user_api="blas"):
        surge = np.linalg.solve(matrices[0], sides[:, 0])
        sway, yaw = np.linalg.solve(matrices[1], sides[:, 1:]).T
    across, turning = -np.pi * r * nr, -np.pi * r * (x * nr - r * nx)
    solution = PanelSolution(
        origin=origin,
        surge=float(-2 * np.pi * (r * nx) @ surge),
        sway=float(across @ sway),
        sway_of_yaw=float(across @ yaw),
        yaw_of_sway=float(turning @ sway),
        yaw=float(turning @ yaw),
        unknowns=len(x),
    )
    if not (math.isfinite(solution.surge + solution.yaw) and solution.surge > 0 and solution.sway > 0):
        raise ValueError(
            "the flow around this contour has no solution: check that the contour does not cross or touch itself"
        )
    return solution


@cache
def _find_libraries() -> "ThreadpoolController":
    """Return the libraries of linear algebra, which takes a while."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


class PanelMethod(Hydrodynamics[PanelOptions]):
    """Added mass of any body of revolution in unbounded potential flow, about the centre of buoyancy.

    Boundary elements on the meridian, with the integral over the circle in closed form: Green's identity for the
    potentials of surge, which are axisymmetric, and of sway and yaw, which vary as the cosine; three collocation points
    on each panel. With the default panels, 141 unknowns in the median, M11 of 200 random agents is within
    0.1 % of the result with `panels = 100` and `corner = 0.02`; M22, M55 and M26 (relative to the root of M22 M66) are
    within 0.03 %. A wall must be at least a fiftieth as thick as its panels are long.
    """

    name = "panels"
    Options = PanelOptions

    def coefficients(self, body: Body, fluid: Fluid) -> Coefficients:
        """Return the added mass about the centre of buoyancy."""
        contour = np.ascontiguousarray(body.outer, dtype=np.float64)
        solution = _solve_once(contour.tobytes(), self.options.panels, self.options.corner)
        return Coefficients(fluid.density * solution.matrix(), origin=np.array([solution.origin, 0.0, 0.0]))


@lru_cache(maxsize=128)
def _solve_once(contour: bytes, panels: int, corner: float) -> PanelSolution:
    """Solve for a contour, (n, 2) as bytes; the same hull is flown in water of many densities."""
    return solve(np.frombuffer(contour).reshape(-1, 2), PanelOptions(panels=panels, corner=corner))
