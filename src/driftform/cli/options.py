"""Options of commands: those that several share as annotations (``json: Json = False`` is ``--json``), others as rows of TOML files."""

import tomllib
from collections.abc import Callable
from inspect import Parameter, Signature
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, TypeAlias

import typer

from driftform.cli.complete import complete_plugin, complete_run, complete_setting, complete_study


def make_option(
    metavar: str, help: str, *names: str, complete: Callable[[str], list[str]] | None = None, **more: Any
) -> Any:
    """Return an option that takes a value, to be written into an ``Annotated``; ``more`` is as ``typer.Option`` has it."""
    return typer.Option(*names, metavar=metavar, help=help, autocompletion=complete, **more)


AGENT_HELP = (
    "An agent.json, RUN:TARGET (best agent of a run for a target), a neutral sphere such as sphere:40mm, or a genome such as "
    '"addB-tiltn-1-M-moveB-addB-tiltp-1-L-moveB".'
)
"""How an agent is named in a command."""

Agent: TypeAlias = Annotated[str, typer.Argument(metavar="AGENT", help=AGENT_HELP)]
RunArgument: TypeAlias = Annotated[
    Path, typer.Argument(metavar="RUN", help="A run directory.", autocompletion=complete_run)
]
Json: TypeAlias = Annotated[bool, typer.Option("--json", help="Print only one JSON document on stdout.")]
Settings: TypeAlias = Annotated[
    list[str] | None,
    make_option(
        "KEY=VALUE", "Set any key of the study, such as flow.speed=0.8; repeatable.", "--set", complete=complete_setting
    ),
]
ScenarioOption: TypeAlias = Annotated[
    str | None, make_option("NAME|FILE", "Scenario of the flight; by default the agent's own.", complete=complete_study)
]
Simulator: TypeAlias = Annotated[
    str | None, make_option("NAME", "Simulator to use.", complete=complete_plugin("simulator"))
]
Hydrodynamics: TypeAlias = Annotated[
    str | None, make_option("NAME", "Hydrodynamic model to use.", complete=complete_plugin("hydrodynamics"))
]
GrammarName: TypeAlias = Annotated[
    str | None, make_option("NAME", "Grammar to use.", complete=complete_plugin("grammar"))
]
FitnessName: TypeAlias = Annotated[
    str | None, make_option("NAME", "Fitness to use.", complete=complete_plugin("fitness"))
]
StrategyName: TypeAlias = Annotated[
    str | None, make_option("NAME", "Search strategy to use.", complete=complete_plugin("strategy"))
]
StudyName: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="STUDY", help="A study file, or the name of a built-in scenario.", autocompletion=complete_study
    ),
]
Bed: TypeAlias = Annotated[
    str | None, make_option("X,Y,Z", "Largest part that the printer can make, mm; larger hulls are cut.")
]
ExporterOptions: TypeAlias = Annotated[
    list[str] | None,
    make_option(
        "KEY=VALUE|FILE",
        "Set an option of all formats, such as joint=rabbet, or all options in a file such as printer.toml; "
        "repeatable.",
    ),
]
Film: TypeAlias = Annotated[
    Path | None,
    make_option("FILE", "File for a film of the flight; its suffix, such as .mp4 or .gif, sets the format."),
]
Still: TypeAlias = Annotated[
    Path | None,
    make_option("FILE", "File for a picture of the flight in 3D; its suffix, such as .png, sets the format."),
]
StillAt: TypeAlias = Annotated[
    float | None,
    make_option(
        "SECONDS", "Time of the still after the release, s; by default that of the closest approach to any target."
    ),
]
Renderer: TypeAlias = Annotated[
    str, make_option("NAME", "Renderer of the film and the still.", complete=complete_plugin("renderer"))
]
Robust: TypeAlias = Annotated[
    int | None,
    make_option(
        "N", "Number of flights under disturbed conditions, which [robustness] of the study defines.", min=0, max=10_000
    ),
]
Style: TypeAlias = Annotated[
    str,
    make_option(
        "screen|paper",
        "Style of pictures: screen has titles; paper is for publications, SVG and PDF with text of 8 pt.",
    ),
]
WidthMm: TypeAlias = Annotated[
    float | None, make_option("MM", "Width of figures with --style paper, mm; by default 180.", min=60, max=300)
]
MAX_WORKERS = 1024
"""Largest number of worker processes on one machine."""

Workers: TypeAlias = Annotated[
    int | None, make_option("N", "Number of worker processes; by default one per processor.", min=1, max=MAX_WORKERS)
]
Scheduler: TypeAlias = Annotated[
    str | None,
    make_option(
        "ADDRESS",
        "Dask scheduler whose workers evaluate, such as tcp://host:8786; by default processes on this machine do.",
    ),
]
FlightDirectory: TypeAlias = Annotated[
    Path | None, make_option("DIR", "Directory for the files; by default flights/AGENT.")
]

_SHARED: dict[str, tuple[Any, Any]] = {
    "agent": (Agent, Parameter.empty),
    "scenario": (ScenarioOption, None),
    "simulator": (Simulator, None),
    "hydrodynamics": (Hydrodynamics, None),
    "settings": (Settings, None),
    "bed": (Bed, None),
    "option": (ExporterOptions, None),
    "workers": (Workers, None),
    "scheduler": (Scheduler, None),
    "style": (Style, "screen"),
    "width_mm": (WidthMm, None),
    "json": (Json, False),
}
"""Options that all commands share: annotation and default."""

_TYPES: dict[str, Any] = {
    "argument": str,
    "argument_path": Path,
    "argument_texts": list[str],
    "arguments": list[Path],
    "text": str,
    "texts": list[str],
    "path": Path,
    "number": float,
    "signed": float,
    "numbers": list[float],
    "pair": tuple[float, float],
    "size": tuple[float, float, float],
    "count": int,
    "switch": bool,
}


def declare(file: Path, *names: str) -> Callable[[Callable[[SimpleNamespace], None]], Callable[..., None]]:
    """Return a decorator that makes a command, with these options of a file, of a function that takes their values by name."""
    rows = tomllib.loads(file.read_text(encoding="utf-8"))

    def make(run: Callable[[SimpleNamespace], None]) -> Callable[..., None]:
        def command(**values: Any) -> None:
            run(SimpleNamespace(**values))

        command.__name__, command.__module__, command.__doc__ = run.__name__, run.__module__, run.__doc__
        command.__signature__ = Signature([_declare_option(name, rows) for name in names])  # type: ignore[attr-defined]
        return command

    return make


def _declare_option(name: str, rows: dict[str, dict[str, Any]]) -> Parameter:
    """Return the parameter of an option of a file, or of one that all commands share."""
    if name not in rows:
        annotation, default = _SHARED[name]
        return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
    option = rows[name]
    kind, flag = option["type"], option.get("flag", f"--{name.replace('_', '-')}")
    shown: dict[str, Any] = {key: option[key] for key in ("help", "metavar", "max") if key in option}
    if kind in ("number", "numbers", "count") and "signed" not in option:
        shown["min"] = option.get("min", 0)
    default = option.get("default", False if kind == "switch" and "/" not in flag else None)
    is_argument = kind.startswith("argument")
    is_required = is_argument or option.get("required") or (kind == "text" and default is None)
    if is_required and not option.get("optional"):
        default = Parameter.empty
    default = tuple(default) if kind == "size" else default
    taken = _TYPES[kind] if default is not None else _TYPES[kind] | None
    declared = typer.Argument(**shown) if is_argument else typer.Option(flag, **shown)
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[taken, declared])
