"""What the pages say exists: links, commands, hooks, options, and Python that runs."""

import os
import re
import shlex
from pathlib import Path

import pytest
import typer

from driftform import testing
from driftform.cli.app import app
from driftform.plugins.hookspecs import HOOKS
from driftform.water import Fluid
from driftform.water.flow import FLOWS

ROOT = Path(__file__).parents[2]
SOURCE = re.compile(r"(?<![\w/(])(?:src|plugins|tests)/[\w./-]*\w")
COMMAND = re.compile(r"^(?:\$ )?(?:uv run )?(driftform(?: .*)?)$")


def command_lines(pages, blocks):
    """Every command line of the pages: lines of console and text blocks, and inline code."""
    found = []
    for block in blocks:
        if block.language in ("console", "sh", "bash", "shell"):
            text = block.text.replace("\\\n", " ")
            found += [(str(block), m[1]) for line in text.splitlines() if (m := COMMAND.match(line.strip()))]
    for name, text in pages.items():
        spans = re.findall(r"(?<!`)`([^`]+)`(?!`)", text)
        found += [(name, m[1]) for span in spans if (m := COMMAND.match(" ".join(span.split())))]
    return found


def parse(words):
    """Parse a command line down to the command, without running it."""
    command = typer.main.get_command(app)
    context, name = None, "driftform"
    while True:
        context = command.make_context(name, list(words), parent=context)
        words = [*getattr(context, "_protected_args", ()), *context.args]
        if not hasattr(command, "commands") or not words:
            return
        name, command, words = command.resolve_command(context, words)


def test_every_table_has_a_heading_and_rows_of_as_many_columns(pages):
    wrong = []
    for name, text in pages.items():
        tables = re.findall(r"(?m)^(.*)\n( *\|(?:-+\|)+)\n((?: *\|.*\n?)*)", text)
        for heading, line, rows in tables:
            columns = line.count("|")
            for row in (heading, *rows.splitlines()):
                bare = re.sub(r"`[^`]*`", "", row.strip())
                if not bare.startswith("|") or len(re.findall(r"(?<!\\)\|", bare)) != columns:
                    wrong.append(f"{name}: {row}")
    assert wrong == []


@pytest.mark.peers
def test_commands_exist(prose, blocks):
    lines = command_lines(prose, blocks)
    assert len(lines) >= 15
    wrong = []
    for where, line in lines:
        words = shlex.split(line, comments=True)[1:]
        # What the reader fills in.
        words = ["0.05" if word == "KG" else word for word in words if word != "COMMAND"]
        if not words or words[-1] in ("--help", "--version", "--install-completion"):
            words = words[:-1]
        try:
            # "driftform evolve" is named in prose without the arguments that it needs.
            if words:
                parse(words)
        except Exception as error:
            message = getattr(error, "format_message", lambda error=error: str(error))()
            if "Missing" not in message:
                wrong.append(f"{where}: {line}: {message}")
    assert wrong == []


def test_relative_links_resolve(docs, prose):
    anchors = {name: {anchor(line) for line in headings(text)} for name, text in prose.items()}
    wrong = []
    for name, text in prose.items():
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, fragment = target.partition("#")
            page = os.path.normpath(Path(name).parent / path) if path else name
            if not (docs / page).exists():
                wrong.append(f"{name}: {target}: no such file")
            elif fragment and fragment not in anchors.get(page, {fragment}):
                wrong.append(f"{name}: {target}: no such heading")
    assert wrong == []


def headings(text):
    return re.findall(r"^#+ (.+)$", text, re.MULTILINE)


