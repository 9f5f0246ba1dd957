"""The volume of the source, rendered by OpenSCAD."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

from driftform.errors import InputError, WorkFailedError
from driftform.interfaces import Checker, PrintJob, Table, option
from driftform.types import Finding, State
from driftform_frusta.hull import MM3_PER_M3
from driftform_kit.checks.programs import render, require_program
from driftform_kit.reading import read_meshes


class OpenScadOptions(Table):
    """Options of OpenSCAD."""

    tolerance: float = option(1e-4, "largest relative difference of volume that passes", ge=1e-12, lt=1)


class OpenScadChecker(Checker[OpenScadOptions]):
    """The OpenSCAD source that belongs to the files, rendered: its volume compared with theirs."""

    name = "openscad"
    program = "openscad"
    Options: ClassVar[type[Table]] = OpenScadOptions

    def check(self, job: PrintJob) -> Iterator[Finding]:
        """Report the volume of the source, and whether it equals that of the meshes."""
        yield Finding(self.name, *self._judge(job))

    def _judge(self, job: PrintJob) -> tuple[State, str]:
        if job.source is None:
            return State.SKIPPED, "no OpenSCAD source to render"
        with TemporaryDirectory() as folder:
            try:
                require_program(self.program)
                rendered = read_meshes(render(job.source, Path(folder)))
            except InputError as error:
                return State.FAIL, str(error).removeprefix(f"{job.source}: OpenSCAD: ")
            except WorkFailedError as error:
                return State.SKIPPED, str(error)
        volume = sum(part.volume for part in rendered)
        # A broken mesh does not show whether the source is right.
        meshed = sum(part.volume for path in job.files for part in read_meshes(path))
        what, other = ("the closed form", job.volume * MM3_PER_M3) if job.volume else ("the mesh", meshed)
        difference = volume / other - 1 if other else float("inf")
        message = f"the source renders to {volume / 1000:.4f} cm3, {difference:+.1e} of {what}"
        return State.PASS if abs(difference) <= self.options.tolerance else State.FAIL, message
