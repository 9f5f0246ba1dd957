"""Results on disk under the hash of what they were made of: made once, shared by all runs, never changed."""

import hashlib
import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from driftform.util import files

T = TypeVar("T")


def find_cache(directory: Path | None = None) -> Path:
    """Return the directory for results: the given one, or ``networks`` in the user's cache of driftform."""
    return directory or files.cache_folder() / "networks"


def hash_content(content: Any) -> str:
    """Return the SHA-256 of plain values and arrays, in hexadecimal digits."""
    text = json.dumps(content, sort_keys=True, default=np.ndarray.tolist)
    return hashlib.sha256(text.encode()).hexdigest()


def keep_result(path: Path, build: Callable[..., T], make: Callable[[], Any]) -> T:
    """Return what is built from numbers and arrays, a dataclass or a mapping, from their file, or make them and write the file.

    The process that makes it writes the file, so that what is finished is not lost with other work; without room for it the next
    run makes it again. A damaged file is made again, with a line.
    """

    def read(path: Path) -> T:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            return build(**{name: file[name] if file[name].ndim else file[name].item() for name in file.files})

    if (kept := files.read_cached(path, read)) is not None:
        return kept
    made = make()
    values = made if isinstance(made, dict) else vars(made)

    def write(part: Path) -> None:
        with part.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **{name: np.asarray(value) for name, value in values.items()})

    with suppress(OSError):
        files.write_whole(path, write)
    return build(**values)
