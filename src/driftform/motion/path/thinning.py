"""The samples of a trajectory: the rates that may be asked for, and thinning."""

import numpy as np
import numpy.typing as npt

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform.util.compiled import allocating

MAX_RATE_HZ = 10_000.0
"""Highest rate of samples, 1/s: a flight of 20 s then has two hundred thousand of them."""


def check_rate(rate_hz: float) -> None:
    """Refuse a rate of samples (1/s) that is out of range; 0 stands for the samples of the simulator.

    Raises InputError with the range.
    """
    if not 0 <= rate_hz <= MAX_RATE_HZ:
        raise InputError(f"--rate-hz {rate_hz:g}: should be from 0 to {MAX_RATE_HZ:g}")


@allocating
def select_spaced(t: FloatArray, gap: float) -> npt.NDArray[np.int64]:
    """Return indices of times (k,) that are at least ``gap`` apart, always with the first and the last time.

    The times are ascending; only where they last less than ``gap`` in all are the first and the last closer.
    """
    kept, count = np.zeros(t.shape[0], dtype=np.int64), 1
    for index in range(1, t.shape[0]):
        if t[index] - t[kept[count - 1]] >= gap:
            kept[count] = index
            count += 1
    last = t.shape[0] - 1
    if kept[count - 1] != last:
        # The last time replaces the one before, which may be too near to it.
        count += count == 1
        kept[count - 1] = last
    return kept[:count]


def thin_samples(
    t: FloatArray, position: FloatArray, quaternion: FloatArray, velocity: FloatArray, gap: float
) -> npt.NDArray[np.float32]:
    """Return samples of a trajectory that are at least ``gap`` (s) apart, in single precision, (14, k).

    The first and the last are always among them; only where a flight lasts less than ``gap`` are they closer. The times
    are compared as they are rounded, so that a trajectory that was thinned before keeps all its samples.
    """
    kept = select_spaced(t.astype(np.float32).astype(np.float64), gap)
    samples = [t[None, kept], position[kept].T, quaternion[kept].T, velocity[kept].T]
    return np.concatenate(samples, dtype=np.float32, casting="same_kind")
