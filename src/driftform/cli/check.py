"""``driftform check``."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer

from driftform.cli.options import AGENT_HELP, Json, Settings

if TYPE_CHECKING:
    from driftform.agents.opening import Opened
    from driftform.interfaces import Printer, PrintJob
    from driftform.study import Study
    from driftform.types import Finding, WrittenFile

MM_PER_M = 1000.0

STYLES = {"pass": "green", "warn": "yellow", "fail": "bold red", "skipped": "dim"}
"""How states are shown on a terminal."""


def check(
    subject: Annotated[
        str,
        typer.Argument(
            metavar="FILE|AGENT",
            help="A printable file (.stl, .3mf, .obj, .ply, .glb, .scad), or an agent, whose files are made and then "
            f"checked. {AGENT_HELP}",
            show_default=False,
        ),
    ],
    agent: Annotated[
        str | None,
        typer.Option(
            "--agent",
            metavar="AGENT",
            help="What a FILE is to be of; by default the agent.json that is attached to it or lies beside it.",
        ),
    ] = None,
    nozzle: Annotated[
        float, typer.Option("--nozzle", metavar="MM", help="Diameter of the nozzle, mm.")
    ] = 0.4,
    bed: Annotated[
        str, typer.Option("--bed", metavar="X,Y,Z", help="Largest part that the printer can make, mm.")
    ] = "250,210,210",
    format: Annotated[
        str, typer.Option("--format", metavar="NAME", help="Format that an AGENT is exported to.")
    ] = "stl",
    kit: Annotated[
        bool,
        typer.Option("--kit", help="Of the kit that fits nozzle and bed, in place of the hull in one piece."),
    ] = False,
    programs: Annotated[
        bool,
        typer.Option(
            "--programs/--no-programs", help="Ask OpenSCAD, a slicer and the like, where they are on PATH."
        ),
    ] = True,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Tell whether files can be printed and are what was simulated; ends with exit code 1 where a line fails."""
    from driftform.cli.output import print_json
    from driftform.errors import WorkFailedError
    from driftform.types import State

    printer = _printer(nozzle, bed)
    with _job(subject, agent, format, settings or (), printer, kit) as (job, study):
        findings = list(_findings(job, study, programs))
    if all(finding.state is State.SKIPPED for finding in findings):
        reasons = dict.fromkeys(f"{finding.check}: {finding.detail}" for finding in findings)
        raise WorkFailedError(
            "nothing could be checked: " + ("; ".join(reasons) or "no checker is installed")
        )
    failed = any(finding.state is State.FAIL for finding in findings)
    if json:
        print_json(
            {
                "subject": subject,
                "printable": not failed,
                "lines": [
                    {"check": f.check, "part": f.part, "state": f.state, "detail": f.detail} for f in findings
                ],
            }
        )
    else:
        _print(findings)
    if failed:
        raise typer.Exit(1)


def _printer(nozzle: float, bed: str) -> "Printer":
    from driftform.cli.kit import parse_bed
    from driftform.errors import InputError
    from driftform.interfaces import Printer

    if not 0 < nozzle <= 10:
        raise InputError(f"--nozzle {nozzle:g}: should be a diameter in mm, such as 0.4")
    return Printer(nozzle / MM_PER_M, parse_bed(bed))


@contextmanager
def _job(
    subject: str, agent: str | None, format: str, settings: Sequence[str], printer: "Printer", kit: bool
) -> "Iterator[tuple[PrintJob, Study]]":
    """What is to be checked, and the study that has the options of checkers; files made for it are gone afterwards."""
    from driftform.errors import InputError
    from driftform.util.files import is_file

    path = Path(subject)
    with TemporaryDirectory() as name:
        folder = Path(name)
        if is_file(path) and path.suffix.lower() != ".json":
            yield _of_file(path, agent, settings, printer, kit, folder)
        elif agent is not None:
            raise InputError(f"--agent {agent}: goes with a FILE, and '{subject}' is none")
        else:
            yield _of_agent(subject, format, settings, printer, kit, folder)


def _of_agent(
    text: str, format: str, settings: Sequence[str], printer: "Printer", kit: bool, folder: Path
) -> "tuple[PrintJob, Study]":
    from driftform.agents.opening import open_agent
    from driftform.errors import InputError
    from driftform.interfaces import PrintJob
    from driftform.registry import registry

    try:
        registry().find("exporter", format)
    except InputError as error:
        raise InputError(f"--format {format}: {error}") from None
    with_source = any(row.name == "scad" and row.available for row in registry().seam("exporter"))
    formats = dict.fromkeys((format, "scad") if with_source else (format,))
    opened = open_agent(text, settings=[*settings, *_of_kit(formats, printer, kit)])
    written = {name: _exported(opened, name, folder) for name in formats}
    source = Path(written["scad"][0].path) if with_source and format != "scad" else None
    files = tuple(Path(file.path) for file in written[format])
    volume = _stated(written[format]) if kit else None
    return PrintJob(files, printer, opened.export_job(), volume or _hull(opened), source), opened.study


