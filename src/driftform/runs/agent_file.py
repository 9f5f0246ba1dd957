"""``agent.json``: a genome, and all that decides how it is built and flies. Data only."""

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from driftform.errors import InputError
from driftform.types import Genome
from driftform.util.files import read_text, write_text

FORMAT = "driftform-agent"
VERSION = 1


@dataclass(frozen=True, eq=False)
class StoredAgent:
    """A genome in its environment, under a name for people.

    ``environment`` is the part of a study's document that decides how the agent is built and flies;
    ``result`` holds what is known of its flight, such as ``{"target": "TP1", "fitness": 99.2}``.
    """

    name: str
    genome: Genome
    environment: Mapping[str, Any]
    result: Mapping[str, Any]

    def document(self) -> dict[str, Any]:
        """Return what the file of the agent holds."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "name": self.name,
            "genome": {
                "grammar": self.genome.grammar,
                "symbols": list(self.genome.symbols),
                "tuning": self.genome.tuning,
            },
            "result": dict(self.result),
            "environment": dict(self.environment),
        }

    def to_text(self) -> str:
        """Return the text of the agent's file."""
        return json.dumps(self.document(), indent=1) + "\n"

    def write(self, path: Path) -> None:
        """Write an agent file."""
        write_text(path, self.to_text())

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read an agent file. Raises InputError where it is not one; the message names the file and what is missing."""
        text = read_text(path)
        try:
            document = json.loads(text)
        except RecursionError:
            raise InputError(f"{path}: is not an agent file: nested too deeply") from None
        except ValueError as error:
            raise InputError(f"{path}: is not an agent file, which is JSON in UTF-8: {error}") from None
        if not isinstance(document, dict) or document.get("format") != FORMAT:
            raise InputError(f'{path}: is not an agent file: it lacks "format": "{FORMAT}"')
        if document.get("version") != VERSION:
            raise InputError(
                f"{path}: is an agent file of version {document.get('version')!r}, this driftform reads version "
                f"{VERSION}; use the driftform that wrote it"
            )
        genome, environment = document.get("genome"), document.get("environment")
        symbols, tuning = (genome.get("symbols"), genome.get("tuning", 0.0)) if isinstance(genome, dict) else (None, 0)
        if (
            not isinstance(genome, dict)
            or not isinstance(genome.get("grammar"), str)
            or not isinstance(symbols, list)
            or not all(isinstance(symbol, str) for symbol in symbols)
            or isinstance(tuning, bool)
            or not isinstance(tuning, int | float)
            # An integer of JSON may be larger than any float.
            or not abs(tuning) <= sys.float_info.max
        ):
            raise InputError(
                f'{path}: its "genome" must hold "grammar", a name, "symbols", a list of strings, and "tuning", a number'
            )
        if not isinstance(environment, dict):
            raise InputError(
                f'{path}: its "environment" is missing: the tables that say how the agent is built and flies'
            )
        name, result = document.get("name"), document.get("result")
        return cls(
            name if isinstance(name, str) else path.stem,
            Genome(genome["grammar"], tuple(symbols), float(tuning)),
            environment,
            result if isinstance(result, dict) else {},
        )
