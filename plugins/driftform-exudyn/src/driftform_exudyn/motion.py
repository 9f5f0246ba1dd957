"""Where the agent is, and how it lies, at any time of its flight."""

from dataclasses import dataclass

from driftform.dynamics.rotations import matrix_from_quaternion
from driftform.trajectory.interpolation import attitudes, positions
from driftform.types import FloatArray, Trajectory


@dataclass(frozen=True, eq=False)
class Pose:
    """The ``position`` of the core's centre (world, m, (3,)) and the ``rotation``, body to world, (3, 3)."""

    position: FloatArray
    rotation: FloatArray


def poses(flight: Trajectory, t: FloatArray) -> list[Pose]:
    """Return the poses at times ``t`` (s, (n,)): on the cubic path that fitness measures, and on the cubic turn."""
    rotations = matrix_from_quaternion(attitudes(flight, t))
    return [Pose(*pose) for pose in zip(positions(flight, t), rotations, strict=True)]
