"""``--help`` and ``--version``; and readers that stop reading."""

import sys
from importlib.util import find_spec

import pytest
import typer

import driftform
from driftform.cli.app import app
from driftform.cli.help import DESIGN, FILES, NETWORKS, WORKSHOP


def every_command(group, words=()):
    """The words of all commands, and of their groups."""
    yield words
    for name, command in {**group.commands, **group.list_added()}.items():
        if hasattr(command, "commands"):
            yield from every_command(command, (*words, name))
        else:
            yield (*words, name)


def test_version_and_a_usage_line_without_braces_for_every_command(call):
    assert call("--version").stdout == f"driftform {driftform.__version__}\n"
    assert "Usage" in call().output
    commands = list(every_command(typer.main.get_group(app)))
    assert {("evolve",), ("plugins", "show"), ("calibrate",)} <= set(commands)
    for words in commands:
        usage = call(*words, "--help").stdout.splitlines()[0]
        assert usage.startswith(" ".join(("Usage: driftform", *words, "[OPTIONS]"))), usage
        assert not set(usage) & set("{}"), usage
    assert call("calibrate", "--help").stdout.startswith("Usage: driftform calibrate [OPTIONS] AGENT TRACK...\n")


def test_commands_are_listed_in_four_groups(call):
    titles = [line for line in call("--help").stdout.splitlines() if line and line[0] not in " -"][1:]
    # Only the plugin for water networks, an extra, has commands of their group.
    there = (DESIGN, FILES, *([NETWORKS] if find_spec("driftform_networks") else []), WORKSHOP)
    assert titles == ["Options:", *(f"{title}:" for title in there)]


@pytest.mark.skipif(sys.platform == "win32", reason="closes a POSIX pipe")
@pytest.mark.parametrize("args", [("plugins",), ("scenarios", "show", "pipe-inspection"), ("--help",)])
def test_a_reader_that_stops_early_sees_no_traceback(start, tmp_path, args):
    with start(*args, cwd=tmp_path) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
