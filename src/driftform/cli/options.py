"""Options that several commands share, as annotations of parameters: ``json: Json = False`` is ``--json``."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer

from driftform.cli.complete import complete_plugin, complete_run, complete_setting, complete_study


def _name(metavar: str, help: str, complete: Callable[[str], list[str]]) -> Any:
    return typer.Option(metavar=metavar, help=help, autocompletion=complete)


AGENT_HELP = (
    "An agent.json, RUN:TARGET (the best of a run for a target), or a word such as "
    '"addB-tiltn-1-M-moveB-addB-tiltp-1-L-moveB".'
)
"""How an agent is named in a command."""

Agent: TypeAlias = Annotated[str, typer.Argument(metavar="AGENT", help=AGENT_HELP)]
RunArgument: TypeAlias = Annotated[
    Path, typer.Argument(metavar="RUN", help="A run directory.", autocompletion=complete_run)
]
Json: TypeAlias = Annotated[bool, typer.Option("--json", help="Print one JSON document, and nothing else, on stdout.")]
Settings: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Set any key of the study, such as flow.speed=0.8; repeatable.",
        autocompletion=complete_setting,
    ),
]
ScenarioOption: TypeAlias = Annotated[
    str | None, _name("NAME|FILE", help="Scenario to fly in, in place of the agent's own.", complete=complete_study)
]
Simulator: TypeAlias = Annotated[
    str | None, _name("NAME", help="Simulator to use.", complete=complete_plugin("simulator"))
]
Hydrodynamics: TypeAlias = Annotated[
    str | None, _name("NAME", help="Hydrodynamic model to use.", complete=complete_plugin("hydrodynamics"))
]
StrategyName: TypeAlias = Annotated[
    str | None, _name("NAME", help="Search strategy to use.", complete=complete_plugin("strategy"))
]
StudyName: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="STUDY", help="A study file, or the name of a built-in scenario.", autocompletion=complete_study
    ),
]
Bed: TypeAlias = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="Largest part that the printer can make, mm; longer ones are cut.")
]
ExporterOptions: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=VALUE|FILE",
        help="Set an option of every format at once, such as joint=rabbet, or those that a file such as printer.toml has; "
        "repeatable.",
    ),
]
Film: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE", help="Film of the flight to make; its suffix, such as .mp4 or .gif, decides the format."
    ),
]
Still: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Picture of the flight to make, as a film has it; its suffix, such as .png, decides the format.",
    ),
]
StillAt: TypeAlias = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        help="Moment of the still, from the release; by default that of the closest approach to any target.",
    ),
]
Renderer: TypeAlias = Annotated[
    str, _name("NAME", help="Renderer to make the film or the still.", complete=complete_plugin("renderer"))
]
Robust: TypeAlias = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        min=0,
        max=10_000,
        help="Number of flights under disturbed conditions; [robustness] in the scenario says what varies.",
    ),
]
Style: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="screen|paper",
        help="Look of pictures: with titles, or as figures of a paper, as SVG and PDF, text of 8 pt.",
    ),
]
WidthMm: TypeAlias = Annotated[
    float | None,
    typer.Option(metavar="MM", min=60, max=300, help="Width of figures of --style paper; by default 180 mm."),
]
MAX_WORKERS = 1024
"""Most worker processes that one machine starts."""

Workers: TypeAlias = Annotated[
    int | None,
    typer.Option(metavar="N", min=1, max=MAX_WORKERS, help="Worker processes; by default one for each processor."),
]
ExecutorName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Where evaluations run: local, in processes on this machine (the default), or dask, on a Dask cluster.",
    ),
]
Scheduler: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Dask scheduler to join, such as tcp://host:8786; without it a cluster is started on this machine.",
    ),
]
OutDirectory: TypeAlias = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Directory for the files; by default runs/STUDY-N, or flights/AGENT.")
]
