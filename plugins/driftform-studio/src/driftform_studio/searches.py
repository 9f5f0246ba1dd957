"""Searches in processes of their own: begin, pause and continue them. They continue when the server ends."""

import re
import subprocess
import sys
import time
from pathlib import Path

from driftform import Run
from driftform.errors import InputError
from driftform.util import files

HELD = ".studio.lock"
"""Lock file of a run that a search of the page holds: it listens to :data:`PAUSE`."""

PAUSE = ".pause"
"""File of a run that asks its search to pause."""

PROGRESS = ".disturbed"
"""File of a run with the number of disturbed flights that are done, and of all."""

LOG = "search.log"
"""File of a run with what its search printed."""

_DETACHED = 0x00000008 | 0x00000200
"""Windows: DETACHED_PROCESS and CREATE_NEW_PROCESS_GROUP."""


class Searches:
    """The searches that this server began, with their processes."""

    def __init__(self) -> None:
        self._processes: dict[Path, subprocess.Popen[bytes]] = {}

    def start(self, directory: Path, evaluations: int | None = None) -> None:
        """Continue a run in a process of its own, with a larger budget if ``evaluations`` is given.

        Raises InputError if a process works on the run already.
        """
        if Run.glance(directory)["is_worked_on"] or self.is_alive(directory):
            raise InputError(f"{directory.name}: a search works on this run already")
        (directory / PAUSE).unlink(missing_ok=True)
        budget = [] if evaluations is None else [str(evaluations)]
        (directory / LOG).unlink(missing_ok=True)
        with (directory / LOG).open("xb") as log:
            self._processes[directory] = subprocess.Popen(
                [sys.executable, "-m", "driftform_studio.search", str(directory), *budget],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                # Ctrl-C in the terminal of the server is not meant for it.
                start_new_session=sys.platform != "win32",
                creationflags=_DETACHED if sys.platform == "win32" else 0,
            )

    def pause(self, directory: Path) -> None:
        """Ask the search of a run to pause; its results are stored already.

        Raises InputError if the run is not searched by the page.
        """
        if not self.can_pause(directory):
            raise InputError(
                f"{directory.name}: no search of the page works on this run; Ctrl-C stops one in a terminal"
            )
        (directory / PAUSE).touch()

    def can_pause(self, directory: Path) -> bool:
        """Return whether the search of a run listens to the page, whichever server began it."""
        return files.is_locked(directory / HELD) or self.is_alive(directory)

    def read_failure(self, directory: Path) -> str:
        """Return the last lines that a search printed which this server began and which failed; empty if it did not."""
        process = self._processes.get(directory)
        if process is None or process.poll() in (None, 0):
            return ""
        lines = (directory / LOG).read_text(encoding="utf-8", errors="replace").splitlines()
        errors = [line for line in lines if line.startswith("error: ")]
        return "\n".join(errors or lines[-5:]) or f"the search ended with exit code {process.returncode}"

    def read_compilation(self, directory: Path) -> list[float]:
        """Return the time since a search began to compile kernels, its estimate, s, and whether it is once; empty if it compiles none."""
        try:
            said = re.findall(
                r"^compiling .* about (\d+) s(; later)?", (directory / LOG).read_text(errors="replace"), re.M
            )
            since = time.time() - (directory / LOG).stat().st_mtime
            return [since, float(said[-1][0]), float(bool(said[-1][1]))] if said else []
        except OSError:
            return []

    def count_alive(self) -> int:
        """Return the number of running searches that this server began."""
        return sum(self.is_alive(directory) for directory in self._processes)

    def is_alive(self, directory: Path) -> bool:
        """Return whether a search of a run that this server began is running."""
        process = self._processes.get(directory)
        return process is not None and process.poll() is None
