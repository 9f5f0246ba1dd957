"""How far an agent's path in MuJoCo is from its own: the equations of motion with and without the inertia of added mass.

About the centre of gravity, in the frame of a uniform current, with (P, H) = M_A nu and nu = (v, w) in body axes (Fossen,
Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., eq. 6.1 to 6.3)::

    (M_RB + M_A) nu' = (m v x w, I w x w) + (P x w, H x w + P x v) - D_1 nu - D_2 |nu| nu + weight and buoyancy

MuJoCo has the same right-hand side, up to its ellipsoid, and M_RB alone on the left.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from driftform.motion import inertia
from driftform.types import FloatArray
from driftform.water import Fluid
from driftform_robotics.models.link import Link

SECONDS = 3.0
"""Longest duration of the paths that are compared, s."""

REACH = 1.0
"""Distance from the release at which the comparison ends in open water, m; in a pipe its least radius."""

FAR = 20.0
"""MuJoCo's path ends there, in such distances."""

STEPS = 4000
"""Largest number of steps of a path, which ends with them: an agent of foam tumbles thousands of times a second there."""

LEVEL = 0.1
"""An agent that rises or sinks by less than this share of the larger change of height keeps its height."""

_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Paths:
    """Displacements of the centre of gravity relative to the water, m, (3,), ``seconds`` after the release.

    ``true`` with the inertia of added mass, ``mujoco`` without.
    """

    seconds: float
    true: FloatArray
    mujoco: FloatArray

    @property
    def apart(self) -> float:
        """Distance of the two, m."""
        return float(np.linalg.norm(self.true - self.mujoco))

    @property
    def differ_in_kind(self) -> bool:
        """Whether the agent rises, sinks or keeps its height in one path and not in the other."""
        return self._sense(self.true) != self._sense(self.mujoco)

    def describe(self) -> str:
        """Say in a sentence or two what MuJoCo makes of the path."""
        true, wrong = self._describe_climb(self.true), self._describe_climb(self.mujoco)
        when = f"{self.seconds:.2g} s after its release"
        if self.differ_in_kind:
            return (
                f"MUJOCO'S PATH DIFFERS IN KIND: {when} in open water this agent {true}; in MuJoCo it {wrong}, for want of "
                "the inertia of added mass. Do not predict with this model where it goes."
            )
        return (
            f"MuJoCo's path is wrong by {self.apart:.2g} m {when} in open water, for want of the inertia of added mass: "
            f"the agent {true}, in MuJoCo it {wrong}."
        )

    def _sense(self, path: FloatArray) -> int:
        least = LEVEL * max(abs(float(self.true[2])), abs(float(self.mujoco[2])))
        return 0 if abs(path[2]) <= least else int(np.sign(path[2]))

    def _describe_climb(self, path: FloatArray) -> str:
        words = {1: "has risen by", -1: "has sunk by", 0: "has kept its height within"}
        return f"{words[self._sense(path)]} {abs(float(path[2])):.2g} m"


def compare_paths(link: Link, fluid: Fluid, current: FloatArray, reach: float = REACH) -> Paths:
    """Return the paths of a link in open water with a uniform ``current`` (m/s, (3,)), until it has gone ``reach`` (m)."""
    total = link.rigid_mass + link.added_mass
    seconds, true = _integrate(link, fluid, current, total, SECONDS, reach)
    until, mujoco = _integrate(link, fluid, current, link.rigid_mass, seconds, FAR * reach)
    if until < seconds:
        _, true = _integrate(link, fluid, current, total, until, reach)
    return Paths(until, true, mujoco)


def _integrate(
    link: Link, fluid: Fluid, current: FloatArray, total: FloatArray, seconds: float, reach: float
) -> tuple[float, FloatArray]:
    """Return when a body with the mass matrix ``total`` has gone ``reach``, and its displacement relative to the water."""
    from scipy.integrate import RK45

    inverse, added, mass = np.linalg.inv(total), link.added_mass, link.rigid_mass
    lift = fluid.density * link.volume * fluid.gravity
    weight = link.mass * fluid.gravity - lift

    def rates(_: float, state: FloatArray) -> FloatArray:
        R, nu = state[3:12].reshape(3, 3), state[12:]
        flow = added @ nu
        momentum = mass @ nu + flow
        turn = inertia.cross_matrix(nu[3:])
        force = -turn @ momentum[:3] - weight * R[2]
        torque = (
            -turn @ momentum[3:]
            - inertia.cross_matrix(nu[:3]) @ flow[:3]
            + lift * (inertia.cross_matrix(link.buoyancy) @ R[2])
        )
        damping = link.linear_damping @ nu + link.quadratic_damping @ (np.abs(nu) * nu)
        return np.concatenate(
            (R @ nu[:3], (R @ turn).ravel(), inverse @ (np.concatenate((force, torque)) - damping))
        )

    moving = np.concatenate((link.rotation.T @ (link.velocity - current), np.zeros(3)))
    start = np.concatenate((np.zeros(3), link.rotation.ravel(), moving))
    solver = RK45(rates, 0.0, start, seconds, rtol=_TOLERANCE, atol=_TOLERANCE)
    for _ in range(STEPS):
        solver.step()
        if np.linalg.norm(solver.y[:3]) >= reach:
            return _find_end(solver.dense_output(), solver.t_old, solver.t, reach)
        if solver.status != "running":
            break
    return float(solver.t), np.asarray(solver.y[:3], dtype=np.float64)


def _find_end(
    path: Callable[[float], FloatArray], start: float, end: float, reach: float
) -> tuple[float, FloatArray]:
    """When a path, which holds the displacement in its first three numbers, leaves a sphere, and where."""
    from scipy.optimize import brentq

    left = float(brentq(lambda t: float(np.linalg.norm(path(t)[:3])) - reach, start, end))
    return left, np.asarray(path(left)[:3], dtype=np.float64)
