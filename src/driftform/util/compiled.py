"""Compilation of kernels with numba; the machine code is cached on disk until any of their sources changes.

Kernels count no references to arrays: their caller keeps every array alive. Counting is atomic, and took half of the time
of a flight. A kernel that makes arrays, or gets new ones from another kernel, counts them: it is `allocating`.
A kernel that returns arrays in the memory of others is `borrowing`.

This, and a compilation in a third of the time, is the work of :mod:`driftform.util.compiler`, which rests on internals of
numba. Where they have changed, :mod:`driftform.util.plain_compiler` gives the same results.
"""

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, ParamSpec, TypeVar

import numba

from driftform.errors import InputError
from driftform.util.kernel_cache import BASE, hash_sources, lock
from driftform.util.preparation import preparing

P = ParamSpec("P")
R = TypeVar("R")

COMPILER_VARIABLE = "DRIFTFORM_COMPILER"
"""Environment variable that selects the compiler: ``plain`` is numba's own."""

TEST_LIMIT_S = 120.0
"""Longest duration of the test of the compiler, s."""


def _is_plain() -> bool:
    """Return whether numba's own compiler is asked for, or is the only one that works; say so once per machine."""
    chosen = os.environ.get(COMPILER_VARIABLE, "")
    if chosen not in ("", "plain"):
        raise InputError(f"{COMPILER_VARIABLE}: unknown compiler {chosen!r}; set it to 'plain', or unset it")
    if chosen:
        return True
    here = Path(__file__).parent
    tested = (here / f"{name}.py" for name in ("compiler", "compiler_check", "kernel_cache"))
    result = BASE / f"kernels-{hash_sources(tested)}.tested"
    with suppress(OSError):
        return result.read_bytes() == b"fails"
    with preparing(), lock(result.with_suffix(".lock")):
        with suppress(OSError):
            return result.read_bytes() == b"fails"
        fault = _test_compiler()
        with suppress(OSError):
            result.write_text("fails" if fault else "works")
    if fault:
        text = f"kernels are compiled by numba's own compiler, for slower flights with the same results: {fault}"
        print(text, file=sys.stderr, flush=True)
    return bool(fault)


def _test_compiler() -> str:
    """Return why the compiler of kernels does not work with the numba that is here, in one line, or ``""`` if it does.

    The test has a process of its own, because wrong machine code may end it.
    """
    path = os.pathsep.join(filter(None, sys.path))
    try:
        with TemporaryDirectory(prefix="driftform-", ignore_cleanup_errors=True) as folder:
            done = subprocess.run(
                [sys.executable, "-c", "import driftform.util.compiler_check"],
                env={**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": folder},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=TEST_LIMIT_S,
                check=False,
            )
    except (OSError, subprocess.SubprocessError) as error:
        return f"numba {numba.__version__} cannot be tested: {error}"
    if done.returncode == 0:
        return ""
    reason = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
    return f"numba {numba.__version__} fails the test of the faster one ({reason})"


IS_PLAIN = _is_plain()
"""Whether kernels are compiled by numba's own compiler."""


if TYPE_CHECKING or not IS_PLAIN:
    from driftform.util.compiler import borrow, borrow_as, compile_kernel
else:
    from driftform.util.plain_compiler import borrow, borrow_as, compile_kernel


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function in numba's nopython mode, with its machine code cached on disk if Python calls it."""
    return compile_kernel(function)


def allocating(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function as :func:`compiled` does, which makes arrays, or returns some, or calls one that returns some."""
    return compile_kernel(function, allocates=True)


def borrowing(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function as :func:`compiled` does, which returns arrays, all of which it has from :data:`borrow`."""
    return compile_kernel(function, borrows=True)


def vectorized(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function as :func:`allocating` does, with more optimization of it and of what it calls.

    For long loops of arithmetic, which then use instructions for several numbers at once.
    """
    return compile_kernel(function, allocates=True, vectorizes=True)


__all__ = ["allocating", "borrow", "borrow_as", "borrowing", "compiled", "vectorized"]
