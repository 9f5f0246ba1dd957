"""A flight as a run keeps it: thinned, in single precision, compressed, and unpacked where it is looked at."""

import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from driftform.types import End, Evaluation, Trajectory

SAMPLE_GAP = 0.01
"""Samples of a packed flight are at least this far apart, s."""

_SAMPLES = ("t", "position", "quaternion", "velocity")


class CompressedTrajectory(Trajectory):
    """A trajectory that travels and waits as bytes; its samples are there once they are asked for.

    Attributes
    ----------
    blob
        what :func:`encode` makes of the flight.
    duration
        of the flight, s.
    """

    blob: bytes
    duration: float

    def __getattr__(self, name: str) -> Any:
        if name not in _SAMPLES:
            raise AttributeError(name)
        self.__dict__.update(vars(decode(self.blob, self.end, **diagnostics(self))))
        return self.__dict__[name]


def compress(trajectory: Trajectory) -> CompressedTrajectory:
    """The flight as it reads back from a run; once packed it is not packed again."""
    if isinstance(trajectory, CompressedTrajectory) and "blob" in vars(trajectory):
        return trajectory
    made = CompressedTrajectory.__new__(CompressedTrajectory)
    made.__dict__.update(
        diagnostics(trajectory),
        end=trajectory.end,
        blob=encode(trajectory),
        duration=float(np.float32(trajectory.t[-1])),
    )
    return made


def compress_evaluation(evaluation: Evaluation) -> Evaluation:
    """The evaluation as it reads back from a run: what a strategy is told, live or resumed."""
    flight = evaluation.trajectory
    return evaluation if flight is None else replace(evaluation, trajectory=compress(flight))


def diagnostics(trajectory: Trajectory) -> dict[str, float | None]:
    """What a trajectory tells of itself beside its samples and its end."""
    return {"contact": trajectory.contact, "energy_drift": trajectory.energy_drift, "error": trajectory.error}


def encode(trajectory: Trajectory) -> bytes:
    """Thin a trajectory to :data:`SAMPLE_GAP` and compress it as float32.

    Bytes of equal weight are put side by side, which zlib packs in a third of the time and to three quarters of the
    size.
    """
    return zlib.compress(_columns(trajectory).view(np.uint8).reshape(-1, 4).T.tobytes(), 1)


def decode(blob: bytes, end: End, **trust: float | None) -> Trajectory:
    """Read what :func:`encode` wrote; ``trust`` is what else the trajectory tells of itself, such as ``error``."""
    planes = np.frombuffer(zlib.decompress(blob), dtype=np.uint8).reshape(4, -1)
    wide = np.ascontiguousarray(planes.T).view("<f4").reshape(14, -1).astype(np.float64)
    return Trajectory(wide[0], wide[1:4].T, wide[4:8].T, wide[8:14].T, end, **trust)


def _columns(trajectory: Trajectory) -> npt.NDArray[np.float32]:
    """What is kept of a trajectory: t, position, quaternion and velocity of some samples, (14, k)."""
    from driftform.trajectory.path import select_spaced

    # Thinned by the rounded times: what is kept once is kept whole when it comes here again.
    kept = select_spaced(trajectory.t.astype("<f4").astype(np.float64), SAMPLE_GAP)
    flown = (trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity)
    return np.column_stack([samples.take(kept, axis=0) for samples in flown]).T.astype("<f4", order="C")
