"""Files appear whole or not at all, and under names that lead nowhere else."""

import os
import secrets
import shutil
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from driftform.errors import InputError

_MAX_STEM_LENGTH = 60


def is_file(path: Path) -> bool:
    """Tell whether there is such a file; what cannot be a file's name, too long or with a NUL, is none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_directory(path: Path) -> bool:
    """Tell whether there is such a directory; what cannot be its name is none."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def make_directory(path: Path, option: str = "--out") -> Path:
    """Make the directory that an option names, and those above it, where they do not exist; return it.

    Raises
    ------
    InputError
        where that cannot be.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if path.is_file() else error.strerror
        raise InputError(f"{path}: cannot be made a directory: {reason}; choose another {option}") from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise InputError(f"{path}: cannot be written to; choose another {option}")
    return path


def safe_stem(name: str) -> str:
    """A name that came with a file, fit for the name of a file: it cannot lead out of a directory.

    >>> safe_stem("../../evil"), safe_stem("TP1")
    ('evil', 'TP1')
    """
    kept = "".join(c if c.isalnum() or c in "-_ ." else "_" for c in name)[:_MAX_STEM_LENGTH]
    return kept.strip("._ ") or "agent"


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` make a file beside ``path``, then put it in place in one step.

    Whatever happens, the file is never there in part. Folders above it are made.

    Raises
    ------
    OSError
        where the file cannot be written; then there is none, or the former one still.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    # In the same folder, because a file can be renamed in one step only within a file system.
    part = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        write(part)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8."""
    write_whole(path, lambda part: part.write_text(text, encoding="utf-8"))


@contextmanager
def write_together(folder: Path, names: Collection[str]) -> Iterator[Path]:
    """Yield a new directory for files that belong together, then put them all into ``folder``.

    Those of ``names`` that were there before go, whether they were made again or not. Whatever happens in between,
    nothing in ``folder`` has changed.

    Raises
    ------
    InputError
        where ``folder`` cannot be a directory to write to.
    """
    folder = folder.resolve()
    make_directory(folder if folder.exists() else folder.parent)
    part = folder.with_name(f".{folder.name}.{secrets.token_hex(4)}.part")
    part.mkdir()
    try:
        yield part
        make_directory(folder)
        for name in names:
            if not (part / name).exists():
                (folder / name).unlink(missing_ok=True)
        for file in part.iterdir():
            file.replace(folder / file.name)
    finally:
        shutil.rmtree(part, ignore_errors=True)


@contextmanager
def write_folder(folder: Path) -> Iterator[Path]:
    """Yield a new directory, then put it in the place of ``folder`` as a whole, whatever that held before.

    Whatever happens in between, ``folder`` is as it was. Folders above it are made.

    Raises
    ------
    InputError
        where a file stands in its place, or nothing can be written there.
    """
    folder = folder.resolve()
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: cannot be made a directory: it is a file; choose another --out")
    make_directory(folder.parent)
    token = secrets.token_hex(4)
    part, former = (folder.with_name(f".{folder.name}.{token}.{end}") for end in ("part", "former"))
    part.mkdir()
    try:
        yield part
        if folder.exists():
            folder.rename(former)
        part.rename(folder)
    finally:
        # Between the two renames there is no folder: then the former one comes back.
        if former.exists() and not folder.exists():
            former.rename(folder)
        for leftover in (part, former):
            shutil.rmtree(leftover, ignore_errors=True)
