"""Opens a network by the path of its EPANET file, or by the name of one that this package ships; EPANET runs in a process of its own."""

import hashlib
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from contextvars import copy_context
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Thread
from typing import Any

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.util import files, foreign, progress
from driftform_networks.cache import find_cache, hash_content, keep_result
from driftform_networks.hydraulics.engine import solve
from driftform_networks.hydraulics.network import Hydraulics, Network

SECONDS, MEMORY = 1800.0, 6 << 30
"""Most processor time, s, and memory, bytes, of EPANET."""

_BEYOND = re.compile(r"[-+]?(nan|inf|infinity|\d[\d.]*e\+?\d\d+)", re.IGNORECASE)
"""Numbers that no network has."""

_UNITS = re.compile(r"(?ims)^\s*\[OPTI(?:(?!^\s*\[).)*?^\s*UNITS\b")
_NO_UNITS = (
    "the file has no Units in [OPTIONS]: flows are GPM, lengths feet and bores inches; add a line such as Units LPS"
)

_FORMAT = 4
"""Increase it whenever a network is computed or stored differently."""


@dataclass(frozen=True)
class Changes:
    """Changes to the model of a network, without editing its file.

    Attributes:
        close: links that are closed at all hours.
        open: litres/s that are drawn at junctions besides their demand, such as at open hydrants.
        valves: ``"open"``, ``"closed"``, or the setting of valves at all hours: metres of water for PRV, PSV and PBV,
            litres/s for FCV, the loss coefficient of TCV, percent for PCV.
    """

    close: tuple[str, ...] = ()
    open: Mapping[str, float] = field(default_factory=dict)
    valves: Mapping[str, float | str] = field(default_factory=dict)

    @classmethod
    def parse(cls, close: Sequence[str], open: Sequence[str], valves: Sequence[str]) -> "Changes":
        """Return what ``--close PIPE``, ``--open NODE=LPS`` and ``--set-valve V=SETTING`` say.

        Raises InputError if a value is missing or not a number.
        """
        settings = dict(split_option("--set-valve", text, ("open", "closed")) for text in valves)
        drawn = {name: float(value) for name, value in (split_option("--open", text) for text in open)}
        return cls(tuple(close), drawn, settings)


def split_option(option: str, text: str, words: Sequence[str] = ()) -> tuple[str, float | str]:
    """Return name and value of ``NAME=VALUE``, a number of at least 0 or one of some words.

    Raises InputError if it is neither.
    """
    name, equals, value = text.rpartition("=")
    if value in words and equals:
        return name, value
    try:
        number = float(value)
    except ValueError:
        number = -1.0
    if not equals or not 0 <= number < 1e9:
        raise InputError(f"{option} {text}: expected NAME=VALUE, the value {' or '.join(('a number', *words))}")
    return name, number


def run_epanet(path: Path, changes: Changes | None = None) -> dict[str, Any]:
    """Return the results of EPANET for a file: the arrays of :mod:`driftform_networks.hydraulics.engine`.

    EPANET reads a copy in a temporary folder, in UTF-8, and leaves nothing behind.

    Raises InputError if EPANET refuses the file, cannot solve it, or breaks down; the message has EPANET's own words,
    and the number of the line that it quotes.
    """
    with TemporaryDirectory() as name:
        copy, content = Path(name) / "network.inp", path.read_bytes()
        # Zeros fill the last block of some files.
        copy.write_bytes(content.rstrip(b"\0"))
        text = files.read_text(copy if content.endswith(bytes(8)) else path)
        copy.write_text(text, "utf-8", newline="\n")
        stop, context = Event(), copy_context()
        shown = Thread(target=context.run, args=(_show_percent, copy.with_suffix(".percent"), stop), daemon=True)
        shown.start()
        try:
            values = asdict(changes or Changes())
            found: dict[str, Any] = foreign.call_apart(solve, copy, values, seconds=SECONDS, memory=MEMORY)
            if not _UNITS.search(text):
                warnings = found["hydraulics.warnings"].tolist()
                found["hydraulics.warnings"] = np.array([*warnings, _NO_UNITS], np.str_)
            return found
        except InputError as error:
            said = _read_errors(copy.with_suffix(".rpt"), text) or [
                f"{error}{_find_suspect(text, 'Error 200' in str(error))}"
            ]
            more = f" (and {len(said) - 1} more faults)" if len(said) > 1 else ""
            raise InputError(f"{path}: EPANET refuses the file: {said[0]}{more}") from None
        except ValueError as error:
            raise InputError(
                f"{path}: {error}{_find_suspect(text, True)}: open it in EPANET, and correct what it marks"
            ) from None
        finally:
            stop.set()
            shown.join()


