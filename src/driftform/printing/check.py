"""Check printable files: whether they can be printed and are what was simulated."""

import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error
from driftform.faults import describe_fault
from driftform.geometry import hull_volume
from driftform.interfaces import Checker, ExportJob, Printer, PrintJob
from driftform.registry import registry
from driftform.seams import require_files, require_findings
from driftform.study import Study
from driftform.types import Finding, State, WrittenFile

MM_PER_M = 1000.0

_LARGEST_ATTACHMENT = 1 << 26
"""Largest file in an archive that is read, bytes."""


def list_formats(format: str) -> tuple[str, ...]:
    """Return the formats that an agent is written in to be checked: OpenSCAD source too, if it can be written."""
    with_source = any(row.name == "scad" and row.available for row in registry().seam("exporter"))
    return tuple(dict.fromkeys((format, "scad") if with_source else (format,)))


def write_print_job(
    study: Study, job: ExportJob, format: str, folder: Path, printer: Printer, kit: bool = False
) -> PrintJob:
    """Write an agent's files into a folder, and return them as what is to be printed.

    Parameters
    ----------
    study
        with the options of its exporters.
    job
        the agent.
    format
        name of an exporter.
    folder
        for the files.
    printer
        what they are to be printed with.
    kit
        whether the exporters write a kit, whose parts hold other material than the hull.
    """
    written = {name: write_files(study, job, name, folder) for name in list_formats(format)}
    source = Path(written["scad"][0].path) if "scad" in written and format != "scad" else None
    files = tuple(Path(file.path) for file in written[format])
    volume = sum_volumes(written[format]) if kit else None
    return PrintJob(files, printer, job, volume or hull_volume(job.agent.body), source)


def write_files(study: Study, job: ExportJob, format: str, folder: Path) -> tuple[WrittenFile, ...]:
    """Write an agent in one format into a folder, under its name; return the files that can be printed, not drawings."""
    exporter = study.make_exporter(format)
    written = require_files(exporter.write(job, folder / f"{job.name}{exporter.suffix}"), exporter)
    return tuple(file for file in written if file.path.endswith(exporter.suffix))


def sum_volumes(written: Sequence[WrittenFile]) -> float | None:
    """Return the volume (m3) that exporters state for their files, ``None`` if one of them states none."""
    volumes = [v for file in written if isinstance(v := file.facts.get("volume_mm3"), float)]
    return sum(volumes) / MM_PER_M**3 if len(volumes) == len(written) else None


def extract_attachment(path: Path, ending: str, folder: Path) -> Path | None:
    """Copy the file of an archive, such as a 3MF, whose name ends so into a folder; ``None`` if there is none.

    Raises
    ------
    InputError
        if the archive, or the file in it, cannot be read.
    """
    try:
        if not zipfile.is_zipfile(path):
            return None
        with zipfile.ZipFile(path) as archive:
            for member in archive.infolist():
                if member.filename.endswith(ending) and member.file_size < _LARGEST_ATTACHMENT:
                    copy = folder / f"attached{ending}"
                    copy.write_bytes(archive.read(member))
                    return copy
    except Exception as error:
        # Of archives made to do harm, zipfile raises a dozen kinds of errors.
        raise InputError(f"{path}: cannot be read as an archive: {describe_error(error)}") from None
    return None


def check_print_job(
    job: PrintJob, study: Study, programs: bool = True, on_program: Callable[[str], None] = lambda _: None
) -> Iterator[Finding]:
    """Yield what each installed checker finds; those that need no program come first.

    Parameters
    ----------
    job
        what is to be printed.
    study
        with the options of the checkers.
    programs
        whether programs on PATH, such as OpenSCAD and a slicer, are run.
    on_program
        called with the name of each program before it is run.
    """
    rows = [
        (row, row.cls if row.cls is not None and issubclass(row.cls, Checker) else None)
        for row in registry().seam("checker")
    ]
    for row, cls in sorted(rows, key=lambda pair: bool(pair[1] and pair[1].program)):
        if cls is None:
            yield Finding(row.name, State.SKIPPED, row.state)
        elif cls.program and not programs:
            yield Finding(row.name, State.SKIPPED, "not run, by --no-programs")
        else:
            if cls.program:
                on_program(cls.program)
            checker = study.make_checker(row.name)
            try:
                yield from require_findings(checker.check(job), checker)
            except DriftformError:
                raise
            except (Exception, SystemExit) as error:
                # One checker that fails is no reason to keep back what the others find.
                yield Finding(row.name, State.SKIPPED, describe_fault(error))


def require_judgement(findings: Sequence[Finding]) -> None:
    """Refuse findings that judge nothing.

    Raises
    ------
    WorkFailedError
        if every check was skipped; the message gives the reasons.
    """
    if all(finding.state is State.SKIPPED for finding in findings):
        reasons = dict.fromkeys(f"{finding.check}: {finding.detail}" for finding in findings)
        raise WorkFailedError(
            "nothing could be checked: " + ("; ".join(reasons) or "no checker is installed")
        )
