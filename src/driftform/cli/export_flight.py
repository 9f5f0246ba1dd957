"""``driftform export-flight``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import (
    Agent,
    FlightDirectory,
    Hydrodynamics,
    Json,
    ScenarioOption,
    Settings,
    Simulator,
    make_option,
)


def export_flight(
    agent: Agent,
    format: Annotated[str, make_option("NAME[,NAME...]", "Recorders, as 'driftform plugins' lists them.")] = "csv",
    scenario: ScenarioOption = None,
    simulator: Simulator = None,
    hydrodynamics: Hydrodynamics = None,
    rate_hz: Annotated[
        float, make_option("HZ", "Samples per second of flight; 0 for the simulator's own samples.")
    ] = 100.0,
    out: FlightDirectory = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Simulate one flight and write its samples for other programs, such as Foxglove, RViz or pandas.

    Older files of the same name are replaced.
    """
    from driftform.cli.formats import parse_formats
    from driftform.cli.output import print_files, print_json
    from driftform.design.opening import open_agent
    from driftform.errors import WorkFailedError
    from driftform.motion.path.thinning import check_rate
    from driftform.util.files import make_directory

    names = parse_formats(format, "recorder", "csv")
    check_rate(rate_hz)
    design = open_agent(agent, scenario, settings or (), {"simulator": simulator, "hydrodynamics": hydrodynamics})
    folder = make_directory(out or Path("flights") / design.name)
    trajectory = design.trace()
    for line in design.list_limits():
        typer.echo(f"warning: {line}", err=True)
    written = [
        file
        for name in names
        for file in design.record_files(
            name,
            folder / f"{design.name}{design.study.make_recorder(name).suffix}",
            rate_hz=rate_hz,
            trajectory=trajectory,
        )
    ]
    if json:
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
