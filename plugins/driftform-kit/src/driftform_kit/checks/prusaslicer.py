"""PrusaSlicer's report on the meshes, and the g-code that it makes of them."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

from driftform.errors import WorkFailedError
from driftform.interfaces import Checker, Printer, PrintJob, Table, option
from driftform.types import Finding, State
from driftform.util.foreign import run_program
from driftform_frusta.csg import MM
from driftform_kit.checks.programs import last_line, require_program
from driftform_kit.reading import provide_stl, read_meshes
from driftform_kit.templates import fill_template

_FILAMENT = 1.75
"""Diameter of the filament, mm."""

_FAULTS = "open_edges", "facets_reversed", "backwards_edges", "degenerate_facets", "facets_removed"
"""Counts that it prints of a mesh that is not sound."""

_SECONDS = {"d": 86400, "h": 3600, "m": 60, "s": 1}


class PrusaSlicerOptions(Table):
    """Print settings for PrusaSlicer, and the limits that pass."""

    layer_height: float = option(0.0002, "height of a layer", "m", gt=0, le=0.01)
    perimeters: int = option(3, "maximum number of perimeters of a wall", ge=1, le=100)
    infill: float = option(1.0, "filled share of the room between the perimeters; 1: solid, as simulated", ge=0, le=1)
    least: float = option(0.95, "minimum ratio of filament to mesh volume that passes", ge=0, le=10)
    timeout: float = option(300.0, "time limit for each part", "s", ge=1e-3, le=86_400)
    most: float = option(1.03, "maximum ratio of filament to mesh volume that passes", ge=0, le=10)


class PrusaSlicerChecker(Checker[PrusaSlicerOptions]):
    """Faults that PrusaSlicer finds in each mesh, and the filament and the time of its g-code.

    Filament is compared with the mesh: a slicer repairs open or inverted meshes, and then prints another solid.
    """

    name = "prusa-slicer"
    program = "prusa-slicer"
    Options: ClassVar[type[Table]] = PrusaSlicerOptions

    def check(self, job: PrintJob) -> Iterator[Finding]:
        """Report faults of the meshes, and the filament and the time of their g-code."""
        mesh, gcode = f"{self.name} mesh", f"{self.name} g-code"
        try:
            require_program(self.program)
        except WorkFailedError as error:
            yield from (Finding(check, State.SKIPPED, str(error)) for check in (mesh, gcode))
            return
        with TemporaryDirectory() as name:
            folder = Path(name)
            paths = provide_stl(job.files, folder)
            try:
                faults = [fault for path in paths if (fault := self._find_fault(path, folder))]
                if faults:
                    yield Finding(mesh, State.FAIL, "; ".join(faults))
                    yield Finding(gcode, State.SKIPPED, "repair the mesh first")
                    return
                yield Finding(mesh, State.PASS, "manifold, nothing reversed")
                yield self._compare_filament(gcode, paths, folder, job.printer)
            except WorkFailedError as error:
                yield Finding(gcode, State.SKIPPED, str(error))

    def _find_fault(self, path: Path, folder: Path) -> str:
        said = run_program([self.program, "--info", str(path)], folder, self.options.timeout)
        facts = dict(re.findall(r"^(\w+) = +(\S+)", said, re.MULTILINE))
        if "manifold" not in facts:
            return f"{path.name}: {last_line(said)}"
        wrong = "".join(f", {facts[key]} {key.replace('_', ' ')}" for key in _FAULTS if key in facts)
        if facts["manifold"] == "yes":
            return f"{path.name}: manifold{wrong}" if wrong else ""
        return f"{path.name}: not manifold{wrong}"

    def _compare_filament(self, check: str, paths: list[Path], folder: Path, printer: Printer) -> Finding:
        volume = filament = seconds = 0.0
        for path in paths:
            sliced = self._slice(path, folder, printer)
            if isinstance(sliced, str):
                return Finding(check, State.FAIL, f"{path.name}: {sliced}")
            volume += sum(part.volume for part in read_meshes(path))
            filament += sliced[0]
            seconds += sliced[1]
        ratio = filament / volume if volume > 0 else float("nan")
        sound = self.options.least <= ratio <= self.options.most
        hours, minutes = divmod(round(seconds / 60), 60)
        return Finding(
            check,
            State.PASS if sound else State.FAIL,
            f"filament {filament / 1000:.2f} cm3, {ratio:.3f} of the mesh; prints in {hours} h {minutes} min"
            + ("" if sound else f"; expected {self.options.least:g} to {self.options.most:g}")
            + ("; thick walls are not filled: raise infill" if ratio < self.options.least else ""),
        )

    def _slice(self, path: Path, folder: Path, printer: Printer) -> tuple[float, float] | str:
        """Return the filament (mm3) and the time (s) of a part by its g-code, or the reason why there is no g-code."""
        o = self.options
        bed = [f"{MM * side:g}" for side in printer.bed]
        config, gcode = folder / "slicer.ini", folder / "part.gcode"
        lines = fill_template("slicer.ini", options=o, printer=printer, mm=MM, filament=_FILAMENT, bed=bed)
        config.write_text("\n".join(lines), encoding="utf-8")
        gcode.unlink(missing_ok=True)
        command = [self.program, "--export-gcode", f"--load={config}", f"--output={gcode}", str(path)]
        said = run_program(command, folder, o.timeout)
        text = gcode.read_text(encoding="utf-8", errors="replace") if gcode.is_file() else ""
        used = re.search(r"^; filament used \[mm\] = ([\d.]+)", text, re.MULTILINE)
        time = re.search(r"^; estimated printing time \(normal mode\) = (.+)$", text, re.MULTILINE)
        if used is None or time is None:
            return last_line(said)
        section = math.pi / 4 * _FILAMENT**2
        spent = sum(int(count) * _SECONDS[mark] for count, mark in re.findall(r"(\d+)([dhms])", time[1]))
        return float(used[1]) * section, float(spent)
