"""A trajectory as a run stores it: thinned, in single precision, compressed, and decoded on first access."""

import zlib
from dataclasses import replace
from typing import Any

import numpy as np

from driftform.types import End, Evaluation, Trajectory

SAMPLE_GAP = 0.01
"""Least time between the samples of a compressed trajectory, s."""

LARGEST_FLIGHT = 1 << 28
"""Largest size of a decoded flight, bytes: 13 hours, whatever a file contains."""

_SAMPLE_BYTES = 14 * 4

_SAMPLES = ("t", "position", "quaternion", "velocity")


class CompressedTrajectory(Trajectory):
    """A trajectory that is held and sent as bytes, and decoded when its samples are first read.

    Attributes
    ----------
    blob
        the samples as :func:`encode` returns them.
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
    """Return the trajectory as it reads back from a run; a compressed one is returned as it is."""
    if isinstance(trajectory, CompressedTrajectory) and "blob" in vars(trajectory):
        return trajectory
    compressed = CompressedTrajectory.__new__(CompressedTrajectory)
    compressed.__dict__.update(
        diagnostics(trajectory),
        end=trajectory.end,
        blob=encode(trajectory),
        duration=float(np.float32(trajectory.t[-1])),
    )
    return compressed


def compress_evaluation(evaluation: Evaluation) -> Evaluation:
    """Return the evaluation as it reads back from a run, so that a strategy receives the same live and resumed."""
    trajectory = evaluation.trajectory
    return evaluation if trajectory is None else replace(evaluation, trajectory=compress(trajectory))


def diagnostics(trajectory: Trajectory) -> dict[str, float | None]:
    """Return the fields of a trajectory other than its samples and its end: those that say how far to trust it."""
    return {"contact": trajectory.contact, "energy_drift": trajectory.energy_drift, "error": trajectory.error}


def encode(trajectory: Trajectory) -> bytes:
    """Thin a trajectory to :data:`SAMPLE_GAP` and compress it as float32.

    Bytes of equal significance are stored side by side: zlib then takes a third of the time and returns three quarters
    of the size. It searches for runs of equal bytes only, which takes another third less and returns 3 % more.
    """
    from driftform.trajectory.resampling import byte_planes

    planes = byte_planes(
        trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity, SAMPLE_GAP
    )
    if planes.nbytes > LARGEST_FLIGHT:
        raise ValueError(f"a flight of {trajectory.t[-1]:g} s has more samples than a run can hold")
    packer = zlib.compressobj(level=1, strategy=zlib.Z_RLE)
    return packer.compress(planes.data) + packer.flush()


def decode(blob: bytes, end: End, **fields: float | None) -> Trajectory:
    """Read what :func:`encode` wrote; ``fields`` are the other fields of the trajectory, see :func:`diagnostics`.

    Raises
    ------
    ValueError
        if it is not a flight: of another length, larger than :data:`LARGEST_FLIGHT`, with times that decrease, or, if
        the flight did not fail, with numbers that are not finite.
    zlib.error
        if it is not compressed data.
    """
    unpacker = zlib.decompressobj()
    unpacked = unpacker.decompress(blob, LARGEST_FLIGHT)
    if not unpacker.eof:
        raise ValueError("a flight is cut short, or too large")
    if not unpacked or len(unpacked) % _SAMPLE_BYTES:
        raise ValueError(f"a flight has {len(unpacked)} bytes, expected a multiple of {_SAMPLE_BYTES}")
    planes = np.frombuffer(unpacked, dtype=np.uint8).reshape(4, -1)
    # Three times as fast as a transposed copy.
    samples = np.stack(list(planes), axis=1).view("<f4").reshape(14, -1)
    if not end.failed and not np.isfinite(samples).all():
        raise ValueError("a flight has numbers that are not finite")
    if not (np.diff(samples[0]) >= 0).all():
        raise ValueError("the times of a flight decrease")
    return Trajectory(samples[0], samples[1:4].T, samples[4:8].T, samples[8:14].T, end, **fields)
