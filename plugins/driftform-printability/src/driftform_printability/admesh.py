"""What admesh finds to mend."""

import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

from driftform.errors import WorkFailedError
from driftform.interfaces import Checker, PrintJob
from driftform.options import Table, option
from driftform.types import Finding, State
from driftform_printability.programs import explain_missing, last_line, run_program
from driftform_printability.slicing import provide_stl

_FAULTS = {
    "Total disconnected facets": "disconnected",
    "Degenerate facets": "degenerate",
    "Facets reversed": "reversed",
    "Facets added": "added",
    "Edges fixed": "edges fixed",
}
"""What it prints a count of, by what a line has room for; the count is 0 for a mesh that needs no mending."""


class AdmeshOptions(Table):
    """How admesh is asked."""

    timeout: float = option(60.0, "longest time that it may take for a file", "s", gt=0)


class AdmeshChecker(Checker[AdmeshOptions]):
    """What admesh would mend before it trusts a mesh: disconnected, degenerate and reversed facets."""

    name = "admesh"
    program = "admesh"
    Options: ClassVar[type[Table]] = AdmeshOptions

    def check(self, job: PrintJob) -> Iterator[Finding]:
        """Tell what it counts in all files."""
        if reason := explain_missing(self.program):
            yield Finding(self.name, State.SKIPPED, reason)
            return
        counts = dict.fromkeys(_FAULTS.values(), 0)
        with TemporaryDirectory() as folder:
            for path in provide_stl(job.files, Path(folder)):
                try:
                    said = run_program([self.program, str(path)], Path(folder), self.options.timeout)
                except WorkFailedError as error:
                    yield Finding(self.name, State.SKIPPED, str(error))
                    return
                for title, name in _FAULTS.items():
                    # It prints two columns for some: before and after mending.
                    found = re.search(rf"{title}\s*:\s*(\d+)", said)
                    if found is None:
                        yield Finding(self.name, State.FAIL, f"{path.name}: {last_line(said)}")
                        return
                    counts[name] += int(found[1])
        faults = [f"{count} {name}" for name, count in counts.items() if count]
        if faults:
            yield Finding(self.name, State.FAIL, f"facets it would mend: {', '.join(faults)}")
        else:
            yield Finding(self.name, State.PASS, "nothing to mend")
