"""Keys of TOML files stand where the lines say, whatever a value looks like."""

import tomllib

import pytest

from driftform.study.toml_positions import MAX_LINES, find_key_lines, find_line


@pytest.mark.parametrize(
    ("text", "path", "line"),
    [
        ("a = 1\nb = 2", ("b",), 2),
        ("[flow]\nspeed = 1", ("flow",), 1),
        ("[flow]\nspeed = 1", ("flow", "speed"), 2),
        ("\nflow.speed = 1", ("flow", "speed"), 2),
        ("[pipe.segments.a]\nb = 1", ("pipe", "segments", "a", "b"), 2),
        ('"a.b" = 1\n"c d".e = 2', ("c d", "e"), 2),
        ("[[s]]\na = 1\n[[s]]\na = 2", ("s", 0, "a"), 2),
        ("[[s]]\na = 1\n[[s]]\na = 2", ("s", 1, "a"), 4),
        ("[[s]]\na = 1\n[[s]]\na = 2", ("s", 1), 3),
        ("[[p.s]]\n[p.s.q]\na = 1\n[[p.s]]\n[p.s.q]\na = 2", ("p", "s", 1, "q", "a"), 6),
        ("[[p]]\n[[p.s]]\na = 1\n[[p]]\n[[p.s]]\na = 2", ("p", 1, "s", 0, "a"), 6),
        ('a = """\nb = 1\n[c]\n"""\nb = 2', ("b",), 5),
        ("a = [\n  [1, 2],\n  [3]\n]\nb = 2", ("b",), 5),
        ("a = [ # [b]\n  \"]\", '#',\n]\nb = 2", ("b",), 4),
        ("a = { b = 1, c = { d = 2 } }\ne = 3", ("e",), 2),
        ("a = 1\r\n[b]\r\nc = 2\r\n", ("b", "c"), 3),
        ("a = 1\n[b]", ("b",), 2),
    ],
)
def test_a_key_has_the_line_on_which_it_is_written(text, path, line):
    tomllib.loads(text)
    assert find_key_lines(text)[path] == line


def test_a_key_of_an_inline_table_has_the_line_of_its_table():
    lines = find_key_lines("x = 1\nrelease = { velocity = 'rest' }")
    assert find_line(("release", "velocity"), lines) == 2


def test_a_missing_key_has_no_line():
    assert find_line(("gone",), find_key_lines("a = 1")) is None
    assert find_line((), find_key_lines("a = 1")) is None


def test_a_file_that_is_too_long_has_no_lines():
    assert find_key_lines("a = 1\n" + "#\n" * MAX_LINES) == {}
