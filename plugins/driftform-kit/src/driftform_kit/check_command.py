"""``driftform check``."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace as Given
from typing import TYPE_CHECKING, Any

import typer

from driftform.cli import options

if TYPE_CHECKING:
    from driftform.types import Finding


@options.declare(
    Path(__file__).with_name("check.toml"),
    *("subject", "agent", "nozzle", "bed", "format", "kit", "programs", "settings", "json"),
)
def check(given: Given) -> None:
    """Check whether files can be printed and are what was simulated; exit code 1 if a check fails."""
    from driftform import open_agent
    from driftform.cli import formats, output
    from driftform.errors import InputError
    from driftform.interfaces import Printer
    from driftform.types import State
    from driftform.util import files
    from driftform_kit.check import check_design, check_file

    subject, agent, settings, printer = given.subject, given.agent, given.settings or (), None
    if given.nozzle is not None:
        if not 0 < given.nozzle <= 10:
            raise InputError(f"--nozzle {given.nozzle:g}: should be a diameter in mm, such as 0.4")
        printer = Printer(given.nozzle / 1000)
    if given.bed is not None:
        printer = replace(printer or Printer(), bed=formats.parse_bed(given.bed))

    def announce(program: str) -> None:
        print(f"running {program} ...", file=sys.stderr, flush=True)

    how: dict[str, Any] = {"kit": given.kit, "programs": given.programs, "printer": printer, "on_program": announce}
    path = Path(subject)
    if files.is_file(path) and path.suffix.lower() != ".json":
        findings = check_file(path, agent, settings, **how)
    elif agent is not None:
        raise InputError(f"--agent {agent}: goes with a FILE, and '{subject}' is not one")
    else:
        [format] = formats.parse_formats(given.format, "exporter", "stl")
        findings = check_design(open_agent(subject, *settings), format, **how)
    failed = any(finding.state is State.FAIL for finding in findings)
    if given.json:
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
