"""Runs EPANET on a network file, in a process of its own, and reads what it says."""

import json
import re
import subprocess
import sys
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Timer

from driftform.errors import InputError
from driftform.util import files
from driftform.util.progress import track_progress
from driftform_networks.cache import Arrays, load_arrays

PATIENCE_S = 300.0
"""Longest time for a percent of a simulation, s."""

_ENGINE = "driftform_networks.engine"
_BEYOND = re.compile(r"[-+]?(nan|inf|infinity|\d[\d.]*e\+?\d\d+)", re.IGNORECASE)
"""Numbers that no network has."""


@dataclass(frozen=True)
class Changes:
    """Changes to the model of a network, without editing its file.

    Attributes
    ----------
    close
        links that are closed at all hours.
    open
        litres/s that are drawn at junctions besides their demand, such as at open hydrants.
    valves
        ``"open"``, ``"closed"``, or the setting of valves at all hours: metres of water for PRV, PSV and PBV, litres/s for FCV,
        the loss coefficient of TCV, percent for PCV.
    """

    close: tuple[str, ...] = ()
    open: Mapping[str, float] = field(default_factory=dict)
    valves: Mapping[str, float | str] = field(default_factory=dict)

    @classmethod
    def parse(cls, close: Sequence[str], open: Sequence[str], valves: Sequence[str]) -> "Changes":
        """Return what ``--close PIPE``, ``--open NODE=LPS`` and ``--set-valve V=SETTING`` say.

        Raises
        ------
        InputError
            if a value is missing or no number.
        """
        settings = dict(split_option("--set-valve", text, ("open", "closed")) for text in valves)
        drawn = {name: float(value) for name, value in (split_option("--open", text) for text in open)}
        return cls(tuple(close), drawn, settings)


def split_option(option: str, text: str, words: Sequence[str] = ()) -> tuple[str, float | str]:
    """Return name and value of ``NAME=VALUE``, a number of at least 0 or one of some words.

    Raises
    ------
    InputError
        if it is neither.
    """
    name, equals, value = text.rpartition("=")
    if value in words and equals:
        return name, value
    try:
        number = float(value)
    except ValueError:
        number = -1.0
    if not equals or not 0 <= number < 1e9:
        raise InputError(
            f"{option} {text}: expected NAME=VALUE, the value {' or '.join(('a number', *words))}"
        )
    return name, number


def run_epanet(path: Path, changes: Changes | None = None) -> Arrays:
    """Return what EPANET says of a file: the arrays of :mod:`driftform_networks.engine`.

    EPANET reads a copy in a temporary folder, in UTF-8, and leaves nothing behind.

    Raises
    ------
    InputError
        if EPANET refuses the file, cannot solve it, or breaks down; the message has EPANET's own words, and the number of
        the line that it quotes.
    """
    text = files.read_text(path)
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "network.inp").write_text(text, "utf-8", newline="\n")
        (folder / "changes.json").write_text(json.dumps(asdict(changes or Changes())), "utf-8")
        command = [sys.executable, "-m", _ENGINE, name]
        with subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        ) as child:
            try:
                deque(track_progress(_watch(child), 100, "% of the simulation by EPANET"), maxlen=0)
            finally:
                child.kill()
        refused, report = folder / "refused.json", folder / "network.rpt"
        if refused.is_file():
            said = _read_errors(report, text) or [
                f"{line}{_find_suspect(text)}" for line in json.loads(refused.read_text("utf-8"))
            ]
            more = f" (and {len(said) - 1} more faults)" if len(said) > 1 else ""
            raise InputError(f"{path}: EPANET refuses the file: {said[0]}{more}")
        if (arrays := load_arrays(folder / "result.npz")) is None:
            raise InputError(
                f"{path}: EPANET breaks down on the file{_find_suspect(text)}: open it in EPANET, and correct what it marks"
            )
        return arrays


def _watch(child: "subprocess.Popen[str]") -> Iterator[str]:
    """Yield a line for each percent of the simulation; end the child if one of them takes too long."""
    assert child.stdout is not None
    while True:
        timer = Timer(PATIENCE_S, child.kill)
        timer.start()
        try:
            line = child.stdout.readline()
        finally:
            timer.cancel()
        if not line:
            break
        yield line
    child.wait(timeout=PATIENCE_S)


def _read_errors(report: Path, text: str) -> list[str]:
    """Return the errors in EPANET's report, one line each, with the number of the line of the file that it quotes."""
    if not report.is_file():
        return []
    numbers = {
        " ".join(line.split()): number for number, line in reversed(list(enumerate(text.splitlines(), 1)))
    }
    lines = [line.strip() for line in report.read_text("utf-8", errors="replace").splitlines()]
    found = list[str]()
    for line, following in zip(lines, [*lines[1:], ""], strict=False):
        if line.startswith("Error ") and not line.startswith("Error 200"):
            quote = " ".join(following.split()) if line.endswith(":") else ""
            where = f"line {numbers[quote]}: " if quote in numbers else ""
            found.append(f"{where}{line}{quote and ' '}{quote}")
    return list(dict.fromkeys(found))


def _find_suspect(text: str) -> str:
    """Return the first line with a name or number that EPANET cannot hold, as part of a message; empty if there is none."""
    for number, line in enumerate(text.splitlines(), 1):
        for word in line.partition(";")[0].split():
            if len(word.encode()) > 31 or _BEYOND.fullmatch(word):
                shown = word if len(word) < 40 else f"{word[:12]}... of {len(word)} letters"
                return f", perhaps by line {number}: {shown} (names have at most 31 bytes)"
    return ""
