"""Third-party code: packages that may be missing, and parsers and programs that may crash, loop, or take all memory."""

import json
import os
import pickle
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module, util
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error

__all__ = ["call_apart", "require_module", "run_program"]

SECONDS = 20.0
"""Processor time of a call, s."""

MEMORY = 1 << 30
"""Memory of a call, bytes."""

OUTPUT = 1 << 30
"""Largest file that may be written, answers and what is printed included, bytes."""

_PATIENCE = 6
"""Longest wait for a process, in times of its processor time: other processes may be at work."""

_READ = 1 << 24
"""Bytes of a program's output that are read."""

_DATA = frozenset(
    [
        ("numpy", "dtype"),
        ("numpy", "ndarray"),
        ("numpy.core.multiarray", "_reconstruct"),
        ("numpy.core.multiarray", "scalar"),
        ("numpy.core.numeric", "_frombuffer"),
    ]
)
"""What an answer may name: the makers of arrays and numbers."""

# Limits are set by a process of its own, which then becomes the program: between fork and exec of a process with threads
# no Python may run.
_LIMITED = """
import os, resource, sys
limits = (resource.RLIMIT_DATA, resource.RLIMIT_FSIZE, resource.RLIMIT_CPU)
for limit, most in zip(limits, map(int, sys.argv[1:4])):
    if most >= 0:
        # One more as the hard limit: the signal at the soft limit of time says what happened.
        hard = resource.getrlimit(limit)[1]
        hard = most + 1 if hard == resource.RLIM_INFINITY else min(most + 1, hard)
        resource.setrlimit(limit, (min(most, hard), hard))
os.execv(sys.argv[4], sys.argv[4:])
"""

_ANSWER = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from driftform.util.foreign import _answer; _answer()"
)

_REPORTED = {kind.__name__: kind for kind in (InputError, WorkFailedError, ModuleNotFoundError, ValueError)}
"""Errors that cross from one process to the other."""


def require_module(module: str) -> None:
    """Check that a module is installed which a plugin imports later, so that the plugin is unavailable without it.

    Raises ModuleNotFoundError if the module is not installed.
    """
    if util.find_spec(module) is None:
        raise ModuleNotFoundError(f"No module named '{module}'", name=module)


