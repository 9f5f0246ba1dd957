"""``driftform export-flight``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import Agent, Hydrodynamics, Json, ScenarioOption, Settings, Simulator

MOST = 10_000.0
"""Highest rate of samples, 1/s: a flight of 20 s has then two hundred thousand of them."""


def export_flight(
    agent: Agent,
    format: Annotated[
        str, typer.Option("--format", metavar="NAME[,NAME...]", help="Recorders, see 'driftform plugins'.")
    ] = "csv",
    scenario: ScenarioOption = None,
    simulator: Simulator = None,
    hydrodynamics: Hydrodynamics = None,
    rate_hz: Annotated[
        float,
        typer.Option(
            "--rate-hz",
            metavar="HZ",
            help="Samples for each second of the flight; 0 for those of the simulator.",
        ),
    ] = 100.0,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Directory for the files; by default flights/AGENT."),
    ] = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Fly one agent, and write its flight for other programs, such as Foxglove, RViz or pandas; an older file is replaced."""
    from driftform.agents.opening import open_agent
    from driftform.cli.output import print_json
    from driftform.errors import InputError, WorkFailedError
    from driftform.registry import registry
    from driftform.trajectory.resampling import resample
    from driftform.util.files import make_directory

    names = list(dict.fromkeys(name.strip() for name in format.split(",") if name.strip()))
    if not names:
        raise InputError("--format is empty; name at least one, such as csv")
    for name in names:
        try:
            registry().find("recorder", name)
        except InputError as error:
            raise InputError(f"--format {name}: {error}") from None
    if not 0 <= rate_hz <= MOST:
        raise InputError(f"--rate-hz {rate_hz:g}: should be from 0 to {MOST:g}")
    opened = open_agent(
        agent, scenario, settings or (), {"simulator": simulator, "hydrodynamics": hydrodynamics}
    )
    folder = make_directory(out or Path("flights") / opened.name)
    flight = opened.fly()
    if rate_hz:
        flight = resample(flight, rate_hz)
    job = opened.export_job()
    recorders = [opened.study.make_recorder(name) for name in names]
    written = [
        file
        for recorder in recorders
        for file in recorder.write(job, flight, folder / f"{opened.name}{recorder.suffix}")
    ]
    if json:
        print_json(
            {
                "agent": opened.name,
                "simulator": opened.pipeline.simulator.name,
                "end": {
                    "t": flight.t[-1],
                    "position": list(flight.position[-1]),
                    "reason": str(flight.end),
                },
                "samples": len(flight.t),
                "files": [{"format": w.format, "path": w.path, **w.facts} for w in written],
            }
        )
    else:
        for w in written:
            facts = ", ".join(
                f"{key} {value:.6g}" if isinstance(value, float) else f"{key} {value}"
                for key, value in w.facts.items()
                if not isinstance(value, dict)
            )
            print(f"{w.path}: {facts}" if facts else w.path)
    if flight.end.failed:
        raise WorkFailedError(
            f"{opened.name}: the flight ended after {flight.t[-1]:.3g} s: {flight.end}; "
            "the files hold what there is of it"
        )
