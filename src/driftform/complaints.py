"""What pydantic found wrong in a study, told in the user's terms: file, line, key, value, and what it should be."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from driftform.errors import did_you_mean
from driftform.layers import NOTHING, Layer, dotted, source_of, value_at
from driftform.options import Table
from driftform.toml_lines import Path as KeyPath


def complaints(
    error: ValidationError,
    prefix: KeyPath,
    model: type[Table],
    document: Mapping[str, Any],
    layers: Sequence[Layer],
) -> list[str]:
    """Return a line for each thing that is wrong.

    Parameters
    ----------
    error
        what pydantic raised when it checked a part of the document against ``model``.
    prefix
        the key of that part.
    document, layers
        the merged document, and the sources that it came from.
    """
    lines: list[str] = []
    wrong: dict[KeyPath, dict[str, str]] = {}
    items = error.errors(include_url=False)
    misspelt = {item["loc"][:-1] for item in items if item["type"] == "extra_forbidden"}
    for item in items:
        if item["type"] == "missing" and item["loc"][:-1] in misspelt:
            continue  # Most likely it is there under the other name: one line is enough.
        names = (*prefix, *item["loc"])
        # A key that may be of several types is reported once for each; the path then ends in the type's name.
        path = names
        while path and value_at(document, path) is NOTHING:
            path = path[:-1]
        if item["type"] == "extra_forbidden":
            siblings = _fields(model, path[len(prefix) : -1])
            table = _table(path[:-1])
            lines.append(
                f"{source_of(layers, path)}: unknown key '{path[-1]}'{table}{did_you_mean(str(path[-1]), siblings)}"
            )
        elif item["type"] == "missing" and isinstance(names[-1], str):
            lines.append(f"{source_of(layers, path)}: '{names[-1]}' is missing{_table(names[:-1])}")
        elif item["type"] == "value_error":
            message = str(item["ctx"]["error"])
            lines.append(f"{source_of(layers, _blamed(message, path, document))}: {message}")
        else:
            wrong.setdefault(path, {})[item["type"]] = _should(item)
    for path, messages in wrong.items():
        key, value = dotted(path), value_at(document, path)
        lines.append(f"{source_of(layers, path)}: {key} = {_shown(value)}: {', or '.join(messages.values())}")
    return lines


_SHOULD = {
    "float_type": "should be a number",
    "float_parsing": "should be a number",
    "int_type": "should be a whole number",
    "int_parsing": "should be a whole number",
    "int_from_float": "should be a whole number",
    "tuple_type": "should be a list",
    "dict_type": "should be a table",
    "model_type": "should be a table",
    "string_type": "should be text in quotes",
}
"""What a value should have been, for people who do not know Python's types, by pydantic's kind of error."""


def _should(item: Mapping[str, Any]) -> str:
    kind = item["type"]
    if kind == "missing":
        return f"should have {item['loc'][-1] + 1} values"
    if kind == "too_long":
        return f"should have at most {item['ctx']['max_length']} values"
    return _SHOULD.get(kind) or str(item["msg"]).replace("Input should be", "should be")


def _table(path: KeyPath) -> str:
    """`` in [table]``, as it stands in the file; empty at the top."""
    name = ".".join(str(part) for part in path if isinstance(part, str))
    if not name:
        return ""
    return f" in [[{name}]]" if isinstance(path[-1], int) else f" in [{name}]"


def _blamed(message: str, path: KeyPath, document: Mapping[str, Any]) -> KeyPath:
    """The key that a check of several keys speaks of: its message begins with it, or has it in quotes."""
    first = message.split(maxsplit=1)[0] if message else ""
    quoted = re.findall(r"'(.*?)'", message)
    for candidate in (tuple(first.split(".")), ("targets", first), *((*path, name) for name in quoted)):
        if value_at(document, candidate) is not NOTHING:
            return candidate
    return path


def _shown(value: Any) -> str:
    """A value as a TOML file has it, as far as Python's notation differs."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _fields(model: type[Table], path: KeyPath) -> list[str]:
    for name in path:
        if isinstance(name, int):
            continue
        annotation = model.model_fields[name].annotation if name in model.model_fields else None
        candidates = [annotation, *getattr(annotation, "__args__", ())]
        inner = [c for c in candidates if isinstance(c, type) and issubclass(c, Table)]
        if not inner:
            return []
        model = inner[0]
    return list(model.model_fields)
