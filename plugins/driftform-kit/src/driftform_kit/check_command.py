"""``driftform check``."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from driftform.cli import options

if TYPE_CHECKING:
    from driftform.types import Finding


def check(
    subject: Annotated[
        str,
        typer.Argument(
            metavar="FILE|AGENT",
            help="A printable file (.stl, .3mf, .obj, .ply, .glb, .scad), or an agent, whose files are written and "
            f"checked. {options.AGENT_HELP}",
        ),
    ],
    agent: Annotated[
        str | None,
        typer.Option(metavar="AGENT", help="Agent of a FILE; by default the agent.json in the file or in its folder."),
    ] = None,
    nozzle: Annotated[
        float | None, typer.Option(metavar="MM", help="Diameter of the nozzle, mm; by default 0.4.")
    ] = None,
    bed: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z",
            help="Largest part that the printer can make, mm; by default 250,210,210. Without --nozzle and --bed a 3MF file "
            "of a kit is checked for the printer that it was made for.",
        ),
    ] = None,
    format: Annotated[str, typer.Option(metavar="NAME", help="Format that an AGENT is exported to.")] = "stl",
    kit: Annotated[
        bool,
        typer.Option(
            "--kit",
            help="Check the kit that fits nozzle and bed instead of the hull in one piece; a 3MF file of a kit has its own "
            "options.",
        ),
    ] = False,
    programs: Annotated[
        bool, typer.Option("--programs/--no-programs", help="Run OpenSCAD, a slicer and the like, if they are on PATH.")
    ] = True,
    settings: options.Settings = None,
    json: options.Json = False,
) -> None:
    """Check whether files can be printed and are what was simulated; exit code 1 if a check fails."""
    from driftform import open_agent
    from driftform.cli import formats, output
    from driftform.errors import InputError
    from driftform.interfaces import Printer
    from driftform.types import State
    from driftform.util import files
    from driftform_kit.check import check_design, check_file

    printer = None
    if nozzle is not None:
        if not 0 < nozzle <= 10:
            raise InputError(f"--nozzle {nozzle:g}: should be a diameter in mm, such as 0.4")
        printer = Printer(nozzle / 1000)
    if bed is not None:
        printer = replace(printer or Printer(), bed=formats.parse_bed(bed))

    def announce(program: str) -> None:
        print(f"running {program} ...", file=sys.stderr, flush=True)

    path = Path(subject)
    if files.is_file(path) and path.suffix.lower() != ".json":
        given = settings or ()
        findings = check_file(path, agent, given, printer=printer, kit=kit, programs=programs, on_program=announce)
    elif agent is not None:
        raise InputError(f"--agent {agent}: goes with a FILE, and '{subject}' is not one")
    else:
        [format] = formats.parse_formats(format, "exporter", "stl")
        design = open_agent(subject, *(settings or ()))
        findings = check_design(design, format, printer=printer, kit=kit, programs=programs, on_program=announce)
    failed = any(finding.state is State.FAIL for finding in findings)
    if json:
        keys = ("check", "part", "state", "detail")
        lines = [{key: getattr(finding, key) for key in keys} for finding in findings]
        output.print_json({"subject": subject, "printable": not failed, "lines": lines})
    else:
        _print(findings)
    if failed:
        raise typer.Exit(1)


def _print(findings: "Sequence[Finding]") -> None:
    """Print a line for each finding, and the verdict; the state ``fail`` is in capitals, so that it is seen."""
    from collections import Counter

    from driftform.cli import output
    from driftform.types import State

    rows = [
        ("FAIL" if f.state is State.FAIL else str(f.state), f"{f.check}, {f.part}" if f.part else f.check, f.detail)
        for f in findings
    ]
    output.print_table(("", "check", "found"), rows)
    counts = Counter(f.state for f in findings)
    tally = ", ".join(f"{counts[state]} {state}" for state in State if counts[state])
    failed = [f.check for f in findings if f.state is State.FAIL]
    verdict = f"not printable as it is, for {', '.join(dict.fromkeys(failed))}" if failed else "printable"
    print(f"\n{verdict}: {tally}")
