"""The errors that pydantic found in a study, as lines with file, line, key, value and the expected value."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal, get_args, get_origin

from pydantic import Tag, ValidationError

from driftform.errors import did_you_mean
from driftform.study.sources import NOTHING, Source, find_value, join_path, locate_key
from driftform.study.toml_positions import KeyPath
from driftform.util.options import Table


def format_errors(
    error: ValidationError, prefix: KeyPath, model: type[Table], document: Mapping[str, Any], layers: Sequence[Source]
) -> list[str]:
    """Return one line for each error.

    Args:
        error: what pydantic raised when it validated a part of the document by ``model``.
        prefix: key of this part.
        document, layers: the merged document, and its sources.
    """
    lines: list[str] = []
    wrong: dict[KeyPath, dict[str, str]] = {}
    items = error.errors(include_url=False)
    misspelt = {item["loc"][:-1] for item in items if item["type"] == "extra_forbidden"}
    for item in items:
        if item["type"] == "missing" and item["loc"][:-1] in misspelt:
            continue  # Most likely the key is there, but misspelt: one line is enough.
        keys, table = _trace_path(model, item["loc"])
        names = (*prefix, *keys)
        # pydantic reports a key of several possible types once for each, with the name of the type at the end of its path.
        path = names
        while path and find_value(document, path) is NOTHING:
            path = path[:-1]
        if item["type"] == "extra_forbidden":
            hint = did_you_mean(str(path[-1]), table.model_fields if table else ())
            # A key that is not misspelt may belong to another kind.
            kind = "" if "did you mean" in hint else _describe_kind(table)
            lines.append(f"{locate_key(layers, path)}: unknown key '{path[-1]}'{_name_table(path[:-1])}{kind}{hint}")
        elif item["type"] == "missing" and isinstance(names[-1], str):
            lines.append(f"{locate_key(layers, path)}: '{names[-1]}' is missing{_name_table(names[:-1])}")
        elif item["type"] in ("value_error", "assertion_error"):
            fault = item["ctx"]["error"]
            for text in fault.args if type(fault) is ValueError and fault.args else [fault]:
                message = " ".join(str(text).split()) or (
                    f"{_name_table(path).removeprefix(' in ')} is refused by its plugin, which gives no reason"
                )
                lines.append(f"{locate_key(layers, _find_key(message, path, document))}: {message}")
        elif item["type"] == "union_tag_invalid":
            last = next(key for key in reversed(keys) if isinstance(key, str))
            members = _find_members(_find_annotation(table, last))
            path = (*path, *_find_tag(next(iter(members.values()), None))[:1])
            lines.append(
                f"{locate_key(layers, path)}: {join_path(path)} = {_show_value(find_value(document, path))}: "
                f"unknown {path[-1]}{did_you_mean(item['ctx']['tag'], members)}"
            )
        else:
            wrong.setdefault(path, {})[item["type"]] = _describe_expected(item) + _name_unit(item, table, keys)
    for path, messages in wrong.items():
        key, value = join_path(path), find_value(document, path)
        lines.append(f"{locate_key(layers, path)}: {key} = {_show_value(value)}: {', or '.join(messages.values())}")
    return lines


_EXPECTED = {
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
"""The expected value, without the names of Python types, by the kind of error of pydantic."""


def _describe_expected(item: Mapping[str, Any]) -> str:
    kind = item["type"]
    if kind == "missing":
        return f"should have {item['loc'][-1] + 1} values"
    if kind == "too_long":
        most = item["ctx"]["max_length"]
        return f"should have at most {most} value{'s' if most != 1 else ''}"
    if kind == "too_short":
        least = item["ctx"]["min_length"]
        return f"should have at least {least} values" if least > 1 else "should not be empty"
    return _EXPECTED.get(kind) or str(item["msg"]).replace("Input should be", "should be")


def _name_unit(item: Mapping[str, Any], table: type[Table] | None, keys: KeyPath) -> str:
    """Return the unit of a bound, with a space before it; empty for other faults and dimensionless numbers."""
    if not item["type"].startswith(("less_than", "greater_than")) or table is None:
        return ""
    field = table.model_fields[str(next(key for key in reversed(keys) if isinstance(key, str)))]
    extra = field.json_schema_extra
    unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
    return f" {unit}" if unit and unit != "SI" else ""


def _name_table(path: KeyPath) -> str:
    """Return `` in [table]``, as written in the file; empty at the top level."""
    name = ".".join(str(part) for part in path if isinstance(part, str))
    if not name:
        return ""
    return f" in [[{name}]]" if isinstance(path[-1], int) else f" in [{name}]"


def _find_key(message: str, path: KeyPath, document: Mapping[str, Any]) -> KeyPath:
    """Return the key that a message about several keys names: its first word, or a word in quotes."""
    first = message.split(maxsplit=1)[0].rstrip(":") if message else ""
    named = tuple(int(name) if name.isdecimal() else name for name in re.findall(r"[^.[\]]+", first))
    quoted = re.findall(r"'(.*?)'", message)
    for candidate in (named, named[:-1], ("targets", first), *((*path, name) for name in quoted)):
        if not candidate:
            continue
        if find_value(document, candidate) is not NOTHING:
            return candidate
    return path


def _show_value(value: Any) -> str:
    """Return a value in the notation of TOML, as far as it differs from that of Python."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _trace_path(model: type[Table], loc: KeyPath) -> tuple[KeyPath, type[Table] | None]:
    """Return the keys of a location of pydantic, and the model of the table that contains the last key, if any.

    If a table may be of several kinds, pydantic inserts the kind into the location like a key.
    """
    keys: KeyPath = ()
    table: type[Table] | None = None
    inner: type[Table] | None = model
    members: Mapping[str, type[Table]] = {}
    for name in loc:
        if name in members:
            inner, members = members[str(name)], {}
            continue
        keys = (*keys, name)
        if isinstance(name, str):
            # The keys of a table without a model, such as [targets], are names: its values may be of several kinds.
            table, annotation = inner, _find_annotation(inner, name)
            members = members if inner is None else _find_members(annotation)
            inner = next(filter(_is_table, (annotation, *get_args(annotation))), None)
    return keys, table


def _find_annotation(table: type[Table] | None, key: str | int) -> Any:
    fields = table.model_fields if table else {}
    return fields[str(key)].annotation if key in fields else None


def _is_table(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, Table)


def _find_members(annotation: Any) -> dict[str, type[Table]]:
    """Return the models of a table of several possible kinds, or of a list of such tables, by their kind; or nothing."""
    found: dict[str, type[Table]] = {}
    for member in get_args(annotation):
        tags = [mark.tag for mark in getattr(member, "__metadata__", ()) if isinstance(mark, Tag)]
        found.update({tag: get_args(member)[0] for tag in tags} if tags else _find_members(member))
    return found


def _find_tag(table: type[Table] | None) -> tuple[str, ...]:
    """Return the key and value that identify one kind of a table; empty if the table has only one kind."""
    for name, info in (table.model_fields if table else {}).items():
        if get_origin(info.annotation) is Literal and len(get_args(info.annotation)) == 1:
            return name, *get_args(info.annotation)
    return ()


def _describe_kind(table: type[Table] | None) -> str:
    tag = _find_tag(table)
    return f" of {tag[0]} '{tag[1]}'" if tag else ""
