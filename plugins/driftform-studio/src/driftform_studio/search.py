"""A search in a process of its own: ``python -m driftform_studio.search RUN``. It continues when the server ends.

It does what ``driftform resume`` does, and pauses when the page asks for it.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from driftform import Run
from driftform.errors import DriftformError
from driftform.search import Observer, open_executor
from driftform.util import files
from driftform_studio.searches import HELD, PAUSE, PROGRESS


class PausedError(KeyboardInterrupt):
    """The page asked for a pause; as an interrupt, no handler of errors takes it for a fault."""


class _Listener(Observer):
    """Raises :class:`PausedError` when the page asks for a pause, and writes down how far the finalists are."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory

    def _listen(self) -> None:
        if (self._directory / PAUSE).exists():
            raise PausedError

    def record(self, record: object) -> None:
        self._listen()

    def warn(self, text: str) -> None:
        print(f"warning: {text}", flush=True)

    @contextmanager
    def open_finalists(self) -> Iterator[Callable[[int, int], None]]:
        def show(done: int, total: int) -> None:
            self._listen()
            files.write_text(self._directory / PROGRESS, f"{done} {total}\n")

        yield show


def search(directory: Path, evaluations: int | None = None) -> None:
    """Advance a run to the end of its budget, or until the page asks for a pause."""
    with FileLock(directory / HELD, timeout=1), Run.resume(directory, evaluations) as run:
        try:
            with open_executor(run.study) as executor:
                problems = run.advance(executor, _Listener(directory))
        except PausedError:
            print("paused", flush=True)
            return
        finally:
            for name in (PAUSE, PROGRESS):
                (directory / name).unlink(missing_ok=True)
    for problem in problems:
        print(f"warning: {problem}", flush=True)


def main(arguments: list[str]) -> int:
    """Search, and return the exit code: 0 for a search that ended or paused."""
    try:
        search(Path(arguments[0]), int(arguments[1]) if len(arguments) > 1 else None)
    except DriftformError as error:
        print(*(f"error: {line}" for line in error.args), sep="\n", flush=True)
        return error.exit_code
    except Timeout:
        print("error: another search of the page works on this run", flush=True)
        return 2
    except KeyboardInterrupt:
        print("interrupted", flush=True)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
