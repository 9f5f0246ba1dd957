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
from filelock import BaseFileLock, FileLock, SoftFileLock, Timeout

from driftform import __version__
from driftform.errors import InputError
from driftform.plugins.registry import registry
from driftform.runs.versions import find_versions
from driftform.study import Study
from driftform.util.files import NO_LOCKS, is_locked, name_owner, write_text

DATABASE = "run.db"
"""Name of the file with all that a run has found."""

INPUTS = ("study.toml", "resolved.toml", "environment.json")
"""Names of the files with what a run was started with: the study as it was given and as it is carried out, and versions."""

_LOCK = ".lock"
LOCK_TIMEOUT_S = 0.2
"""How long a lock is asked for, s: :func:`is_worked_on` holds it for a moment."""


def resume_command(directory: Path) -> str:
    """Return the command that continues a run."""
    return f"driftform resume {quote(str(directory))}"


def _take_lock(path: Path) -> BaseFileLock:
    """Lock a file; where its file system has no locks, by a second file that names host and process.

    The file of a process of this host that has ended is taken over.
    """
    lock: BaseFileLock = FileLock(path)
    try:
        lock.acquire(timeout=LOCK_TIMEOUT_S, poll_interval=LOCK_TIMEOUT_S / 10)
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
        lock = SoftFileLock(name_owner(path))
        lock.acquire(timeout=LOCK_TIMEOUT_S, poll_interval=LOCK_TIMEOUT_S / 10)
    return lock


@contextmanager
def lock_run(directory: Path) -> Iterator[None]:
    """Hold the run for one writer; the lock goes with the process, however it ends.

    Raises InputError where another process holds it.
    """
    try:
        lock = _take_lock(directory / _LOCK)
    except Timeout:
        raise InputError(f"{directory}: another driftform process is working on this run; wait for it to end") from None
    except OSError as error:
        raise InputError(f"{directory}: cannot be written to: {error.strerror}") from None
    try:
        yield
    finally:
        lock.release()


def is_worked_on(directory: Path) -> bool:
    """Return whether a process holds the run; nothing is written, and another process may begin."""
    return is_locked(directory / _LOCK)


def check_new(directory: Path) -> None:
    """Refuse a directory that holds a run, or anything else that a run could spoil.

    A directory of a run that never began, such as one killed in its first moment, is new.

    Raises InputError with the next step.
    """
    if (directory / DATABASE).exists():
        raise InputError(
            f"{directory} already holds a run: choose another --out, or resume it with: {resume_command(directory)}"
        )
    if directory.exists() and not directory.is_dir():
        raise InputError(f"{directory} is a file; choose another --out")
    if directory.is_dir() and any(directory.iterdir()) and not _is_stopped(directory):
        raise InputError(f"{directory} is not empty; choose another --out")


def _is_part(name: str) -> bool:
    """Return whether a file is what a process that was killed left of one that a run begins with."""
    return name.startswith(tuple(f".{whole}." for whole in (DATABASE, *INPUTS))) and ".part" in name


def _is_stopped(directory: Path) -> bool:
    """Return whether a directory is that of a run that was stopped, or has not come so far, before it began."""
    names = {entry.name for entry in directory.iterdir()}
    return _LOCK in names and all(name in (_LOCK, name_owner(Path(_LOCK)).name) or _is_part(name) for name in names)


def check_run(directory: Path) -> Path:
    """Return the database of a run directory. Raises InputError if the directory is not a run."""
    if not directory.is_dir():
        where = "is a file, expected a run directory" if directory.exists() else "no such run directory"
        raise InputError(f"{directory}: {where}")
    if (directory / DATABASE).is_file():
        return directory / DATABASE
    if not _is_stopped(directory):
        raise InputError(f"{directory} holds no {DATABASE}: it is not a run directory")
    if is_worked_on(directory):
        raise InputError(f"{directory}: its run is about to begin; try again in a second")
    raise InputError(
        f"{directory}: its run was stopped before it began; start it again with the same 'driftform evolve' and "
        f"--out {quote(str(directory))}"
    )


def write_inputs(directory: Path, study: Study, document: Mapping[str, Any]) -> None:
    """Write what the run was started with, where it is missing: the study as resolved and as given, versions, plugins and seed.

    Args:
        document: of the study as its database has it.
    """
    for entry in list(directory.iterdir()):
        if _is_part(entry.name):
            entry.unlink(missing_ok=True)
    given, resolved, environment = (directory / name for name in INPUTS)
    text = tomli_w.dumps(dict(document))
    if not resolved.is_file() or resolved.read_text(encoding="utf-8") != text:
        write_text(resolved, text)
    if not given.is_file():
        write_text(given, study.given or text)
    if environment.is_file():
        return
    plugins = [
        {"seam": row.seam, "name": row.name, "distribution": row.distribution, "version": row.version}
        for row in registry().contributions()
        if row.available
    ]
    facts = {
        "driftform": __version__,
        "python": sys.version.split()[0],
        "platform": platform.platform(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "seed": study.seed,
        "plugins": plugins,
        "packages": {name: metadata.version(name) for name in ("numpy", "numba", "pydantic", "pluggy")},
        "sources": {
            name: digest for name, digest in find_versions(study.document).items() if name.startswith("sources")
        },
    }
    write_text(environment, json.dumps(facts, indent=1) + "\n")
