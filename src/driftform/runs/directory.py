"""A run on disk: who may write to it, and the files that it ends with.

``study.toml`` (as given), ``resolved.toml`` (every default filled in), ``environment.json`` (versions, plugins,
seed), ``run.db``, ``best/<target>/`` and ``figures/``.
"""

import json
import platform
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from shlex import quote
from typing import Any

import tomli_w
from filelock import FileLock, Timeout

from driftform import __version__
from driftform.errors import InputError
from driftform.registry import registry
from driftform.study import Study
from driftform.util.files import write_text

DATABASE = "run.db"
"""Name of the file with all that a run has found."""

INPUTS = ("study.toml", "resolved.toml", "environment.json")
"""Names of the files with what a run was started with."""

_LOCK = ".lock"
LOCK_TIMEOUT_S = 0.2
"""How long a lock is asked for, s: :func:`is_worked_on` holds it for a moment."""


def resume_command(directory: Path) -> str:
    """Return the command that continues a run."""
    return f"driftform resume {quote(str(directory))}"


@contextmanager
def lock_run(directory: Path) -> Iterator[None]:
    """Hold the run for one writer; the lock goes with the process, however it ends.

    Raises
    ------
    InputError
        where another process holds it.
    """
    lock = FileLock(directory / _LOCK)
    try:
        lock.acquire(timeout=LOCK_TIMEOUT_S, poll_interval=LOCK_TIMEOUT_S / 10)
    except Timeout:
        raise InputError(
            f"{directory}: another driftform process is working on this run; wait for it to end"
        ) from None
    except OSError as error:
        raise InputError(f"{directory}: cannot be written to: {error.strerror}") from None
    try:
        yield
    finally:
        lock.release()


def is_worked_on(directory: Path) -> bool:
    """Return whether a process holds the run; nothing is written, and another process may begin."""
    path = directory / _LOCK
    if not path.exists():
        return False
    if sys.platform == "win32":
        lock = FileLock(path)
        try:
            lock.acquire(timeout=0)
        except Timeout:
            return True
        lock.release()
        return False
    import fcntl

    # A shared lock, which many may hold at once, and which a file that may only be read allows.
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError:
            return True
    return False


def check_new(directory: Path) -> None:
    """Refuse a directory that holds a run, or anything else that a run could spoil.

    A directory with no more than the inputs of a run that never began, such as one killed in its first moment, is new.

    Raises
    ------
    InputError
        with the next step.
    """
    if (directory / DATABASE).exists():
        raise InputError(
            f"{directory} already holds a run: choose another --out, or resume it with: {resume_command(directory)}"
        )
    if directory.exists() and not directory.is_dir():
        raise InputError(f"{directory} is a file; choose another --out")
    names = {entry.name for entry in directory.iterdir()} if directory.is_dir() else set()
    never_began = _LOCK in names and names <= {_LOCK, *INPUTS}
    if names - {_LOCK} and not never_began:
        raise InputError(f"{directory} is not empty; choose another --out")


def check_run(directory: Path) -> Path:
    """Return the database of a run directory.

    Raises
    ------
    InputError
        if the directory is not a run.
    """
    if not directory.is_dir():
        where = "is a file, expected a run directory" if directory.exists() else "no such run directory"
        raise InputError(f"{directory}: {where}")
    if not (directory / DATABASE).is_file():
        raise InputError(f"{directory} holds no {DATABASE}: it is not a run directory")
    return directory / DATABASE


def write_inputs(directory: Path, study: Study) -> None:
    """Write what the run was started with: the study as given and as resolved, versions, plugins and seed."""
    write_text(directory / "study.toml", study.given or tomli_w.dumps(dict(study.document)))
    write_resolved(directory, study.document)
    plugins = [
        {"seam": row.seam, "name": row.name, "distribution": row.distribution, "version": row.version}
        for row in registry().contributions()
        if row.available
    ]
    environment = {
        "driftform": __version__,
        "python": sys.version.split()[0],
        "platform": platform.platform(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "seed": study.seed,
        "plugins": plugins,
        "packages": {name: _version(name) for name in ("numpy", "numba", "pydantic", "pluggy")},
    }
    write_text(directory / "environment.json", json.dumps(environment, indent=1) + "\n")


def write_resolved(directory: Path, document: Mapping[str, Any]) -> None:
    """Write the study's document for people, where the file does not say the same already."""
    path, text = directory / "resolved.toml", tomli_w.dumps(dict(document))
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        write_text(path, text)


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "?"
