"""Commands that plugins add; the plugins are real ``.dist-info`` directories on the path."""

import json
from importlib import metadata

import pytest

from driftform.cli.added import BROUGHT_BY, load_added
from driftform.plugins.discovery import GROUP

HOOK = """
from typing import Annotated

import typer
from driftform import hookimpl
from driftform.cli import options, output
from driftform.errors import InputError, WorkFailedError

@hookimpl
def driftform_commands(app):
"""

TIDE = f"""{HOOK}
    app.command("tide")(tide)
    app.add_typer(harbour, name="harbour")

harbour = typer.Typer(help="Work in a harbour. It is calm there.")

def tide(height: float = 1.0, json: options.Json = False) -> None:
    \"\"\"Show the tide.\"\"\"
    print("a library prints this")
    if json:
        output.print_json({{"height": height}})

@harbour.command("enter")
def enter(name: Annotated[str, typer.Argument(metavar="NAME", help="Where to.")], json: options.Json = False) -> None:
    \"\"\"Enter the harbour.\"\"\"
    print(f"in {{name}}")
    if json:
        output.print_json({{"in": name}})

@harbour.command("leave")
def leave() -> None:
    raise ArithmeticError("no water")
"""

RAISING = f"""{HOOK}
    app.command("sink")(sink)

def sink(how: str) -> None:
    if how == "input":
        raise InputError("HOW input: is no way to sink")
    if how == "work":
        raise WorkFailedError("it floats")
    if how == "file":
        open("no such file")
    if how == "exit":
        raise typer.Exit(3)
    if how == "leave":
        raise SystemExit("left")
    1 / 0
"""


def add(name, text):
    """The source of a plugin that adds one command, which prints a text."""
    return f'{HOOK}    app.command("{name}")(lambda: print("{text}"))\n'


@pytest.fixture
def without_plugins(monkeypatch):
    """Hide every distribution but driftform itself."""
    every = metadata.entry_points
    own = [point for point in every(group=GROUP) if point.dist and point.dist.name == "driftform"]
    monkeypatch.setattr(
        "importlib.metadata.entry_points", lambda **wanted: own if wanted == {"group": GROUP} else every(**wanted)
    )
    load_added.cache_clear()
    yield
    load_added.cache_clear()


def test_a_command_and_a_group_of_a_plugin_are_listed_and_run(install, call):
    install(ext_tide=TIDE)
    page = call("--help").stdout
    assert "Show the tide." in page and "Work in a harbour." in page and "It is calm" not in page
    # A command that states no group is in that of plugins.
    assert page.index("Files, programs and plugins:") < page.index("Show the tide.") < page.index("Workshop:")
    assert call("tide").stdout == "a library prints this\n"
    assert call("harbour", "enter", "Hull").stdout == "in Hull\n"
    line = call("tide", "--height", "high").stderr
    assert "--height" in line and line.endswith("see 'driftform tide --help'\n") and line.count("\n") == 1
    group = call("harbour", "--help").stdout
    assert "Enter the harbour." in group and "leave" in group
    page = call("harbour", "enter", "--help").stdout
    assert page.startswith("Usage: driftform harbour enter [OPTIONS] NAME\n")
    assert "Print only one JSON document" in page


@pytest.mark.parametrize(
    ("arguments", "document"),
    [
        (("tide", "--height", "2.5", "--json"), {"height": 2.5}),
        (("harbour", "enter", "Hull", "--json"), {"in": "Hull"}),
    ],
)
def test_json_is_all_that_stdout_gets(install, call, arguments, document):
    install(ext_tide=TIDE)
    result = call(*arguments)
    assert json.loads(result.stdout) == document
    assert result.stderr in ("a library prints this\n", "in Hull\n")


def test_a_command_that_two_plugins_claim_is_refused_with_both_names_and_leaves_their_others(install, call, refused):
    both = add("dredge", "one") + '    app.command("buoy")(lambda: print("a buoy"))\n'
    install(ext_one=both, ext_two=add("dredge", "two"))
    assert refused("dredge") == (
        "error: command 'dredge' is unavailable: ext_one-plugin and ext_two-plugin claim it; uninstall one of them"
    )

    assert call("buoy").stdout == "a buoy\n"
    page = call("--help").stdout
    assert "buoy" in page and "dredge" not in page


