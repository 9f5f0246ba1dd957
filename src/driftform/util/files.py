"""Read text in whatever encoding it is; write files and folders completely or not at all, under safe names."""

import codecs
import errno
import logging
import os
import re
import shutil
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import TypeVar

from driftform.errors import InputError, describe_error

T = TypeVar("T")

_log = logging.getLogger(__name__)

_MAX_STEM_LENGTH = 60

MAX_BYTES = 64_000_000
"""Largest text that is read as a whole."""

_HIGH_BYTES = re.compile(rb"[\x80-\xff]+")

CACHE_VARIABLE = "DRIFTFORM_CACHE"
"""Environment variable that names the folder of the cache."""


def cache_folder() -> Path:
    """Return the folder of the user's cache: that of the variable DRIFTFORM_CACHE, or the system's."""
    if CACHE_VARIABLE in os.environ:
        return Path(os.environ[CACHE_VARIABLE])
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home())) / "driftform" / "cache"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "driftform"


def read_cached(path: Path, read: Callable[[Path], T]) -> T | None:
    """Return what reads a file of a cache; ``None`` without the file, and, with a line, where it is damaged."""
    try:
        return read(path)
    except FileNotFoundError:
        return None
    except Exception as error:
        print(f"{path} is damaged ({describe_error(error)}) and is made again", file=sys.stderr, flush=True)
        return None


def identify_file(path: Path) -> tuple[int, int] | None:
    """Return what a file is, whatever its name; ``None`` if there is no file."""
    with suppress(OSError):
        status = path.stat()
        return status.st_dev, status.st_ino
    return None


def is_file(path: Path) -> bool:
    """Return whether a path is a file; False for an invalid name, such as one that is too long or contains NUL."""
    with suppress(OSError, ValueError):
        return path.is_file()
    return False


def is_directory(path: Path) -> bool:
    """Return whether a path is a directory; False for an invalid name."""
    with suppress(OSError, ValueError):
        return path.is_dir()
    return False


def read_text(path: Path) -> str:
    """Return a text written by any program, its lines ended by newlines; see :func:`find_encoding`.

    Raises InputError if the file cannot be read, is not a text, or is larger than :data:`MAX_BYTES`.
    """
    try:
        with path.open("rb") as file:
            data = b""
            # In parts: a buffer of the whole limit would be reserved for the shortest text.
            while len(data) <= MAX_BYTES and (part := file.read(1_000_000)):
                data += part
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > MAX_BYTES:
        raise InputError(f"{path}: is larger than {MAX_BYTES // 1_000_000} MB, the limit for text")
    try:
        text = data.decode(find_encoding(data, final=True))
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise InputError(f"{path}: is not a text file; save it as text in UTF-8")
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def find_encoding(data: bytes, final: bool = False) -> str:
    """Return the name of the encoding of a text that begins with ``data``; with ``final``, that is all of it.

    A byte order mark decides first, then the zeros of UTF-16; then UTF-8 if all of it is. GBK is taken if all bytes
    beyond ASCII come in pairs of GB 2312 and most of these are of its level 1, the common characters: accents of European
    languages do not come so. The rest is Windows-1252, or Latin-1 where it has bytes that Windows-1252 has not.
    """
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    head = data[:400]
    for start, name in ((1, "utf-16-le"), (0, "utf-16-be")):
        if len(head) > 3 and head[start::2].count(0) > 0.4 * len(head) / 2 > head[1 - start :: 2].count(0):
            return name
    names = ["utf-8-sig", *(["gbk"] if _looks_chinese(data[:1_000_000]) else []), "cp1252"]
    for name in names:
        try:
            codecs.getincrementaldecoder(name)().decode(data, final)
        except UnicodeDecodeError:
            continue
        return name
    return "latin-1"


def _looks_chinese(data: bytes) -> bool:
    """Return whether bytes beyond ASCII come in pairs of GB 2312, and most are of its level 1."""
    runs = _HIGH_BYTES.findall(data)
    pairs = [run[k : k + 2] for run in runs for k in range(0, len(run) - 1, 2)]
    fits = all(len(run) % 2 == 0 for run in runs) and all(min(pair) >= 0xA1 and pair[0] <= 0xF7 for pair in pairs)
    return fits and sum(0xB0 <= pair[0] <= 0xD7 for pair in pairs) > 0.7 * len(pairs)


NO_LOCKS = frozenset({errno.ENOLCK, errno.EOPNOTSUPP, errno.EIO})
"""Errors of a file system that has no locks, such as NFS without its daemon; for ENOSYS filelock itself has a way out."""


def is_locked(path: Path) -> bool:
    """Return whether a process holds a lock file; nothing is written."""
    if not path.exists():
        return False
    if sys.platform == "win32":
        from filelock import FileLock, Timeout

        try:
            with FileLock(path, timeout=0):
                return False
        except Timeout:
            return True
    import fcntl

    # A shared lock, which many may hold at once, and which a file that may only be read allows.
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError as error:
            return error.errno not in NO_LOCKS or name_owner(path).exists()
    return False


