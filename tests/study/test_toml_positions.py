"""Keys of TOML files stand where the lines say, whatever a value looks like."""

import tomllib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.study.toml_positions import find_key_lines, find_line


@pytest.mark.parametrize(
    ("text", "path", "line"),
    [
        ("a = 1\nb = 2", ("b",), 2),
        ("# a = 1\n\na = 1 # b = 2", ("a",), 3),
        ("[flow]\nspeed = 1", ("flow",), 1),
        ("[flow]\nspeed = 1", ("flow", "speed"), 2),
        ("  [ flow ]  # x\n  speed=1", ("flow", "speed"), 2),
        ("\nflow.speed = 1", ("flow", "speed"), 2),
        ("\nflow . speed = 1", ("flow",), 2),
        ("[pipe.segments.a]\nb = 1", ("pipe", "segments", "a", "b"), 2),
        ('"a.b" = 1\n"c d".e = 2', ("a.b",), 1),
        ('"a.b" = 1\n"c d".e = 2', ("c d", "e"), 2),
        ('["a.b"."c]"]\nd = 1', ("a.b", "c]", "d"), 2),
        ("'lit\"eral' = 1", ('lit"eral',), 1),
        ('"tab\\tand \\"quote\\" = x" = 1', ('tab\tand "quote" = x',), 1),
        ("[[s]]\na = 1\n[[s]]\na = 2", ("s", 0, "a"), 2),
        ("[[s]]\na = 1\n[[s]]\na = 2", ("s", 1, "a"), 4),
        ("[[s]]\na = 1\n[[s]]\na = 2", ("s", 1), 3),
        ("[[p.s]]\n[p.s.q]\na = 1\n[[p.s]]\n[p.s.q]\na = 2", ("p", "s", 1, "q", "a"), 6),
        ("[[p]]\n[[p.s]]\na = 1\n[[p]]\n[[p.s]]\na = 2", ("p", 1, "s", 0, "a"), 6),
        ('a = """\nb = 1\n[c]\n"""\nb = 2', ("b",), 5),
        ("a = '''\nb = 1\n[c]\n'''\nb = 2", ("b",), 5),
        ('a = """ends in a quote""""\nb = 2', ("b",), 2),
        ('a = """\\"""\nb = 1\n"""\nb = 2', ("b",), 4),
        ("a = [\n  [1, 2],\n  [3]\n]\nb = 2", ("b",), 5),
        ("a = [ # [b]\n  \"]\", '#',\n]\nb = 2", ("b",), 4),
        ('a = "# no comment"\nb = 2', ("b",), 2),
        ("a = { b = 1, c = { d = 2 } }\ne = 3", ("e",), 2),
        ("a = 1\r\n[b]\r\nc = 2\r\n", ("b", "c"), 3),
        ("a = 1\n[b]", ("b",), 2),
    ],
)
def test_a_key_has_the_line_on_which_it_is_written(text: str, path: tuple[str | int, ...], line: int) -> None:
    tomllib.loads(text)
    assert find_key_lines(text)[path] == line


def test_a_key_of_an_inline_table_has_the_line_of_its_table() -> None:
    lines = find_key_lines("x = 1\nrelease = { velocity = 'rest' }")
    assert find_line(("release", "velocity"), lines) == 2


def test_a_missing_key_has_no_line() -> None:
    assert find_line(("gone",), find_key_lines("a = 1")) is None
    assert find_line((), find_key_lines("a = 1")) is None


# What may confuse a reader of lines: keys with structure in them, values with keys in them.
_names = st.text(st.sampled_from("ab.=#[]\"'\\ \t"), min_size=1, max_size=5)
_scalars = st.one_of(
    st.integers(-9, 9),
    st.booleans(),
    st.text(st.sampled_from("ab=#[]{}\"'\\\n"), max_size=12),
    st.lists(st.lists(st.text(st.sampled_from("a]#\n"), max_size=3), max_size=2), max_size=2),
)


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\t", "\\t").replace("\n", "\\n")
    return f'"{escaped}"'


def _written(value: Any, style: int) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int):
        return str(value)
    if isinstance(value, list):
        separator = ", # ]\n  " if style % 2 else ", "
        return "[" + "".join(_written(item, style) + separator for item in value) + "]"
    if style % 3 == 1:
        return '"""' + value.replace("\\", "\\\\").replace('"', '\\"') + '"""'
    if style % 3 == 2 and "'" not in value:
        return f"'''{value}'''"
    return _quoted(value)


@given(st.dictionaries(_names, st.dictionaries(_names, st.tuples(_scalars, st.integers(0, 5)), max_size=3), max_size=3))
def test_every_key_that_was_written_is_found_where_it_was_written(
    tables: dict[str, dict[str, tuple[Any, int]]],
) -> None:
    text, expected = "", {}
    for table, keys in tables.items():
        expected[(table,)] = text.count("\n") + 1
        text += f"[{_quoted(table)}] # = [x]\n"
        for key, (value, style) in keys.items():
            expected[(table, key)] = text.count("\n") + 1
            text += f"{_quoted(key)} = {_written(value, style)} # {key.strip()!r}\n"
    assert tomllib.loads(text).keys() == tables.keys()
    assert find_key_lines(text) == expected
