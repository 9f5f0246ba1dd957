"""Options for several exporters at once, as settings of a study: a kit that fits a printer."""

import json
import shlex
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from driftform.errors import InputError, did_you_mean
from driftform.interfaces import Printer
from driftform.options import Table
from driftform.plugins.registry import registry

KIT_FILE = "kit.json"
"""Name of the attachment of a 3MF file that holds the options of its kit, as JSON."""


def list_exporter_settings(formats: Iterable[str], options: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the settings that give each exporter the same options.

    Parameters
    ----------
    formats
        names of exporters that are installed.
    options
        for each key its value as a setting has it, and how the user asked for it.

    Raises
    ------
    InputError
        if an exporter has no such option; the message names those that have it.
    """
    settings = []
    for name in formats:
        fields = registry().find("exporter", name).Options.model_fields
        for key, (value, asked) in options.items():
            if key not in fields:
                having = [
                    row.name
                    for row in registry().seam("exporter")
                    if row.cls is not None and key in row.cls.Options.model_fields
                ]
                known = did_you_mean(key, fields) or (f"; {', '.join(having)} have it" if having else "")
                raise InputError(f"{asked}: exporter '{name}' has no option '{key}'{known}")
            settings.append(f"exporter.{name}.{key}={value}")
    return settings


def list_kit_settings(formats: Iterable[str], printer: Printer) -> list[str]:
    """Return the settings that make exporters write a kit that fits a printer.

    Raises
    ------
    InputError
        if an exporter writes no kits.
    """
    options = {"kit": "true", "nozzle": repr(printer.nozzle), "bed": repr(list(printer.bed))}
    return list_exporter_settings(formats, {key: (value, "--kit") for key, value in options.items()})


def read_kit_settings(path: Path, label: str, format: str) -> list[str]:
    """Return the settings that make an exporter write the kit whose options a file has, which may be a stranger's.

    Parameters
    ----------
    path
        of the file with the options.
    label
        names it in errors.
    format
        name of the exporter.

    Raises
    ------
    InputError
        if the file does not hold options of this exporter, or the exporter writes no kits.
    """
    list_kit_settings([format], Printer())
    try:
        options = registry().find("exporter", format).Options.model_validate(json.loads(path.read_bytes()))
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
    return [
        f"exporter.{format}.{key}={json.dumps(value)}"
        for key, value in options.model_dump(mode="json").items()
    ]


def list_arguments(formats: Iterable[str], options: Table) -> str:
    """Return the arguments that make ``driftform export`` or ``trim`` use these exporters with options other than the defaults."""
    made = options.model_dump(mode="json", exclude_defaults=True)
    words = ["--kit"] if made.pop("kit", False) else []
    if (names := ",".join(formats)) != "stl":
        words += ["--format", names]
    if bed := made.pop("bed", None):
        words += ["--bed", ",".join(f"{1000 * side:.10g}" for side in bed)]
    for key, value in made.items():
        words += ["--option", f"{key}={_write_value(value)}"]
    return shlex.join(words)


def _write_value(value: Any) -> str:
    """A value as a setting has it: text without quotes, unless it would be read as another value."""
    written = json.dumps(value, separators=(",", ":"))
    if not isinstance(value, str) or value != value.strip():
        return written
    try:
        tomllib.loads(f"value = {value}")
    except ValueError:
        return value
    return written
