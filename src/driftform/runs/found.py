"""What the strategy of a run found: each result in a JSON file, which is read back, and its rows as CSV."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from driftform.errors import InputError
from driftform.interfaces import Result
from driftform.runs.table_files import Column, write_csv
from driftform.util.files import read_text, write_together

FOUND = "strategy"
"""The folder of a run that they are in."""


def write_found(folder: Path, results: Mapping[str, Result]) -> None:
    """Write results by their names into a folder, in place of older ones; a strategy without results needs no folder."""
    if not results and not folder.exists():
        return
    with write_together(folder, {path.name for path in folder.glob("*.*")}) as part:
        for name, result in results.items():
            columns = {name: values.tolist() for name, values in result.columns.items()}
            if "evaluation" in columns:
                columns["evaluation"] = list(map(int, columns["evaluation"]))
            text = json.dumps(asdict(result) | {"columns": columns}, indent=1)
            (part / f"{name}.json").write_text(text + "\n", encoding="utf-8")
            write_csv(part / f"{name}.csv", [Column(name, "float", "", "") for name in columns], [columns])


def read_found(folder: Path) -> dict[str, Result]:
    """Return the results in a folder by their names. Raises InputError if a file is not one of them."""
    found = {}
    for path in sorted(folder.glob("*.json")):
        try:
            found[path.stem] = Result(**json.loads(read_text(path)))
        except (ValueError, TypeError, AttributeError) as error:
            raise InputError(f"{path}: is damaged: {error}; remove it, or write it anew by resuming the run") from None
    return found
