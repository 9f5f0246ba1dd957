"""``--format``, ``--bed`` and ``--option``: names of plugins, a printer's bed as slicers give it, options of exporters."""

import json
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from driftform.design.design import Design
    from driftform.water.pipe import Vector

MM_PER_M = 1000.0
"""Files for printers are in millimetres."""


def parse_formats(text: str, seam: str, example: str) -> list[str]:
    """Read ``NAME[,NAME...]`` of ``--format``, each an installed plugin of a seam.

    Raises:
        InputError: if one of them is missing, or none is named.
    """
    from driftform.errors import InputError
    from driftform.plugins.registry import registry

    names = list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise InputError(f"--format is empty; name at least one, such as {example}")
    for name in names:
        try:
            registry().find(seam, name)
        except InputError as error:
            raise InputError(f"--format {name}: {error}") from None
    return names


def parse_bed(text: str) -> "Vector":
    """Read ``X,Y,Z`` in mm as width, depth and height in m.

    Raises:
        InputError: if the text is something else.
    """
    from driftform.errors import InputError

    try:
        x, y, z = (float(side) for side in text.split(","))
    except ValueError:
        raise InputError(f"--bed {text}: should be three lengths in mm, such as 250,210,210") from None
    if not all(0 < side < 1e5 for side in (x, y, z)):
        raise InputError(f"--bed {text}: should be three lengths in mm above 0, such as 250,210,210")
    return x / MM_PER_M, y / MM_PER_M, z / MM_PER_M


def open_exported(
    agent: str,
    formats: Sequence[str],
    kit: bool,
    bed: str | None,
    options: Sequence[str],
    settings: Sequence[str],
    scenario: str | None = None,
    use: Mapping[str, str | None] | None = None,
) -> "Design":
    """Open an agent, with the options of its exporters that ``--kit``, ``--bed`` and ``--option`` give.

    Raises:
        InputError: if an option is not one of these exporters; the line names it as the user gave it.
    """
    from driftform.design.opening import open_agent
    from driftform.errors import InputError

    asked = _list_options(kit, bed, options)
    try:
        return open_agent(agent, scenario, [*settings, *list_exporter_settings(formats, asked)], use)
    except InputError as error:
        raise InputError(*(_name_option(line, formats, asked) for line in error.args)) from None


def list_exporter_settings(formats: Iterable[str], options: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the settings that give each exporter the same options.

    Args:
        formats: names of exporters that are installed.
        options: for each key its value as a setting has it, and how the user asked for it.

    Raises:
        InputError: if an exporter has no such option; the message names those that have it.
    """
    from driftform.errors import InputError, did_you_mean
    from driftform.plugins.registry import registry

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


def _list_options(kit: bool, bed: str | None, options: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Options for all formats: the value of each key, and how it was asked for."""
    from driftform.errors import InputError
    from driftform.study.sources import parse_text
    from driftform.util.files import read_text

    found = {"kit": ("true", "--kit")} if kit else {}
    if bed is not None:
        found["bed"] = (repr(list(parse_bed(bed))), f"--bed {bed}")
    for text in options:
        if text.endswith(".toml"):
            data = parse_text(f"--option {text}", read_text(Path(text))).data
            found |= {key: (json.dumps(value), f"--option {text}: {key}") for key, value in data.items()}
            continue
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise InputError(f"--option {text}: expected key=value, such as joint=rabbet")
        found[key.strip()] = (value, f"--option {text}")
    return found


def _name_option(line: str, formats: Sequence[str], options: Mapping[str, tuple[str, str]]) -> str:
    """An error about a setting of an exporter, as one about the option that it came from."""
    for name, (key, (value, asked)) in product(formats, options.items()):
        line = line.replace(f"--set exporter.{name}.{key}={value}: ", f"{asked}: ")
    return line