def _of_file(
    path: Path, agent: str | None, settings: Sequence[str], printer: "Printer", kit: bool, folder: Path
) -> "tuple[PrintJob, Study]":
    from driftform.agents.opening import open_agent
    from driftform.errors import InputError
    from driftform.interfaces import PrintJob
    from driftform.study import load_study
    from driftform.util.files import is_file

    known = agent or _attached(path, "agent.json", folder) or path.with_name("agent.json")
    source = _attached(path, ".scad", folder) or path.with_suffix(".scad")
    job = PrintJob((path,), printer, source=source if is_file(source) and source != path else None)
    if agent is None and not is_file(Path(known)):
        if kit:
            raise InputError(f"--kit: of what agent is {path}? name it by --agent")
        return job, load_study(None, settings, run={"seed": 0})
    format = path.suffix[1:].lower()
    opened = open_agent(str(known), settings=[*settings, *_of_kit((format,), printer, kit)])
    volume = _hull(opened)
    if kit:
        # Of a format that holds one solid, there is a file for each part.
        written = _exported(opened, format, folder)
        volume = _stated([w for w in written if Path(w.path).name == path.name] or written) or volume
    return PrintJob(job.files, printer, opened.export_job(), volume, job.source), opened.study


def _of_kit(formats: Iterable[str], printer: "Printer", kit: bool) -> list[str]:
    """Settings that make exporters write a kit that fits the printer."""
    from driftform.cli.kit import exporter_settings

    if not kit:
        return []
    options = {"kit": "true", "nozzle": repr(printer.nozzle), "bed": repr(list(printer.bed))}
    return exporter_settings(formats, {key: (value, "--kit") for key, value in options.items()})


def _exported(opened: "Opened", format: str, folder: Path) -> "tuple[WrittenFile, ...]":
    exporter = opened.study.make_exporter(format)
    return exporter.write(opened.export_job(), folder / f"{opened.name}{exporter.suffix}")


def _hull(opened: "Opened") -> float:
    from driftform.geometry import hull_volume

    return hull_volume(opened.agent.body)


def _stated(written: "Sequence[WrittenFile]") -> float | None:
    """Volume (m3) that exporters say their files hold, ``None`` where they do not."""
    volumes = [v for file in written if isinstance(v := file.facts.get("volume_mm3"), float)]
    return sum(volumes) / MM_PER_M**3 if len(volumes) == len(written) else None


def _attached(path: Path, ending: str, folder: Path) -> Path | None:
    """A copy of the file in an archive, such as 3MF is one, whose name ends so; ``None`` where there is none."""
    import zipfile

    if not zipfile.is_zipfile(path):
        return None
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            if member.filename.endswith(ending) and member.file_size < 1 << 26:
                copy = folder / f"attached{ending}"
                copy.write_bytes(archive.read(member))
                return copy
    return None


def _findings(job: "PrintJob", study: "Study", programs: bool) -> "Iterator[Finding]":
    """What each checker finds; those that need no program come first."""
    import sys

    from driftform.interfaces import Checker
    from driftform.registry import registry
    from driftform.types import Finding, State

    found = [
        (row, row.cls if row.cls is not None and issubclass(row.cls, Checker) else None)
        for row in registry().seam("checker")
    ]
    for row, cls in sorted(found, key=lambda pair: bool(pair[1] and pair[1].program)):
        if cls is None:
            yield Finding(row.name, State.SKIPPED, row.state)
        elif cls.program and not programs:
            yield Finding(row.name, State.SKIPPED, "not asked, by --no-programs")
        else:
            if cls.program:
                print(f"asking {cls.program} ...", file=sys.stderr, flush=True)
            yield from study.make_checker(row.name).check(job)


def _print(findings: "Sequence[Finding]") -> None:
    from collections import Counter

    from driftform.cli.output import print_states
    from driftform.types import State

    print_states(
        [(str(f.state), f"{f.check}, {f.part}" if f.part else f.check, f.detail) for f in findings], STYLES
    )
    counts = Counter(f.state for f in findings)
    tally = ", ".join(f"{counts[state]} {state}" for state in State if counts[state])
    failed = [f.check for f in findings if f.state is State.FAIL]
    print(
        f"\nnot printable as it is, for {', '.join(dict.fromkeys(failed))}: {tally}"
        if failed
        else f"\nprintable: {tally}"
    )
