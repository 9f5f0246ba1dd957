"""Options of kits as settings of a study, and as arguments of commands."""

import json
import shlex
from collections.abc import Iterable
from pathlib import Path

from pydantic import ValidationError

from driftform import Study
from driftform.cli import formats
from driftform.errors import InputError
from driftform.interfaces import Printer, Table


def list_kit_settings(names: Iterable[str], printer: Printer) -> list[str]:
    """Return the settings that make exporters write a kit that fits a printer.

    An InputError says which exporter writes no kits.
    """
    options = {"kit": "true", "nozzle": repr(printer.nozzle), "bed": repr(list(printer.bed))}
    return formats.list_exporter_settings(names, {key: (value, "--kit") for key, value in options.items()})


def read_kit_settings(path: Path, label: str, format: str) -> list[str]:
    """Return the settings that make an exporter write the kit with the options in a file, which is not trusted.

    The label names the file in errors.

    Raises InputError if the file does not hold options of this exporter, or the exporter writes no kits.
    """
    list_kit_settings([format], Printer())
    model = next(row.cls.Options for row in Study.list_plugins("exporter") if row.cls and row.name == format)
    try:
        options = model.model_validate(json.loads(path.read_bytes()))
    except RecursionError:
        raise InputError(f"{label}: is nested too deeply") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        reason = f"{place!r:.60}: {first['msg']}" if place else "it is not a table"
        raise InputError(f"{label}: does not hold the options of exporter '{format}': {reason}") from None
    except ValueError as error:
        raise InputError(f"{label}: is not JSON in UTF-8: {error}") from None
    # The values of an option are written alike in JSON and in TOML.
    return [f"exporter.{format}.{key}={json.dumps(value)}" for key, value in options.model_dump(mode="json").items()]


def list_arguments(names: Iterable[str], options: Table) -> str:
    """Return the arguments that make ``driftform export`` or ``trim`` use these exporters with options other than the defaults."""
    made = options.model_dump(mode="json", exclude_defaults=True)
    words = ["--kit"] if made.pop("kit", False) else []
    if (joined := ",".join(names)) != "stl":
        words += ["--format", joined]
    if bed := made.pop("bed", None):
        words += ["--bed", ",".join(f"{1000 * side:.10g}" for side in bed)]
    for key, value in made.items():
        # Text without quotes, as a setting has it.
        text = value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))
        words += ["--option", f"{key}={text}"]
    return shlex.join(words)