def name_owner(path: Path) -> Path:
    """Return the file that takes the place of a lock where the file system has none."""
    return path.with_name(f"{path.name}.owner")


def make_directory(path: Path, option: str = "--out") -> Path:
    """Create a directory that an option names, with its parents if they do not exist, and return its path.

    Raises InputError if it cannot be created or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if path.is_file() else error.strerror
        raise InputError(f"{path}: cannot create the directory: {reason}; choose another {option}") from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise InputError(f"{path}: cannot write to the directory; choose another {option}")
    return path


def make_numbered_directory(parent: Path, stem: str) -> Path:
    """Create the first free directory ``STEM-N`` in another, and return its path."""
    for number in count(1):
        with suppress(FileExistsError):
            (path := parent / f"{stem}-{number}").mkdir()
            return path
    raise AssertionError("numbers do not end")


def check_new_directory(path: Path) -> None:
    """Refuse a directory that is not empty. Raises InputError also if it is a file."""
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} is a file; choose another --out")
    if path.is_dir() and any(path.iterdir()):
        raise InputError(f"{path} is not an empty directory; choose another --out")


def check_directory(path: Path, option: str = "--out") -> Path:
    """Refuse what :func:`make_directory` could not make, without making it, before work that takes time; return it.

    Raises InputError if the path, or one above it, is a file or cannot be written to.
    """
    existing = next((p for p in (path, *path.absolute().parents) if p.exists()), path)
    if not existing.is_dir():
        raise InputError(f"{path}: cannot be made a directory: {existing} is a file; choose another {option}")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"{path}: cannot be written to; choose another {option}")
    return path


@contextmanager
def keep_directory() -> Iterator[None]:
    """Return to the working directory at the end, because plugins may change it, and paths of runs may be relative."""
    before = None
    with suppress(OSError):
        before = Path.cwd()
    try:
        yield
    finally:
        if before is not None:
            with suppress(OSError):
                os.chdir(before)


def safe_stem(name: str) -> str:
    """Return a name, read from a file, as a safe file name that cannot lead out of its directory.

    >>> safe_stem("../../evil"), safe_stem("TP1")
    ('evil', 'TP1')
    """
    kept = "".join(c if c.isalnum() or c in "-_ ." else "_" for c in name)[:_MAX_STEM_LENGTH]
    return kept.strip("._ ") or "agent"


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Call ``write`` with a temporary path next to ``path``, then rename the file to ``path`` in one step.

    The file never exists in part. Parent folders are created. Raises OSError if the file cannot be written; then a
    former file is unchanged.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    # In the same folder, because renaming is atomic only within a file system.
    part = path.with_name(f".{path.name}.{os.urandom(4).hex()}.part")
    try:
        write(part)
        part.replace(path)
        _log.debug("wrote %s", path)
    except OSError as error:
        # A disk that is full does not say for which file.
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
    finally:
        part.unlink(missing_ok=True)


def remove_parts(folder: Path) -> None:
    """Remove the temporary files of :func:`write_whole` and the like that a killed process left below a folder."""
    for part in list(folder.rglob(".*.part")):
        if part.is_dir():
            shutil.rmtree(part, ignore_errors=True)
        else:
            part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8, completely or not at all; bytes of names that are not UTF-8 become escapes."""
    write_whole(path, lambda part: part.write_text(text, encoding="utf-8", errors="backslashreplace"))


@contextmanager
def write_together(folder: Path, names: Collection[str]) -> Iterator[Path]:
    """Yield a new directory for files that belong together, then move them all into ``folder``.

    Former files in ``folder`` with one of ``names`` are removed, even if they were not written again. After an
    exception inside the context, ``folder`` is unchanged. Raises InputError if ``folder`` cannot be created or written
    to.
    """
    folder = folder.resolve()
    make_directory(folder if folder.exists() else folder.parent)
    part = folder.with_name(f".{folder.name}.{os.urandom(4).hex()}.part")
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
    """Yield a new directory, then replace ``folder`` and all its content by it.

    After an exception inside the context, ``folder`` is unchanged. Parent folders are created. Raises InputError if
    ``folder`` is a file, or cannot be created or written to.
    """
    folder = folder.resolve()
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: cannot create the directory: it is a file; choose another --out")
    make_directory(folder.parent)
    token = os.urandom(4).hex()
    part, former = (folder.with_name(f".{folder.name}.{token}.{end}") for end in ("part", "former"))
    part.mkdir()
    try:
        yield part
        if folder.exists():
            folder.rename(former)
        part.rename(folder)
    finally:
        # After an exception between the two renames, the former folder is restored.
        if former.exists() and not folder.exists():
            former.rename(folder)
        for leftover in (part, former):
            shutil.rmtree(leftover, ignore_errors=True)