def _show_percent(file: Path, stop: Event) -> None:
    """Show the percent of the simulation in a file until the work ends, if that takes longer than a second."""
    if stop.wait(1.0):
        return
    with progress.count_progress("% of the simulation by EPANET") as show:
        while not stop.wait(0.3):
            with suppress(OSError, ValueError):
                show(int(file.read_text("utf-8")), 100)


def _read_errors(report: Path, text: str) -> list[str]:
    """Return the errors in EPANET's report, one line each, with the number of the line of the file that it quotes."""
    if not report.is_file():
        return []
    numbers = {" ".join(line.split()): number for number, line in reversed(list(enumerate(text.splitlines(), 1)))}
    lines = [line.strip() for line in report.read_text("utf-8", errors="replace").splitlines()]
    found = list[str]()
    for line, following in zip(lines, [*lines[1:], ""], strict=False):
        if line.startswith("Error ") and not line.startswith("Error 200"):
            quote = " ".join(following.split()) if line.endswith(":") else ""
            where = f"line {numbers[quote]}: " if quote and quote in numbers else ""
            found.append(f"{where}{line}{quote and ' '}{quote}")
    return list(dict.fromkeys(found))


def _find_suspect(text: str, is_silent: bool) -> str:
    """Return the first line with a name or number that EPANET cannot hold, as part of a message; empty without such a line.

    EPANET ``is_silent`` if it names no line itself: then rules may be at fault.
    """
    for number, line in enumerate(text.splitlines(), 1):
        for word in line.partition(";")[0].split():
            if len(word.encode()) > 31 or _BEYOND.fullmatch(word):
                shown = word if len(word) < 40 else f"{word[:12]}... of {len(word)} letters"
                return f", perhaps by line {number}: {shown} (names have at most 31 bytes)"
    has_rules = is_silent and re.search(r"^\s*\[RULE", text, re.IGNORECASE | re.MULTILINE)
    return ", perhaps in [RULES], of which EPANET names no line: leave rules out to find it" if has_rules else ""


def open_network(source: str | Path, cache: Path | None = None, changes: Changes | None = None) -> Network:
    """Return a network with its flows; EPANET runs only if the cache does not hold them.

    Args:
        source: path of an EPANET file (.inp), or ``"Net3"``, an example of EPANET.
        cache: directory for results; ``None`` for the user's.
        changes: to the model of the file.

    Raises InputError if there is no such file, or EPANET refuses it.
    """
    path, text = Path(source), str(source)
    if not files.is_file(path):
        shipped = {file.stem: file for file in Path(__file__).with_name("examples").glob("*.inp")}
        if text not in shipped:
            known = did_you_mean(text, shipped)
            raise InputError(f"NET '{text}': no such file, and no network of that name comes with driftform{known}")
        path = shipped[text]
    content = [hashlib.sha256(path.read_bytes()).hexdigest(), _FORMAT, asdict(changes or Changes())]
    digest = hash_content({"network": content})
    stored = find_cache(cache) / f"{digest}.npz"

    def build(**found: Any) -> Network:
        is_text = {key: np.asarray(value).dtype.kind == "U" for key, value in found.items()}
        values: dict[str, Any] = {k: tuple(v.tolist()) if is_text[k] else v for k, v in found.items()}
        corners = np.split(values.pop("vertices"), np.cumsum(values.pop("counts"))[:-1])
        flows = {key: values.pop(f"hydraulics.{key}") for key in Hydraulics.__dataclass_fields__}
        return Network(path.stem, digest, vertices=tuple(corners), hydraulics=Hydraulics(**flows), **values)

    return keep_result(stored, build, lambda: run_epanet(path, changes))
