"""The lines of the keys of a TOML file, for error messages: tomllib does not report them."""

import re
import tomllib
from collections.abc import Mapping
from typing import TypeAlias

Path: TypeAlias = tuple[str | int, ...]
"""A key as its names from the top level; a number is an index into a list, from 0."""

MAX_KEY_NAMES = 20
"""Most names of a dotted key: no study nests as deep."""

_NAME = r"""(?:[\w-]++|"(?:\\.|[^"\\\n])*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"(?<![\w-]){_NAME}(?:[ \t]*+\.[ \t]*+{_NAME}){{{MAX_KEY_NAMES},}}+")

# Strings, which may span lines, and comments are single tokens, because their content could be mistaken for structure.
# A multi-line string may contain up to two quotes before its closing quotes.
_TOKEN = re.compile(
    r'''"""(?:\\.|[^\\])*?""""{0,2}|\'\'\'.*?\'\'\'\'{0,2}|"(?:\\.|[^"\\\n])*"|'[^'\n]*'|\#[^\n]*'''
    r"""|[\[\]{}=\n]|[^"'\#\[\]{}=\n]+|.""",
    re.DOTALL,
)


def check_keys(text: str) -> None:
    """Check that no key of a TOML text has more than :data:`MAX_KEY_NAMES` names.

    tomllib needs memory and time that grow with the square of their number.

    Raises ValueError if a key has more; the message says its line.
    """
    found = _LONG_KEY.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise ValueError(f"a key of more than {MAX_KEY_NAMES} names at line {line}")


_HINTS = (
    (r"""=\s*[+-]?\d+,\d+\s*(#.*)?$""", "a number has a decimal point: write {0}"),
    (
        r"""=.*"[^"']*\\""",
        "a backslash in double quotes is a code: write / in its place, or single quotes around the text",
    ),
    (r"""=.*[“”„‘’«»]""", "the quotes must be straight ones, \" or '"),
    (r"""=\s*(True|False|TRUE|FALSE)\b""", "true and false have small letters"),
    (r"""^[^"']*=\s*("[^"]*|'[^']*|[^"'\[{]+["'])$""", "a quote is missing: a text has one at each end"),
    (r"""=\s*[^\W\d][^"'=]*$""", "a text is in quotes: write {0}"),
    (r"""^\s*\w+\s*:""", "a key and its value have = between them"),
    (r"""=\s*(#.*)?$""", "the key has no value"),
)
"""What is often wrong with a line of TOML, by an expression, and what to do."""


def describe_fault(label: str, text: str, error: ValueError) -> str:
    """Return in one line why a text is not TOML: its place, what its parser says, and what to do if that can be seen."""
    said = str(error)
    found = re.search(r"\(at (?:line (\d+), column \d+|end of document)\)$", said)
    rows = text.rstrip().split("\n")
    number = int(found.group(1) or len(rows)) if found else 0
    line = rows[min(number, len(rows)) - 1][:200] if found else ""
    for pattern, hint in _HINTS:
        if re.search(pattern, line):
            value = line.partition("=")[2].partition("#")[0].strip()
            better = value.replace(",", ".") if value[:1] in "+-0123456789" else f'"{value}"'
            return f"{label}:{number}: is not valid TOML: {line.strip():.60}: {hint.format(better)}"
    return f"{label}: is not valid TOML: {said}"


def find_key_lines(text: str) -> dict[Path, int]:
    """Return the line of each key of a valid TOML document, counted from 1.

    Tables are keys too; those of an array of tables are numbered. Keys inside inline tables are not included:
    :func:`find_line` returns the line of the table.
    """
    lines: dict[Path, int] = {}
    counts: dict[Path, int] = {}
    table: Path = ()
    # A statement is a header, or a key, '=' and a value that continues while a bracket is open.
    head, in_value, depth = "", False, 0
    line = begin = 1

    def note(path: Path) -> None:
        if len(path) > MAX_KEY_NAMES:
            raise ValueError(f"line {begin}: a key of {len(path)} names; no study has more than {MAX_KEY_NAMES}")
        for end in range(1, len(path) + 1):
            lines.setdefault(path[:end], begin)

    for token in _TOKEN.findall(text + "\n"):
        if token == "\n" and depth == 0:
            header = head.strip()
            if not in_value and header.startswith("[["):
                array = _resolve_header(_split_key(header[2:-2]), counts, inside_last=False)
                counts[array] = counts.get(array, 0) + 1
                table = (*array, counts[array] - 1)
                note(table)
            elif not in_value and header.startswith("["):
                table = _resolve_header(_split_key(header[1:-1]), counts)
                note(table)
            head, in_value, begin = "", False, line + 1
        elif in_value:
            depth += (token in "[{") - (token in "]}")
        elif token == "=":
            note(table + _split_key(head))
            in_value = True
        elif not token.startswith("#"):
            head += token
        line += token.count("\n")
    return lines


def find_line(path: Path, lines: Mapping[Path, int]) -> int | None:
    """Return the line of a key, or of the innermost known key that contains it; ``None`` if there is no such key."""
    for end in range(len(path), 0, -1):
        if path[:end] in lines:
            return lines[path[:end]]
    return None


def _split_key(dotted: str) -> Path:
    names: list[str] = []
    node = tomllib.loads(f"{dotted.strip()} = 0")
    while isinstance(node, dict):
        [(name, node)] = node.items()
        names.append(name)
    return tuple(names)


def _resolve_header(names: Path, counts: Mapping[Path, int], inside_last: bool = True) -> Path:
    """Return the path of the names of a header; below an array of tables they refer to its last table."""
    path: Path = ()
    for number, name in enumerate(names, start=1):
        path = (*path, name)
        if path in counts and (inside_last or number < len(names)):
            path = (*path, counts[path] - 1)
    return path