def anchor(heading):
    """The anchor that GitHub gives a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def test_every_page_is_in_the_index(pages):
    for name in pages:
        index = "plugins.md" if name.startswith("plugins/") else "index.md"
        assert name == "index.md" or f"({name})" in pages[index], f"{index} does not link {name}"


@pytest.mark.parametrize(
    ("page", "names"),
    [("dataflow.md", HOOKS), ("write-a-plugin.md", HOOKS), ("write-a-plugin.md", testing.__all__)],
    ids=["hooks of the flow", "hooks", "contracts"],
)
def test_every_hook_and_contract_is_documented(page, names, pages):
    assert [name for name in names if f"`{name}`" not in pages[page]] == []


@pytest.mark.peers
def test_every_built_in_scenario_is_on_the_page_of_study_files(pages):
    from driftform.study.sources import read_scenarios

    section = pages["study-files.md"].partition("## Built-in scenarios")[2].partition("\n## ")[0]
    assert set(re.findall(r"^\| `([\w-]+)` \|", section, re.MULTILINE)) == set(read_scenarios())


def test_no_page_names_a_hook_that_is_not(pages):
    for name, text in pages.items():
        seams = re.findall(r"`driftform_([a-z]+)`", text)
        packages = {"lsystem", "frusta", "striptheory", "exudyn", "networks", "paper", "dwell"}
        assert {f"driftform_{s}" for s in seams if s not in packages} <= set(HOOKS), name


def test_no_page_holds_a_path_of_a_machine(pages):
    for name, text in pages.items():
        assert not re.search(r"(?<![\w.])/(work|home|root|tmp|Users)/", text), name


def test_source_files_that_the_pages_name_exist(pages, blocks):
    examples = [block.file for block in blocks if block.file]
    named = {(page, path) for page, text in pages.items() for path in re.findall(SOURCE, text)}
    assert len(named) > 10
    missing = [(page, path) for page, path in sorted(named) if not (ROOT / path).exists()]
    assert [pair for pair in missing if not any(file.startswith(pair[1]) for file in examples)] == []


@pytest.mark.peers
def test_runnable_python_runs(blocks):
    runnable = [block for block in blocks if block.language == "python" and "runnable" in block.words]
    assert len(runnable) >= 4
    for block in runnable:
        code = compile("\n" * block.line + block.text, block.page, "exec")
        exec(code, {"__name__": "__docs__"})


def test_python_is_runnable_or_a_file(blocks):
    loose = [str(b) for b in blocks if b.language == "python" and not b.file and "runnable" not in b.words]
    assert loose == []


def test_options_that_the_pages_name_exist(prose):
    """``grammar.occupied`` and the like, in inline code, with their value if one is given."""
    from driftform.plugins.registry import registry
    from driftform.study import load_study

    tables = {}
    for scenario in ("paper", "pipe-inspection"):
        for name, table in load_study(scenario, run={"seed": 0}).document.items():
            if isinstance(table, dict):
                tables[name] = tables.get(name, set()) | set(table)
    tables["run"] |= {"seed"}
    strategies = [row.cls for row in registry().seam("strategy") if row.cls is not None]
    tables["strategy"] |= {key for cls in strategies for key in cls.Options.model_fields}
    tables["fluid"] |= set(Fluid.model_fields)
    tables["flow"] = {key for profile in FLOWS.values() for key in profile.model_fields}
    wrong = []
    for name, text in prose.items():
        for span in re.findall(r"(?<!`)`([^`\n]+)`(?!`)", text):
            found = re.fullmatch(r"([a-z]+)\.([a-z_0-9]+)(?: ?= ?(.+))?", span)
            if not found or found[1] not in tables or found[1] == "targets" or found[2] in ("py", "db", "toml", "svg"):
                continue
            if found[2] not in tables[found[1]] and found[2] != "use":
                wrong.append(f"{name}: {span}: no such key")
            elif (found[1], found[2]) == ("flow", "kind"):
                assert found[3] is None or found[3].strip('"') in FLOWS, span  # A grid needs a file.
            elif found[3] is not None:
                chosen = [cls.name for cls in strategies if found[2] in cls.Options.model_fields]
                use = {"strategy": chosen[0]} if found[1] == "strategy" and found[2] != "use" else {}
                load_study("paper", settings=[f"{found[1]}.{found[2]}={found[3]}"], use=use, run={"seed": 0})
    assert wrong == []


def test_constants_of_the_contact_are_as_told(pages):
    from driftform.motion.forces import bore, impact

    section = pages["physics.md"].partition("## Contact with the wall")[2]
    assert f"(d / {1000 * impact.STIFF_DEPTH:g} mm)^4" in section
    assert f"exp(-{impact.LUBRICATION:g} / St)" in section
    assert f"below about {bore.SINE_SMOOTHING:g}" in section


def test_constants_of_runs_are_as_told(pages):
    from driftform.runs import compression
    from driftform.search import jobs as execution

    assert f"samples at least {compression.SAMPLE_GAP:g} s apart" in " ".join(pages["dataflow.md"].split())
    assert f"each of at most {execution.MAX_BATCH} genomes" in pages["dataflow.md"]
    assert f"A task holds at most {execution.MAX_BATCH} genomes" in pages["running.md"]
    assert execution.ATTEMPTS == 5 and "five processes crash or are killed" in pages["running.md"]
    assert "five in a row for each process" in pages["running.md"]


def test_farthest_distances_are_as_told(pages):
    import numpy as np

    from driftform.study import load_study

    scenario = load_study(run={"seed": 0}).scenario
    for name, point in scenario.targets.items():
        d_max = scenario.pipe.farthest_distance(np.array(point))
        x, y, z = point
        assert f"| {name} | {x:.1f}, {y:.1f}, {z:.1f} | {d_max:.3f} |" in pages["conventions.md"]
