"""Solved tees on disk: those in the package, and the user's cache for other shapes."""

import math
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from pathlib import Path

import numpy as np
from filelock import FileLock

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform.util.files import cache_folder, read_cached, write_whole
from driftform.util.preparation import preparing
from driftform.water.parts.tee_spline import HEAD, LEVEL_SIZE
from driftform.water.parts.tee_wall import Junction

__all__ = ["HEAD", "LEVEL_SIZE", "TeePotentials", "load_tee", "save_tee"]

METHOD = 2
"""Number of the method: a change of the solver or of the files counts it up, and old files are not read."""

PACKAGED = Path(__file__).parent / "tees"
"""The folder of the tees that come with driftform."""

SOLVERS = "driftform.tees"
"""Group of entry points for functions that solve the flow in a tee: a :class:`Junction` to :class:`TeePotentials`."""

JUNCTIONS = tuple(
    Junction(branch, math.radians(angle), round(0.2 * branch, 9))
    for branch, angle in ((0.5, 60), (0.5, 90), (1.0, 60), (1.0, 90), (0.25, 90), (0.7, 90))
)
"""The shapes in the package."""

STEP = 5e-7
"""Step of the stored coefficients: it changes velocities by less than 1e-4 of the mean speed."""


@dataclass(frozen=True, eq=False)
class TeePotentials:
    """The potentials of two flows in a tee, in units of the run's radius and of the mean speed at its inlet.

    Attributes:
        head: number of levels and the rows of the levels, as :mod:`driftform.water.parts.tee_spline` reads them.
        through, branch: coefficients of all levels where all water leaves by the run, and where all leaves by the
            branch.
    """

    head: FloatArray
    through: FloatArray
    branch: FloatArray


@lru_cache(maxsize=8)
def load_tee(junction: Junction) -> TeePotentials:
    """Return the potentials of a tee: from the package, from the user's cache, or solved now and cached.

    Raises InputError if it is neither, and no plugin that solves it is installed.
    """
    name = file_name(junction)
    if (PACKAGED / name).is_file():
        return _read(PACKAGED / name)
    folder = cache_folder()
    with preparing():
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            # Of several processes that need the same tee, one computes it.
            with FileLock(folder / f"{name}.lock"):
                if (found := read_cached(folder / name, _read)) is None:
                    save_tee(junction, folder / name)
                    found = _read(folder / name)
                return found
        return _compute(junction)


def save_tee(junction: Junction, path: Path) -> None:
    """Compute the potentials of a tee and write them to a file."""
    found = _compute(junction)
    write_whole(path, lambda part: _write(part, found))


def _write(path: Path, found: TeePotentials) -> None:
    """Write the coefficients in steps of :data:`STEP`, as differences between neighbours, the bytes of equal weight together."""
    needed = ~np.isnan(found.through)
    # Functions that hardly touch the water have coefficients of up to 1e4.
    flows = [np.rint(flow[needed] / STEP).astype(np.int64) for flow in (found.through, found.branch)]
    changes = np.stack([np.diff(flow, prepend=0) for flow in flows])
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            head=found.head,
            needed=np.packbits(needed),
            changes=np.ascontiguousarray(changes.astype("<i8").view(np.uint8).reshape(2, -1, 8).T),
        )


def _read(path: Path) -> TeePotentials:
    with path.open("rb") as file, np.load(file) as data:
        head, needed, changes = data["head"], data["needed"], data["changes"]
        last = head[HEAD + LEVEL_SIZE * (int(head[0]) - 1) :]
        total = int(last[7] + last[4] * last[5] * last[6]) - len(head)
        flows = np.full((2, total), np.nan)
        steps = np.ascontiguousarray(changes.T).view("<i8")[:, :, 0].cumsum(axis=1)
        flows[:, np.unpackbits(needed, count=total).astype(bool)] = STEP * steps
        return TeePotentials(head, flows[0], flows[1])


def _compute(junction: Junction) -> TeePotentials:
    solvers = list(metadata.entry_points(group=SOLVERS))
    shape = f"a branch of {junction.branch:g} radii at {math.degrees(junction.angle):g} degrees"
    if not solvers:
        raise InputError(f"the flow in a tee with {shape} is not stored; to solve it, run: pip install driftform-tees")
    print(f"computing the ideal flow in a tee ({shape}, some minutes, once)", file=sys.stderr, flush=True)
    solved: TeePotentials = solvers[0].load()(junction)
    return solved


def file_name(junction: Junction) -> str:
    """Return the name of a tee's file.

    >>> file_name(Junction(0.5, math.pi / 2, 0.1))
    'tee-0.5-90-0.1-v2.npz'
    """
    shape = (junction.branch, math.degrees(junction.angle), junction.fillet)
    return f"tee-{'-'.join(f'{x:.9g}' for x in shape)}-v{METHOD}.npz"
