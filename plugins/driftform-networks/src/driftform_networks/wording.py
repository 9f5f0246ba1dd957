"""Words of the command line: hours, durations, and names of nodes."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from driftform.errors import InputError
from driftform.util import files

if TYPE_CHECKING:
    from driftform_networks.hydraulics.network import Network

_UNITS = {"s": 1 / 3600, "min": 1 / 60, "h": 1.0, "d": 24.0}


def parse_time(option: str, text: str) -> float:
    """Return a duration in hours.

    Raises InputError if it is not a duration, or not positive.

    >>> parse_time("--within", "90min"), parse_time("--within", "8h"), parse_time("--within", "8")
    (1.5, 8.0, 8.0)
    """
    found = re.fullmatch(r"(\d+\.?\d*) ?(s|min|h|d)?", text.strip())
    hours = float(found[1]) * _UNITS[found[2] or "h"] if found else 0.0
    if not 0 < hours < 1e6:
        raise InputError(f"{option} {text}: expected a time such as 8h, 90min or 2d")
    return hours


def parse_hours(text: str) -> list[float]:
    """Return hours that ``6-18``, ``6-18/2`` or ``6,12.5`` names, in order.

    Raises InputError if it names none, or more than a thousand.

    >>> parse_hours("6-8,12.5"), parse_hours("0-24/12")
    ([6.0, 7.0, 8.0, 12.5], [0.0, 12.0, 24.0])
    """
    hours = set[float]()
    for part in text.split(","):
        found = re.fullmatch(r" *(\d+\.?\d*)(?:-(\d+\.?\d*)(?:/(\d+\.?\d*))?)? *", part)
        first, last, step = (
            (float(found[i] or (found[1], found[1], 1)[i - 1]) for i in (1, 2, 3)) if found else (0, -1, 1)
        )
        count = (last - first) / step if step > 0 else -1
        if not 0 <= count < 1000:
            raise InputError(f"--hours {text}: expected hours such as 6-18, 6-18/2 or 6,12")
        hours |= {first + step * number for number in range(int(count + 1e-9) + 1)}
    return sorted(hours)


def split_names(texts: Iterable[str], network: "Network", option: str = "--release") -> list[str]:
    """Return the nodes of options, which commas separate, each once. Raises InputError if there is no such node."""
    names = [name.strip() for text in texts for name in ([text] if text in network.nodes else text.split(","))]
    for name in names:
        network.find_node(name, option)
    return list(dict.fromkeys(names))


def read_names(path: Path, network: "Network") -> list[str]:
    """Return the nodes that a text names at the begin of its lines; a first line that names none is a heading.

    Raises InputError if the file cannot be read, or another line names no node.
    """
    found = list[str]()
    for number, line in enumerate(files.read_text(path).splitlines(), 1):
        name = re.split(r"[,;\t]", line)[0].strip().strip('"')
        if not name or name.startswith("#") or (number == 1 and name not in network.nodes):
            continue
        if name not in network.nodes:
            raise InputError(f"{path}: line {number}: {network.name} has no node {name!r}")
        found.append(name)
    if not found:
        raise InputError(f"{path}: names no node of {network.name}: expected one on each line")
    return list(dict.fromkeys(found))
