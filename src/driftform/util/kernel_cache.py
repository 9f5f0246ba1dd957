"""Where the machine code of kernels is kept: a folder for each state of their sources, and of the packages that compile them.

numba's cache of a function depends only on the file of that function. After an upgrade, a kernel that calls a function of
another file, or uses its constants, would silently keep their old code. A folder therefore belongs to the sources of all
packages with kernels. It is in the cache of the user: all environments and clones with the same sources share it.
"""

import hashlib
import multiprocessing
import os
import shutil
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from tempfile import gettempdir
from typing import Any

import llvmlite
import numba
import numpy as np
from filelock import FileLock

from driftform.util.files import cache_folder

KERNELS = ("util", "water", "motion")
"""The packages of the core that contain kernels, in them or in packages below them."""

ANNOUNCED_S = 300.0
"""Time for which one announcement of the compilation serves all processes, s."""

WAIT_S = 600.0
"""Longest wait for another process that compiles, s: ten times as long as it takes on an idle machine."""

UNUSED_S = 30 * 86400.0
"""Time without use after which a folder is removed, s."""

_CORE = Path(__file__).parents[1]
_CONFIG: Any = numba.config


def _find_base() -> Path:
    """Return NUMBA_CACHE_DIR, or the cache of the user, or that of Python in this package where the user's cannot be written."""
    if _CONFIG.CACHE_DIR:
        return Path(_CONFIG.CACHE_DIR)
    folder = cache_folder()
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return folder if os.access(folder, os.W_OK) else _CORE / "__pycache__"


BASE = _find_base()
"""The folder of all these folders."""


def hash_sources(sources: Iterable[Path]) -> str:
    """Return a hash of files and of the versions of Python, NumPy, numba and llvmlite, in hexadecimal digits."""
    versions = f"{sys.version} {np.__version__} {numba.__version__} {llvmlite.__version__}"
    digest = hashlib.sha256(versions.encode())
    for source in sources:
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def find_folder(compiler: str) -> Path:
    """Return the folder of the machine code that a compiler makes, and remove those that have long been unused."""
    kernels = (file for name in KERNELS for file in sorted((_CORE / name).rglob("*.py")))
    folder = BASE / f"kernels-{compiler}-{hash_sources(kernels)}"
    with suppress(OSError):
        # Files that are only read leave the time of their folder as it is.
        os.utime(folder)
        return folder
    for other in BASE.glob("kernels-*-*"):
        with suppress(OSError):
            if time.time() - other.stat().st_mtime > UNUSED_S:
                shutil.rmtree(other)
    return folder


@contextmanager
def use_folder(folder: Path) -> Iterator[None]:
    """Let the caches that numba opens in this context be in a folder; RuntimeError if it cannot be written to."""
    usual, _CONFIG.CACHE_DIR = _CONFIG.CACHE_DIR, str(folder)
    try:
        yield
    finally:
        _CONFIG.CACHE_DIR = usual


@contextmanager
def lock(path: Path) -> Iterator[None]:
    """Let one process at a time into this context; all of them where nothing can be written, or after :data:`WAIT_S`."""
    with ExitStack() as held:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            held.enter_context(FileLock(path, WAIT_S))
        except TimeoutError:
            print(
                f"{path} was held by another process for {WAIT_S:g} s; not waiting longer", file=sys.stderr, flush=True
            )
        except (OSError, NotImplementedError):
            pass
        yield


@cache
def announce(seconds: int) -> None:
    """Print once that a compilation of so many seconds begins, unless the display of a run on a terminal shows it.

    A file in the cache keeps the other processes of the same run silent; a run that a server began is a session of its
    own. Flights in space, near fittings or in another simulator need other machine code: each kind is compiled once.
    """
    marker, often = BASE / "kernels.announced", "; later runs load the result"
    session = str(os.getsid(0)).encode() if hasattr(os, "getsid") else b""
    with suppress(OSError):
        BASE.mkdir(parents=True, exist_ok=True)
    if not os.access(BASE, os.W_OK):
        often = f", at each start: {BASE} cannot be written to; set NUMBA_CACHE_DIR to a directory that can"
        marker = Path(gettempdir()) / f"driftform-{getattr(os, 'getuid', os.getpid)()}.announced"
    with suppress(OSError):
        if abs(time.time() - marker.stat().st_mtime) < ANNOUNCED_S and marker.read_bytes() == session:
            return
    with suppress(OSError):
        # In a folder for all, another user may have put a link there.
        number = os.open(marker, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_NOFOLLOW", 0), 0o600)
        os.write(number, session)
        os.close(number)
    is_worker = multiprocessing.parent_process() is not None
    if not (is_worker and sys.stdout.isatty() and sys.stderr.isatty()):
        text = f"compiling the equations of motion for this kind of flight, about {seconds} s{often}"
        print(text, file=sys.stderr, flush=True)