@pytest.mark.parametrize(
    "fault", ["raise OSError('no room')", "import a_library_that_is_not_there", "raise SystemExit(0)"]
)
def test_a_hook_that_raises_leaves_the_other_commands(install, call, fault):
    install(ext_broken=f"{HOOK}    {fault}\n", ext_sound=add("buoy", "a buoy"))
    assert call("buoy").stdout == "a buoy\n"
    assert call("--help").exit_code == 0
    assert call("scenarios", "list").exit_code == 0
    assert "ext_broken-plugin" in load_added().problems


def test_a_known_command_whose_hook_raises_says_why(install, refused, monkeypatch):
    monkeypatch.setitem(BROUGHT_BY, "sound", "ext_kit-plugin")
    install(ext_kit=f"{HOOK}    raise OSError('no room')\n")
    assert refused("sound") == "error: command 'sound': ext_kit-plugin is unavailable: OSError: no room"


def test_a_hook_that_raises_is_listed_and_named_by_a_command_that_nobody_knows(install, call, refused):
    install(ext_broken=f"{HOOK}    raise OSError('no room')\n", ext_sound=add("buoy", "a buoy"))
    assert refused("sail") == "error: no command is named 'sail'; ext_broken-plugin is unavailable: OSError: no room"
    rows = [row for row in json.loads(call("plugins", "--json").stdout)["plugins"] if row["seam"] == "commands"]
    found = {row["distribution"]: (row["name"], row["state"]) for row in rows}
    assert found["ext_sound-plugin"] == ("buoy", "ok")
    assert found["ext_broken-plugin"] == ("ext_broken", "unavailable: OSError: no room")


@pytest.mark.parametrize(
    ("words", "code", "line"),
    [
        ("sink exit", 3, ""),
        ("sink input", 2, "error: HOW input: is no way to sink"),
        ("sink work", 1, "error: it floats"),
        ("sink file", 1, "error: no such file: No such file or directory"),
        ("sink leave", 1, "error: command 'sink' failed: SystemExit: left (in sink, line "),
        ("sink bug", 1, "error: command 'sink' failed: ZeroDivisionError: division by zero (in sink, line "),
        ("harbour leave", 1, "error: command 'harbour leave' failed: ArithmeticError: no water (in leave, line "),
    ],
)
def test_a_command_that_raises_is_one_line_and_an_exit_code(install, call, words, code, line):
    install(ext_sink=RAISING, ext_tide=TIDE)
    result = call(*words.split())
    assert (result.exit_code, result.stdout) == (code, "")
    assert result.stderr.count("\n") == bool(line)
    assert result.stderr.startswith(line)


def test_a_command_of_the_core_is_not_replaced(install, call):
    install(ext_rival=add("scenarios", "mine") + '    app.command("buoy")(lambda: print("a buoy"))\n')
    assert "pipe-inspection" in call("scenarios").stdout
    assert call("buoy").stdout == "a buoy\n"
    assert sum(line.split()[:1] == ["scenarios"] for line in call("--help").stdout.splitlines()) == 1


@pytest.mark.usefixtures("without_plugins")
@pytest.mark.parametrize(
    ("command", "remedy"),
    [
        ("network", 'uv sync --extra networks, or pip install "driftform[networks]"'),
        ("ros", 'uv sync --extra ros, or pip install "driftform[ros]"'),
        ("studio", 'uv sync --extra studio, or pip install "driftform[studio]"'),
        ("trim", 'pip install "driftform-kit"'),
        ("calibrate", 'pip install "driftform-calibration"'),
        ("reproduce", 'pip install "driftform-paper"'),
    ],
)
def test_a_command_without_its_distribution_says_what_installs_it(refused, command, remedy):
    assert refused(command) == f"error: command '{command}' is not installed; run: {remedy}"
    assert refused(command, "--json") == f"error: command '{command}' is not installed; run: {remedy}"


def test_every_command_that_our_plugins_add_is_known_with_what_installs_it():
    owners = {name: package.replace("[", "-").removesuffix("]") for name, package in BROUGHT_BY.items()}
    installed = {point.dist.name for point in metadata.entry_points(group=GROUP) if point.dist}
    expected = {name for name, owner in owners.items() if owner in installed}
    assert expected <= set(load_added().commands) <= set(BROUGHT_BY)
