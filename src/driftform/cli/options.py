"""Options of commands, each a row of a TOML file: those that commands share in options.toml, those of a plugin in a file of its own."""

import tomllib
from collections.abc import Callable
from functools import cache
from inspect import Parameter, Signature
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, TypeAlias

import typer

from driftform.cli.complete import complete_plugin, complete_run, complete_setting, complete_study

FILE = Path(__file__).with_name("options.toml")
"""The options that commands share, and those of the commands of driftform itself."""

_TYPES: dict[str, Any] = {
    "argument": str,
    "argument_path": Path,
    "argument_number": float,
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

_COMPLETIONS = {"study": complete_study, "run": complete_run, "setting": complete_setting}
"""What a shell completes, besides names of plugins."""


@cache
def _read_rows(file: Path) -> dict[str, dict[str, Any]]:
    return tomllib.loads(file.read_text(encoding="utf-8"))


def declare(file: Path, *names: str) -> Callable[[Callable[[SimpleNamespace], None]], Callable[..., None]]:
    """Return a decorator that makes a command, with these options of a file, of a function that takes their values by name.

    Rows below the name of the function come first, then those of the file, then those that all commands share.
    """

    def make(run: Callable[[SimpleNamespace], None]) -> Callable[..., None]:
        def command(**values: Any) -> None:
            run(SimpleNamespace(**values))

        shared, rows = _read_rows(FILE), _read_rows(file)
        own = rows.get(run.__name__, {})
        command.__name__, command.__module__, command.__doc__ = run.__name__, run.__module__, run.__doc__
        command.__signature__ = Signature(  # type: ignore[attr-defined]
            [_declare_option(name, own.get(name) or rows.get(name) or shared[name]) for name in names]
        )
        return command

    return make


def _declare_option(name: str, option: dict[str, Any]) -> Parameter:
    """Return the parameter of an option, by its row."""
    kind = option["type"]
    default: Any = option.get("default", False if kind == "switch" and "/" not in option.get("flag", "") else None)
    is_required = kind.startswith("argument") or option.get("required") or (kind == "text" and default is None)
    if is_required and not option.get("optional"):
        default = Parameter.empty
    default = tuple(default) if kind == "size" else default
    taken = _TYPES[kind] if default is not None else _TYPES[kind] | None
    return Parameter(
        name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[taken, _describe_option(name, option)]
    )


def _describe_option(name: str, option: dict[str, Any]) -> Any:
    """Return an option as typer takes it."""
    kind = option["type"]
    shown: dict[str, Any] = {key: option[key] for key in ("help", "metavar", "max") if key in option}
    if kind in ("number", "numbers", "count") and "signed" not in option:
        shown["min"] = option.get("min", 0)
    if (word := option.get("complete")) is not None:
        shown["autocompletion"] = _COMPLETIONS.get(word) or complete_plugin(word)
    if kind.startswith("argument"):
        return typer.Argument(**shown)
    return typer.Option(option.get("flag", f"--{name.replace('_', '-')}"), **shown)


def _share(name: str) -> Any:
    return _describe_option(name, _read_rows(FILE)[name])


Agent: TypeAlias = Annotated[str, _share("agent")]
"""An agent, as all commands take it."""
RunArgument: TypeAlias = Annotated[Path, _share("run")]
"""The directory of a run."""
Settings: TypeAlias = Annotated[list[str] | None, _share("settings")]
"""The option ``--set``; ``None`` by default."""
Json: TypeAlias = Annotated[bool, _share("json")]
"""The option ``--json``; ``False`` by default."""
