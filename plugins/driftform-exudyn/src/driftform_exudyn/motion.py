"""Position and attitude of the agent at any time of its flight."""

from dataclasses import dataclass

from driftform.motion.interpolation import interpolate_attitudes, interpolate_positions
from driftform.types import FloatArray, Trajectory
from driftform.util.rotations import matrix_from_quaternion


@dataclass(frozen=True, eq=False)
class Pose:
    """The ``position`` of the core's centre (world, m, (3,)) and the ``rotation``, body to world, (3, 3)."""

    position: FloatArray
    rotation: FloatArray


def interpolate_poses(trajectory: Trajectory, t: FloatArray) -> list[Pose]:
    """Return the poses at times ``t`` (s, (n,)), by the cubic interpolation that fitness uses for the path."""
    rotations = matrix_from_quaternion(interpolate_attitudes(trajectory, t))
    return [Pose(*pose) for pose in zip(interpolate_positions(trajectory, t), rotations, strict=True)]
