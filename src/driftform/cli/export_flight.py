"""``driftform export-flight``."""

from pathlib import Path
from types import SimpleNamespace

import typer

from driftform.cli.options import FILE, declare


@declare(FILE, *("agent", "format", "scenario", "simulator", "hydrodynamics", "rate_hz", "out", "settings", "json"))
def export_flight(given: SimpleNamespace) -> None:
    """Simulate one flight and write its samples for other programs, such as Foxglove, RViz or pandas.

    Older files of the same name are replaced.
    """
    from driftform.cli.formats import parse_formats
    from driftform.cli.output import print_files, print_json
    from driftform.design.opening import open_agent
    from driftform.errors import WorkFailedError
    from driftform.motion.path.thinning import check_rate
    from driftform.util.files import make_directory

    names = parse_formats(given.format, "recorder", "csv")
    check_rate(given.rate_hz)
    design = open_agent(
        given.agent,
        given.scenario,
        given.settings or (),
        {"simulator": given.simulator, "hydrodynamics": given.hydrodynamics},
    )
    folder = make_directory(given.out or Path("flights") / design.name)
    trajectory = design.trace()
    for line in design.list_limits():
        typer.echo(f"warning: {line}", err=True)
    written = [
        file
        for name in names
        for file in design.record_files(
            name,
            folder / f"{design.name}{design.study.make_recorder(name).suffix}",
            rate_hz=given.rate_hz,
            trajectory=trajectory,
        )
    ]
    if given.json:
        print_json(
            {
                "agent": design.name,
                "simulator": design.pipeline.simulator.name,
                "end": {
                    "t": trajectory.t[-1],
                    "position": list(trajectory.position[-1]),
                    "reason": str(trajectory.end),
                },
                "samples": written[0].facts.get("samples", len(trajectory.t)),
                "files": [{"format": w.format, "path": w.path, **w.facts} for w in written],
            }
        )
    else:
        print_files(written, folder)
    if trajectory.failure is not None:
        raise WorkFailedError(f"{design.name}: {trajectory.failure}; the files hold the flight until then")
