"""Copies of arrays in kernels."""

from driftform.types import FloatArray
from driftform.util.compiled import compiled


@compiled
def copy(source: FloatArray, target: FloatArray) -> None:
    """Copy ``source`` into ``target``, in a loop: an assignment of slices takes ten times as long to compile."""
    for j in range(source.shape[0]):
        target[j] = source[j]


@compiled
def copy_rows(source: FloatArray, target: FloatArray) -> None:
    """Copy all rows of ``source`` (k, n) into the first of ``target``."""
    for k in range(source.shape[0]):
        copy(source[k], target[k])
