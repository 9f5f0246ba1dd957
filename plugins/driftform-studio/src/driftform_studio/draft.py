"""The draft that the page edits, as a study file and as a study."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tomli_w

from driftform import StoredAgent, Study, load_study
from driftform.errors import InputError, did_you_mean
from driftform.water import Scenario

_SEAMS = ("run", "strategy", "simulator", "hydrodynamics", "builder", "grammar", "fitness")
TABLES = (*Scenario.model_fields, *_SEAMS)
"""Tables that the page may set: none that names files or programs."""

WRITERS = ("exporter", "recorder", "renderer", "checker")
"""Tables of a study file for what is written of an agent; the page leaves them out."""

FILE = "study.toml"
"""Name of the study in errors."""


def check_draft(draft: Any) -> dict[str, Any]:
    """Return a draft if it consists of a built-in ``base``, a ``title`` and tables that the page may set.

    Raises InputError if it does not. Its base is never a file: the page reads no file but those of runs.
    """
    if not isinstance(draft, dict) or not all(isinstance(key, str) for key in draft):
        raise InputError(f"{FILE}: is not a table")
    scenarios = Study.list_scenarios()
    if not isinstance(base := draft.get("base"), str) or base not in scenarios:
        raise InputError(f"{FILE}: base = {base!r} is not a built-in scenario{did_you_mean(str(base), scenarios)}")
    for key in draft:
        if key not in ("base", "title", "description", *TABLES):
            raise InputError(f"{FILE}: the page cannot set '{key}'; save the study, and edit the file")
    return {key: _drop_nothing(draft[key]) for key in ("title", "description", "base", *TABLES) if key in draft}


def read_draft(text: str, name: str) -> dict[str, Any]:
    """Return the draft that the text of a study file holds, without what writes files; ``name`` is that of the file.

    Raises InputError if it is not TOML, or sets what the page cannot.
    """
    try:
        given = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{name}: is not a study file, which is TOML: {error}") from None
    return check_draft({"base": load_study().name, **{key: given[key] for key in given if key not in WRITERS}})


def read_agent(text: str, check: Callable[[dict[str, Any]], None]) -> tuple[StoredAgent, Study]:
    """Return the agent of a file's text as one that a run has picked, and the study of that run, by the usual strategy.

    ``check`` is called with its tables before any is read. Raises InputError if it is not the file of an agent.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "agent.json"
        path.write_text(text, encoding="utf-8")
        stored = StoredAgent.read(path)
    environment = {key: stored.environment[key] for key in TABLES if key in stored.environment}
    check(environment)
    study = load_draft(tomli_w.dumps(_drop_nothing({"strategy": load_study().document["strategy"], **environment})))
    points = study.scenario.target_points()
    point = stored.result.get("point") or points.get(str(stored.result.get("target"))) or next(iter(points.values()))
    return replace(stored, environment=environment, result={**stored.result, "point": point, "evaluation": -1}), study


def load_draft(text: str) -> Study:
    """Return the study of a draft's text, checked; errors name the line of the text.

    Raises InputError if the study is wrong: one line for each error.
    """
    with TemporaryDirectory() as folder:
        # From a file, so that errors have lines, and the run keeps the study as it was given.
        path = Path(folder) / FILE
        path.write_text(text, encoding="utf-8")
        try:
            return load_study(str(path))
        except InputError as error:
            raise InputError(*(line.replace(str(path), FILE) for line in map(str, error.args))) from None


def locate_errors(lines: list[str], text: str) -> list[dict[str, str]]:
    """Return each error with the key on the line of the study that it names, empty if it names none.

    A line may hold a list of tables: the error then names the key within them itself.

    >>> locate_errors(["study.toml:2: flow.speed = -1: should be more"], "[flow]\\nspeed = -1\\n")
    [{'line': 'study.toml:2: flow.speed = -1: should be more', 'key': 'flow.speed'}]
    """
    by_line: dict[int, list[str]] = {}
    for key, number in Study.find_lines(text).items():
        by_line.setdefault(number, []).append(key)
    # Of several keys on a line it is the innermost that holds all others, such as a table in a list.
    keys = {
        number: max((k for k in on if all(o.startswith(k) or k.startswith(o) for o in on)), key=len, default="")
        for number, on in by_line.items()
    }
    found = []
    for line in lines:
        match = re.match(rf"{re.escape(FILE)}:(\d+): ([\w.\[\]-]*)", line)
        key = keys.get(int(match[1]), "") if match else ""
        found.append({"line": line, "key": match[2] if match and key and match[2].startswith(key) else key})
    return found


def _drop_nothing(value: Any) -> Any:
    """Return a value of JSON without its nulls, which TOML does not have."""
    if isinstance(value, dict):
        return {key: _drop_nothing(item) for key, item in value.items() if item is not None}
    return [_drop_nothing(item) for item in value if item is not None] if isinstance(value, list) else value
