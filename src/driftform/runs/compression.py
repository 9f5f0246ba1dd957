"""A trajectory as a run stores it: thinned, in single precision, compressed, and decoded on first access."""

import struct
import zlib
from dataclasses import replace
from typing import Any

import numpy as np

from driftform.types import End, Evaluation, Trajectory

SAMPLE_GAP = 0.01
"""Least time between the samples of a compressed trajectory, s."""

MAX_FLIGHT_BYTES = 1 << 28
"""Largest size of a flight in single precision, bytes: 13 hours, whatever it contains."""

_NUMBERS = 14
"""Numbers in a sample: the time first, then position, quaternion and velocity."""

_HEADER = struct.Struct("<HII")
"""Bits of the numbers that are stored, lowest first; number of samples; checksum of the bytes."""

_SAMPLES = ("t", "position", "quaternion", "velocity")


class CompressedTrajectory(Trajectory):
    """A trajectory that is held and sent as bytes, and decoded when its samples are first read.

    Attributes:
        blob: the samples as :func:`encode` returns them.
        duration: of the flight, s.
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
    """Thin a trajectory to :data:`SAMPLE_GAP` and store it as float32.

    Of 14 numbers in a sample, those are stored that are not zero all along: eight of a flight in the vertical plane. Bytes
    of equal significance lie side by side, and only the highest of each number are compressed, by their runs of equal
    bytes. The others hardly repeat: to compress them as well takes five times as long, for 5 % less.
    """
    from driftform.motion.path.thinning import thin_samples

    samples = thin_samples(trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity, SAMPLE_GAP)
    if samples.nbytes > MAX_FLIGHT_BYTES:
        raise ValueError(f"a flight of {trajectory.t[-1]:g} s has more samples than a run can hold")
    is_stored = np.array(samples.view(np.uint32).any(axis=1))
    # The times are always stored, and say how many samples there are.
    is_stored[0] = True
    planes = np.ascontiguousarray(samples[is_stored].astype("<f4", copy=False).view(np.uint8).reshape(-1, 4).T)
    bits = int(np.packbits(is_stored, bitorder="little").view("<u2")[0])
    header = _HEADER.pack(bits, samples.shape[1], zlib.adler32(planes.data))
    packer = zlib.compressobj(level=1, strategy=zlib.Z_RLE)
    return b"".join((header, planes[:3].tobytes(), packer.compress(planes[3]), packer.flush()))


def decode(blob: bytes, end: End, **fields: float | None) -> Trajectory:
    """Read what :func:`encode` wrote; ``fields`` are the other fields of the trajectory, see :func:`diagnostics`.

    Raises:
        ValueError: if it is not a flight: of another length, or with other bytes, than it says, with times that
            decrease, or, if the flight did not fail, with numbers that are not finite.
        zlib.error: if its highest bytes are not compressed data.
    """
    if len(blob) < _HEADER.size:
        raise ValueError("a flight is cut short")
    bits, count, checksum = _HEADER.unpack_from(blob)
    stored = [number for number in range(_NUMBERS) if bits >> number & 1]
    size, start = len(stored) * count, _HEADER.size + 3 * len(stored) * count
    # Of what is compressed no more is unpacked than the blob has bytes.
    unpacker = zlib.decompressobj()
    high = unpacker.decompress(blob[start:], size + 1) if 0 < size < len(blob) else b""
    has_times = 0 in stored and bits >> _NUMBERS == 0
    if not has_times or len(high) != size or not unpacker.eof or unpacker.unused_data:
        raise ValueError("a flight has another length than it says")
    unpacked = blob[_HEADER.size : start] + high
    if zlib.adler32(unpacked) != checksum:
        raise ValueError("a flight has other bytes than it says")
    planes = np.frombuffer(unpacked, dtype=np.uint8).reshape(4, -1)
    samples = np.zeros((_NUMBERS, count), np.float32)
    # Three times as fast as a transposed copy.
    samples[stored] = np.stack(list(planes), axis=1).view("<f4").reshape(-1, count)
    if not end.failed and not np.isfinite(samples).all():
        raise ValueError("a flight has numbers that are not finite")
    if not (samples[0, 1:] >= samples[0, :-1]).all():
        raise ValueError("the times of a flight decrease")
    return Trajectory(samples[0], samples[1:4].T, samples[4:8].T, samples[8:].T, end, **fields)