def call_apart(function: Callable[..., Any], *arguments: Any, seconds: float = SECONDS, memory: int = MEMORY) -> Any:
    """Call a function in a process of its own, with limits, and return its answer: for parsers of untrusted files.

    Args:
        function: of the top level of a module that can be imported.
        arguments: data; a path arrives as text, and absolute.
        seconds: limit of processor time, s.
        memory: limit of memory, bytes; Windows has no such limit, macOS a weak one.

    Returns:
        Any: numbers, texts, arrays of numbers, and lists, tuples and dictionaries of these. An answer that names
            anything else is refused, because code that a file makes a parser run must not reach this process.

    Raises:
        DriftformError, ModuleNotFoundError, ValueError: if the function raises one of these.
        ValueError: if it raises another error, crashes, or takes more than it may; the message does not name the
            file.
    """
    plain = [str(argument.absolute()) if isinstance(argument, Path) else argument for argument in arguments]
    with TemporaryDirectory(prefix="driftform-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        (folder / "question").write_bytes(pickle.dumps((function.__module__, function.__qualname__, plain)))
        path = [str(Path(entry).absolute()) for entry in sys.path]
        command = [sys.executable, "-P", "-c", _ANSWER, json.dumps(path)]
        code, printed = _run(command, folder, _PATIENCE * seconds, memory, processor=int(seconds) + 1)
        try:
            with (folder / "answer").open("rb") as file:
                error, answer = _DataUnpickler(file).load()
        except Exception:
            raise ValueError(_describe_end(code, printed, seconds)) from None
    if error is None:
        return answer
    if error == MemoryError.__name__:
        raise ValueError(f"cannot be read: that takes more than {memory >> 20} MB of memory")
    raise _REPORTED[error](*answer)


def run_program(command: Sequence[str], folder: Path, seconds: float, memory: int = 8 << 30) -> str:
    """Run a program with its arguments in ``folder``; return the beginning of its output, standard error included.

    Its limits are ``seconds`` of waiting and ``memory`` in bytes. The exit code is not looked at, because programs for
    printing return 0 whatever happens. Raises WorkFailedError if it does not end in time, or cannot be started.
    """
    program = shutil.which(command[0])
    if program is None:
        raise WorkFailedError(f"{command[0]} cannot be run: it is not on PATH")
    try:
        code, printed = _run([program, *command[1:]], folder, seconds, memory)
    except OSError as error:
        raise WorkFailedError(f"{command[0]} cannot be run: {error.strerror}") from None
    if code is None:
        raise WorkFailedError(f"{command[0]} did not end within {seconds:g} s")
    return printed


def _run(command: list[str], folder: Path, seconds: float, memory: int, processor: int = -1) -> tuple[int | None, str]:
    """Run a command in a folder; return its exit code, ``None`` if it took too long, and what it printed.

    Limits are ``seconds`` of waiting, ``memory`` in bytes, and ``processor`` time in s, negative for any.
    """
    if sys.platform != "win32":
        limits = (str(memory), str(OUTPUT), str(processor))
        command = [sys.executable, "-I", "-S", "-c", _LIMITED, *limits, *command]
    output = folder / "output.txt"
    # One thread: each further one would take memory, and the answer might depend on their number.
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    with output.open("wb") as file:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        code: int | None = None
        with process:
            try:
                code = process.wait(seconds)
            except subprocess.TimeoutExpired:
                pass
            finally:
                # With the processes that it started.
                with suppress(OSError):
                    process.kill() if sys.platform == "win32" else os.killpg(process.pid, signal.SIGKILL)
    if sys.platform != "win32" and code == -signal.SIGXCPU:
        code = None
    with output.open("rb") as file:
        return code, file.read(_READ).decode(errors="replace")


def _describe_end(code: int | None, printed: str, seconds: float) -> str:
    if code is None:
        return f"cannot be read within {seconds:g} s"
    if code == 0:
        return "cannot be read: its reader gives no data"
    said = next((line.strip() for line in reversed(printed.splitlines()) if line.strip()), "")
    how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    return f"cannot be read: its reader crashes ({how}{f': {said[:200]}' if said else ''})"


class _DataUnpickler(pickle.Unpickler):
    """Reads an answer that names nothing but arrays."""

    def find_class(self, module: str, name: str) -> Any:
        # Since version 2, numpy names the same makers by a package with an underscore.
        if (module.replace("._core.", ".core."), name) not in _DATA:
            raise pickle.UnpicklingError(f"an answer names {module}.{name}")
        return super().find_class(module, name)


def _answer() -> None:
    """Call the function that is asked for, and write its answer; runs in the process with limits."""
    module, name, arguments = pickle.loads(Path("question").read_bytes())
    function: Any = import_module(module)
    for part in name.split("."):
        function = getattr(function, part)
    error: str | None = None
    answer: Any
    try:
        answer = function(*arguments)
    except DriftformError as raised:
        kind = InputError if isinstance(raised, InputError) else WorkFailedError
        error, answer = kind.__name__, raised.args
    except MemoryError:
        error, answer = MemoryError.__name__, ()
    except ModuleNotFoundError as raised:
        error, answer = ModuleNotFoundError.__name__, (str(raised),)
    except BaseException as raised:
        reason = raised.strerror or raised if isinstance(raised, OSError) else describe_error(raised)
        has_words = isinstance(raised, ValueError) and not isinstance(raised, UnicodeError)
        text = str(raised) if has_words else f"cannot be read: {reason}"
        error, answer = ValueError.__name__, (text,)
    Path("answer").write_bytes(pickle.dumps((error, answer), protocol=5))
