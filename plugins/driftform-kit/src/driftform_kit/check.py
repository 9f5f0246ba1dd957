"""Check printable files: whether they can be printed and are what was simulated."""

import os
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from driftform import Design, Study, load_study, open_agent
from driftform.errors import InputError, WorkFailedError, describe_error
from driftform.interfaces import Printer, PrintJob
from driftform.types import Finding, State, WrittenFile
from driftform.util import files
from driftform_frusta.hull import printed_volume
from driftform_frusta.parts import KIT_FILE
from driftform_kit.settings import list_kit_settings, read_kit_settings

_MAX_ATTACHMENT = 1 << 26
"""Largest file in an archive that is read, bytes."""


def write_files(design: Design, format: str, folder: Path) -> tuple[WrittenFile, ...]:
    """Write an agent in one format into a folder, under its name; return the files that can be printed, not drawings."""
    suffix = design.study.make_exporter(format).suffix
    written = design.export_files(format, folder / f"{design.name}{suffix}")
    return tuple(file for file in written if file.path.endswith(suffix))


def sum_volumes(written: Sequence[WrittenFile]) -> float | None:
    """Return the volume (m3) that exporters state for their files, ``None`` if one of them states none."""
    volumes = [v for file in written if isinstance(v := file.facts.get("volume_mm3"), float)]
    return sum(volumes) / 1000**3 if len(volumes) == len(written) else None


def extract_attachment(path: Path, ending: str, folder: Path) -> Path | None:
    """Copy the file of an archive, such as a 3MF, whose name ends so into a folder; ``None`` without such a file.

    Raises InputError if the archive, or the file in it, cannot be read.
    """
    try:
        if not zipfile.is_zipfile(path):
            return None
        with zipfile.ZipFile(path) as archive:
            for member in archive.infolist():
                if member.filename.endswith(ending) and member.file_size < _MAX_ATTACHMENT:
                    copy = folder / f"attached{ending}"
                    copy.write_bytes(archive.read(member))
                    return copy
    except Exception as error:
        # Of archives made to do harm, zipfile raises a dozen kinds of errors.
        raise InputError(f"{path}: cannot be read as an archive: {describe_error(error)}") from None
    return None


def list_findings(
    job: PrintJob, study: Study, programs: bool = True, on_program: Callable[[str], None] = lambda _: None
) -> list[Finding]:
    """Return what each installed checker finds, with the options of a study; those that need no program come first.

    ``programs`` and ``on_program`` are as for :func:`check_design`.

    Raises WorkFailedError if every check was skipped; the message gives the reasons.
    """
    found: list[Finding] = []
    rows = [(getattr(row.cls, "program", ""), row) for row in Study.list_plugins("checker")]
    for program, row in sorted(rows, key=lambda pair: bool(pair[0])):
        if not row.available:
            found.append(Finding(row.name, State.SKIPPED, row.state))
        elif program and not programs:
            found.append(Finding(row.name, State.SKIPPED, "not run, by --no-programs"))
        else:
            if program:
                on_program(program)
            found += study.check_print(row.name, job)
    if all(finding.state is State.SKIPPED for finding in found):
        reasons = dict.fromkeys(f"{finding.check}: {finding.detail}" for finding in found)
        raise WorkFailedError("nothing could be checked: " + ("; ".join(reasons) or "no checker is installed"))
    return found


def check_design(
    design: Design,
    format: str = "stl",
    *,
    printer: Printer | None = None,
    kit: bool = False,
    programs: bool = True,
    on_program: Callable[[str], None] = lambda _: None,
) -> list[Finding]:
    """Write an agent's files into a temporary folder, and return what the installed checkers find.

    Args:
        format: name of an exporter; InputError if it is unknown or writes no kits.
        printer: nozzle and bed; ``None`` for a common desktop printer.
        kit: check the kit that fits the printer, in place of the hull in one piece.
        programs: whether programs on PATH, such as OpenSCAD and a slicer, are run.
        on_program: called with the name of each program before it is run.

    Raises:
        WorkFailedError: if nothing could be checked.
    """
    printer = printer or Printer()
    # OpenSCAD source too, if it can be written.
    others = [row.name for row in Study.list_plugins("exporter") if row.name == "scad" and row.available]
    formats = dict.fromkeys((format, *others))
    made = design.under(*list_kit_settings(formats, printer)) if kit else design
    with TemporaryDirectory() as folder:
        written = {name: write_files(made, name, Path(folder)) for name in formats}
        source = Path(written["scad"][0].path) if "scad" in written and format != "scad" else None
        # The parts of a kit hold other material than the hull.
        volume = (sum_volumes(written[format]) if kit else None) or printed_volume(made.agent.body)
        paths = tuple(Path(file.path) for file in written[format])
        job = PrintJob(paths, printer, made.export_job(), volume, source)
        return list_findings(job, made.study, programs, on_program)


def check_file(
    path: str | os.PathLike[str],
    agent: str | None = None,
    settings: Sequence[str] = (),
    *,
    printer: Printer | None = None,
    kit: bool = False,
    programs: bool = True,
    on_program: Callable[[str], None] = lambda _: None,
) -> list[Finding]:
    """Return what the installed checkers find about a printable file.

    Args:
        path: of the file.
        agent: agent of the file; ``None`` for the agent.json in the file or in its folder, if any.
        settings: ``key=value`` of the study, as ``--set`` takes them.
        printer, kit, programs, on_program: as for :func:`check_design`. A 3MF file of a kit says itself that it is
            one, for which printer, and with which options it was made; ``settings`` come before these.

    Raises:
        InputError: if the file cannot be read, or the agent of a kit is not known.
        WorkFailedError: if nothing could be checked.
    """
    path = Path(path)
    with TemporaryDirectory() as name:
        folder = Path(name)
        known = agent or extract_attachment(path, "agent.json", folder) or path.with_name("agent.json")
        job = PrintJob((path,), printer or Printer())
        if agent is None and not files.is_file(Path(known)):
            if kit:
                raise InputError(f"--kit: the agent of {path} is not known; name it with --agent")
            study = load_study(None, settings, run={"seed": 0})
        else:
            format = path.suffix[1:].lower()
            if (options := extract_attachment(path, KIT_FILE, folder)) is not None:
                kit = True
                settings = [*read_kit_settings(options, f"{path}: its {KIT_FILE}", format), *settings]
            elif kit:
                settings = [*settings, *list_kit_settings((format,), job.printer)]
            design = open_agent(str(known), *settings)
            study = design.study
            volume = printed_volume(design.agent.body)
            if kit:
                # In a format that holds one solid there is a file for each part.
                written = write_files(design, format, folder)
                named = [file for file in written if Path(file.path).name == path.name]
                volume = sum_volumes(named or written) or volume
            if options is not None and printer is None:
                made = study.make_exporter(format).options
                job = replace(job, printer=Printer(made.nozzle, made.bed))
            job = replace(job, export=design.export_job(), volume=volume)
        return list_findings(job, study, programs, on_program)
