"""Results on disk under the hash of what they were made of: made once, shared by all runs, never changed."""

import hashlib
import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from driftform.util import files

Arrays = dict[str, npt.NDArray[Any]]

T = TypeVar("T")


def find_cache(directory: Path | None = None) -> Path:
    """Return the directory for results: the given one, or ``networks`` in the user's cache of driftform."""
    return directory or files.cache_folder() / "networks"


def hash_content(content: Any) -> str:
    """Return the SHA-256 of plain values and arrays, in hexadecimal digits."""
    text = json.dumps(content, sort_keys=True, default=np.ndarray.tolist)
    return hashlib.sha256(text.encode()).hexdigest()


def keep_result(path: Path, kind: Callable[..., T], make: Callable[[], T]) -> T:
    """Return a result, a dataclass of numbers and arrays, from its file, or make it and write the file.

    The process that makes it writes the file, so that what is finished is not lost with other work.
    """

    def read(path: Path) -> T:
        return kind(**{name: array if array.ndim else array.item() for name, array in _load(path).items()})

    if (kept := files.read_cached(path, read)) is not None:
        return kept
    made = make()
    save_arrays(path, {name: np.asarray(value) for name, value in vars(made).items()})
    return made


def load_arrays(path: Path) -> Arrays | None:
    """Return the arrays of a file; ``None`` if there is no such file, and, with a line, if it is damaged."""
    return files.read_cached(path, _load)


def _load(path: Path) -> Arrays:
    with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def save_arrays(path: Path, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
    """Write a file of arrays, completely or not at all; without room for it the next run makes them again."""

    def write(part: Path) -> None:
        with part.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)

    with suppress(OSError):
        files.write_whole(path, write)
