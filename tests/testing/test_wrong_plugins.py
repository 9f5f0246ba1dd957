"""Contracts are of use only if they refuse what is wrong: mistakes, the test of a contract and the line of a run that find each."""

import inspect
import itertools
import re
import tomllib
from pathlib import Path

import pytest
import wrong_plugins

from driftform import testing
from driftform.plugins.registry import registry

KNOWN = tomllib.loads(Path(__file__).with_name("mistakes.toml").read_text(encoding="utf-8"))
ROWS = [(seam, name, row) for seam, rows in KNOWN.items() for name, row in rows.items()]
CONTRACTS = {"simulator": testing.PointSimulatorContract} | {
    seam: getattr(testing, f"{seam.title()}Contract") for seam in wrong_plugins.SOUND if seam != "simulator"
}

SEARCHED = ("grammar", "builder", "hydrodynamics", "simulator", "fitness", "strategy")
"""Seams of plugins that a search asks."""

SAID, USUAL = ("warning: ", "error: ", "failed most often"), re.compile(r"flight\.horizon|\(1 of 1\): the flight ended")
"""How lines begin that say what is wrong; those about short flights, and one that failed, are there with sound plugins, too."""


def ask(seam, plugin, name, tmp_path, monkeypatch):
    """Run a test of a contract with all values of its parameters, and the fixtures that it needs."""

    class Mine(CONTRACTS[seam]):
        def plugin(self, *space):
            return plugin(plugin.Options(), *space)

    test = getattr(Mine(), name)
    marks = [mark.args for mark in getattr(test, "pytestmark", ())]
    names = [[word.strip() for word in (m[0].split(",") if isinstance(m[0], str) else m[0])] for m in marks]
    rows = [[row if len(n) > 1 else (row,) for row in mark[1]] for n, mark in zip(names, marks, strict=True)]
    for number, chosen in enumerate(itertools.product(*rows)):
        values = dict(zip(itertools.chain(*names), itertools.chain(*chosen), strict=True))
        fixtures = {"tmp_path": tmp_path / str(number), "monkeypatch": monkeypatch}
        fixtures["tmp_path"].mkdir()
        test(**values, **{name: fixtures[name] for name in inspect.signature(test).parameters.keys() & fixtures})


@pytest.mark.parametrize(("seam", "test"), sorted({(seam, row["test"]) for seam, _, row in ROWS if "test" in row}))
def test_the_sound_plugin_passes(seam, test, tmp_path, monkeypatch):
    ask(seam, wrong_plugins.SOUND[seam], test, tmp_path, monkeypatch)


@pytest.mark.parametrize(("seam", "name", "row"), [row for row in ROWS if "test" in row[2]])
def test_a_mistake_is_refused(seam, name, row, tmp_path, monkeypatch):
    wrong = getattr(wrong_plugins, wrong_plugins.name_of(seam, name))
    with pytest.raises((AssertionError, IndexError, ValueError)):
        ask(seam, wrong, row["test"], tmp_path, monkeypatch)


@pytest.mark.long
@pytest.mark.parametrize(("seam", "name", "row"), [row for row in ROWS if "why" in row[2]])
def test_what_no_contract_can_see_passes_all_of_it(seam, name, row, tmp_path, monkeypatch):
    wrong = getattr(wrong_plugins, wrong_plugins.name_of(seam, name))
    for test in (test for test in dir(CONTRACTS[seam]) if test.startswith("test_")):
        (tmp_path / test).mkdir()
        ask(seam, wrong, test, tmp_path / test, monkeypatch)


@pytest.mark.long
@pytest.mark.parametrize(("seam", "name", "row"), [row for row in ROWS if row[0] in SEARCHED])
def test_a_run_says_what_is_wrong_or_nothing(seam, name, row, call, install):
    chosen = {"strategy": "paper", "grammar": "lsystem"} | {seam: wrong_plugins.name_of(seam, name)}
    source = f"import wrong_plugins\nfrom driftform import hookimpl\n\n\n@hookimpl\ndef driftform_{seam}():\n"
    install(wrong=f"{source}    return getattr(wrong_plugins, {chosen[seam]!r})\n")
    registry.cache_clear()
    words = itertools.chain(*(("--set", f"{key}.use={value}") for key, value in chosen.items()))
    quick = ("--set", "run.formats=[]", *(("--set", "flight.horizon=1") if seam == "simulator" else ()))
    targets = ("--target", "TP1", "--target", "TP9")
    budget = ("--evaluations", 100, "--seed", 1, "--workers", 1)
    result = call("evolve", "paper", *targets, *budget, "--out", "run", *quick, *words)
    assert result.exception is None or isinstance(result.exception, SystemExit)
    said = result.stdout + result.stderr
    if seam in ("grammar", "strategy") and result.exit_code == 0:
        said += call("resume", "run", "--evaluations", 101, "--workers", 1).stderr
    registry.cache_clear()
    lines = [line for line in said.splitlines() if line.startswith(SAID) and not USUAL.search(line)]
    assert bool(lines) == ("run" in row) and row.get("run", "") in "\n".join(lines)


def test_the_page_shows_all_mistakes(published):
    assert {seam: list(rows) for seam, rows in KNOWN.items()} == {s: list(c) for s, c in wrong_plugins.CHANGES.items()}
    assert all(("test" in row) != ("why" in row) for _, _, row in ROWS)
    lines = ["| plugin | mistake | its contract fails where it asks that | a run says |", "|---|---|---|---|"]
    for seam, _, row in ROWS:
        asked = row["test"].removeprefix("test_").replace("_", " ") if "test" in row else f"nothing: {row['why']}"
        heard = f"`{row['run']}`" if "run" in row else "nothing" if seam in SEARCHED else ""
        lines.append(f"| {seam} | {row['what']} | {asked} | {heard} |")
    published("mistakes", lines)


def test_every_contract_states_what_each_of_its_tests_asks():
    contracts = [getattr(testing, name) for name in testing.__all__]
    tests = [test for contract in contracts for name, test in vars(contract).items() if name.startswith("test_")]
    assert len(tests) > 80
    assert [test.__qualname__ for test in tests if not test.__doc__] == []
