"""``--format``, ``--bed``, ``--style`` and ``--option``: names of plugins, a printer's bed as slicers give it, options of exporters."""

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from driftform.design.design import Design
    from driftform.figures.style import Page
    from driftform.water.pipe import Vector

STYLES, DEFAULT_WIDTH_MM = ("screen", "paper"), 180.0
"""What ``--style`` takes, and how wide a figure of a paper is if ``--width-mm`` is not given: two columns."""

MM_PER_M = 1000.0
"""Files for printers are in millimetres."""


def parse_formats(text: str, seam: str, example: str) -> list[str]:
    """Read ``NAME[,NAME...]`` of ``--format``, each an installed plugin of a seam.

    Raises InputError if one of them is missing, or none is named.
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
    """Read ``X,Y,Z`` in mm as width, depth and height in m. Raises InputError if the text is something else."""
    from driftform.errors import InputError

    try:
        x, y, z = (float(side) for side in text.split(","))
    except ValueError:
        raise InputError(f"--bed {text}: should be three lengths in mm, such as 250,210,210") from None
    if not all(0 < side < 1e5 for side in (x, y, z)):
        raise InputError(f"--bed {text}: should be three lengths in mm above 0, such as 250,210,210")
    return x / MM_PER_M, y / MM_PER_M, z / MM_PER_M


def parse_page(style: str, width_mm: float | None) -> "Page":
    """Return the page of ``--style`` and ``--width-mm``. Raises InputError if these do not fit each other."""
    from driftform.errors import InputError, did_you_mean
    from driftform.figures.style import SCREEN, Page

    if style not in STYLES:
        raise InputError(f"--style {style}: no such style{did_you_mean(style, STYLES)}")
    if style != "paper":
        if width_mm is not None:
            raise InputError(f"--width-mm {width_mm:g}: pictures for the screen have no width in mm; add --style paper")
        return SCREEN
    try:
        import cairosvg  # noqa: F401
    except (ImportError, OSError):
        print("warning: figures are written as SVG alone; for PDF: pip install 'driftform[pdf]'", file=sys.stderr)
    return Page.find(DEFAULT_WIDTH_MM if width_mm is None else width_mm)


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

    Raises InputError if an option is not one of these exporters; the line names it as the user gave it.
    """
    from driftform.design.opening import open_agent
    from driftform.errors import InputError

    asked = _list_options(kit, bed, options)
    try:
        return open_agent(agent, scenario, [*settings, *list_exporter_settings(formats, asked)], use)
    except InputError as error:
        lines = list(error.args)
        for name, (key, (value, option)) in product(formats, asked.items()):
            lines = [line.replace(f"--set exporter.{name}.{key}={value}: ", f"{option}: ") for line in lines]
        raise InputError(*lines) from None


def list_exporter_settings(formats: Iterable[str], options: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the settings that give each exporter the same options.

    Args:
        formats: names of exporters that are installed.
        options: value of each key as in a setting, and the option of the user that gave it.

    Raises InputError if an exporter has no such option; the message names those that have it.
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
                known = f"; {', '.join(having)} have it" if having else did_you_mean(key, fields)
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
