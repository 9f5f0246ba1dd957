"""How far an agent's path in MuJoCo is from its own: MuJoCo has the Coriolis forces of added mass, and not its inertia."""

from dataclasses import dataclass

import numpy as np

from driftform.interfaces import ExportJob
from driftform.types import FloatArray
from driftform_robotics.models import gap
from driftform_robotics.models.link import Link

SECONDS = 3.0
"""Longest duration of the paths that are compared, s."""

REACH = 1.0
"""Distance from the release at which the comparison ends in open water, m; in a pipe its least radius."""

FAR = 20.0
"""MuJoCo's path ends there, in such distances."""

FINE = 4e-6
"""The shorter of the steps from which MuJoCo's path is extrapolated, relative to its duration."""

LEVEL = 0.1
"""An agent that rises or sinks by less than this share of the larger change of height keeps its height."""


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
        """Compare the path in MuJoCo with the true one, in a sentence or two."""
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


def read_mujoco(job: ExportJob, link: Link) -> gap.Reader:
    """Return MuJoCo: without the inertia of added mass, and without linear damping."""
    none, density = np.zeros((6, 6)), job.scenario.fluid.density
    return gap.Reader("MuJoCo", none, link.added_mass, none, link.quadratic_damping, density)


def compare_paths(job: ExportJob, link: Link, reach: float = REACH) -> Paths:
    """Return the paths of an agent in open water with a uniform current, until it has gone ``reach`` (m)."""
    reader = read_mujoco(job, link)
    # An agent of foam tumbles thousands of times a second there.
    for seconds in (SECONDS, SECONDS / 10, SECONDS / 100, SECONDS / 1000):
        true = gap.fly_own(job, link, seconds)
        step = seconds * FINE
        fine, coarse = (gap.fly_reader(reader, job, link, seconds, s) for s in (step, 2 * step))
        mujoco = 2 * fine - coarse
        times = np.linspace(0.0, seconds, len(true))
        until = min(_find_end(times, true, reach), _find_end(times, mujoco, FAR * reach))
        if until:
            break
    at_end = [[float(np.interp(until, times, axis)) for axis in path.T] for path in (true, mujoco)]
    return Paths(until, *map(np.array, at_end))


def _find_end(times: FloatArray, path: FloatArray, reach: float) -> float:
    """Return when a path (n, 3) leaves a sphere, or stops to be finite, or ends, s."""
    gone = np.linalg.norm(path, axis=1)
    outside = np.flatnonzero(~(gone < reach))
    if not len(outside):
        return float(times[-1])
    i = int(outside[0])
    if not np.isfinite(gone[i]):
        return float(times[i - 1])
    return float(np.interp(reach, gone[i - 1 : i + 1], times[i - 1 : i + 1]))
