"""Faults that admesh finds."""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from driftform.errors import WorkFailedError
from driftform.interfaces import Checker, PrintJob, Table
from driftform.types import Finding, State
from driftform.util.foreign import run_program
from driftform_kit.checks.programs import TIMEOUT, last_line, require_program
from driftform_kit.reading import provide_stl

_FAULTS = "Total disconnected facets", "Degenerate facets", "Facets reversed", "Facets added", "Edges fixed"
"""Counts that admesh prints; each is 0 for a mesh without faults."""


class AdmeshChecker(Checker[Table]):
    """Faults that admesh would repair: disconnected, degenerate and reversed facets."""

    name = "admesh"
    program = "admesh"

    def check(self, job: PrintJob) -> Iterator[Finding]:
        """Report its counts, summed over all files."""
        counts, unread = Counter[str](), ""
        try:
            require_program(self.program)
            with TemporaryDirectory() as folder:
                for path in provide_stl(job.files, Path(folder)):
                    said = run_program([self.program, str(path)], Path(folder), TIMEOUT)
                    # It prints two columns for some: before and after the repair.
                    found = dict(re.findall(rf"({'|'.join(_FAULTS)})\s*:\s*(\d+)", said))
                    counts += Counter({title: int(count) for title, count in found.items()})
                    unread = unread or ("" if len(found) == len(_FAULTS) else f"{path.name}: {last_line(said)}")
        except WorkFailedError as error:
            yield Finding(self.name, State.SKIPPED, str(error))
            return
        faults = ", ".join(f"{count} {title.lower()}" for title, count in counts.items())
        detail = unread or (f"facets that it would repair: {faults}" if faults else "nothing to repair")
        yield Finding(self.name, State.FAIL if unread or faults else State.PASS, detail)
