"""The lines of the keys of a TOML file, for error messages: tomllib does not report them."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

KeyPath: TypeAlias = tuple[str | int, ...]
"""A key as its names from the top level; a number is an index into a list, from 0."""

MAX_KEY_NAMES = 20
"""Most names of a dotted key: no study nests as deep."""

_NAME = r"""(?:[\w-]++|"(?:\\.|[^"\\\n])*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"(?<![\w-]){_NAME}(?:[ \t]*+\.[ \t]*+{_NAME}){{{MAX_KEY_NAMES},}}+")

MAX_LINES = 1000
"""Most lines of a file whose keys are located: the time grows with their square, and no study is as long."""


def check_keys(text: str) -> None:
    """Check that no key of a TOML text has more than :data:`MAX_KEY_NAMES` names.

    tomllib needs memory and time that grow with the square of their number.

    Raises ValueError if a key has more; the message says its line.
    """
    found = _LONG_KEY.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise ValueError(f"a key of more than {MAX_KEY_NAMES} names at line {line}")


def describe_fault(label: str, text: str, error: ValueError) -> str:
    """Return in one line why a text is not TOML: its place, what its parser says, and what to do if that can be seen."""
    said = str(error)
    found = re.search(r"\(at (?:line (\d+), column \d+|end of document)\)$", said)
    rows = text.rstrip().split("\n")
    number = int(found.group(1) or len(rows)) if found else 0
    line = rows[min(number, len(rows)) - 1][:200] if found else ""
    hints = tomllib.loads(Path(__file__).with_name("toml_hints.toml").read_text(encoding="utf-8"))["hint"]
    for hint in hints:
        if re.search(hint["pattern"], line):
            value = line.partition("=")[2].partition("#")[0].strip()
            better = value.replace(",", ".") if value[:1] in "+-0123456789" else f'"{value}"'
            return f"{label}:{number}: is not valid TOML: {line.strip():.60}: {hint['advice'].format(better)}"
    return f"{label}: is not valid TOML: {said}"


@lru_cache(maxsize=8)
def find_key_lines(text: str) -> Mapping[KeyPath, int]:
    """Return the line of each key of a valid TOML document, counted from 1; none of a document that is too long.

    Tables are keys too; those of an array are numbered. A key begins after the last line up to which the document was one
    without it: so its own parser decides what a key is.
    """
    lines: dict[KeyPath, int] = {}
    rows, begin = text.replace("\r\n", "\n").split("\n"), 1
    for number in range(1, len(rows) + 1 if len(rows) <= MAX_LINES else 0):
        try:
            found = tomllib.loads("\n".join(rows[:number]))
        except ValueError:
            # Within a value of several lines.
            continue
        for path in _list_paths(found):
            lines.setdefault(path, begin)
        begin = number + 1
    return lines


def _list_paths(node: Any, above: KeyPath = ()) -> Iterator[KeyPath]:
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for name, value in items:
        yield (*above, name)
        yield from _list_paths(value, (*above, name))


def find_line(path: KeyPath, lines: Mapping[KeyPath, int]) -> int | None:
    """Return the line of a key, or of the innermost known key that contains it; ``None`` if there is no such key."""
    for end in range(len(path), 0, -1):
        if path[:end] in lines:
            return lines[path[:end]]
    return None
