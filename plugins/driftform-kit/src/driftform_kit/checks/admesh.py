"""Faults that admesh finds."""

import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

from driftform.errors import WorkFailedError
from driftform.interfaces import Checker, PrintJob, Table, option
from driftform.types import Finding, State
from driftform.util.foreign import run_program
from driftform_kit.checks.programs import last_line, require_program
from driftform_kit.reading import provide_stl

_FAULTS = {
    "Total disconnected facets": "disconnected",
    "Degenerate facets": "degenerate",
    "Facets reversed": "reversed",
    "Facets added": "added",
    "Edges fixed": "edges fixed",
}
"""Counts that admesh prints, and their short names; each is 0 for a mesh without faults."""


class AdmeshOptions(Table):
    """Options of admesh."""

    timeout: float = option(60.0, "time limit for each file", "s", ge=1e-3, le=86_400)


class AdmeshChecker(Checker[AdmeshOptions]):
    """Faults that admesh would repair: disconnected, degenerate and reversed facets."""

    name = "admesh"
    program = "admesh"
    Options: ClassVar[type[Table]] = AdmeshOptions

    def check(self, job: PrintJob) -> Iterator[Finding]:
        """Report its counts, summed over all files."""
        try:
            require_program(self.program)
            yield Finding(self.name, *self._judge(job))
        except WorkFailedError as error:
            yield Finding(self.name, State.SKIPPED, str(error))

    def _judge(self, job: PrintJob) -> tuple[State, str]:
        counts = dict.fromkeys(_FAULTS.values(), 0)
        with TemporaryDirectory() as folder:
            for path in provide_stl(job.files, Path(folder)):
                said = run_program([self.program, str(path)], Path(folder), self.options.timeout)
                for title, name in _FAULTS.items():
                    # It prints two columns for some: before and after the repair.
                    found = re.search(rf"{title}\s*:\s*(\d+)", said)
                    if found is None:
                        return State.FAIL, f"{path.name}: {last_line(said)}"
                    counts[name] += int(found[1])
        faults = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
        return (State.FAIL, f"facets that it would repair: {faults}") if faults else (State.PASS, "nothing to repair")
