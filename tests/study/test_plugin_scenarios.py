"""Plugins bring scenarios of their own, by a package of TOML files."""

import sys

import pytest
from program import write_metadata

from driftform.errors import InputError
from driftform.study import load_study
from driftform.study.sources import read_scenarios

HOOK = """
from driftform import hookimpl

@hookimpl
def driftform_scenarios():
    return "{package}"
"""

NARROW = 'title = "A narrow pipe"\nbase = "pipe-inspection"\n[flow]\nspeed = 0.5\n'


def install(site, name, files, package=None):
    """A distribution, as far as ``importlib.metadata`` can tell, with a package of scenarios."""
    folder = site / f"driftform_{name}"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text(HOOK.format(package=package or f"driftform_{name}"))
    for file, text in files.items():
        (folder / file).write_text(text)
    write_metadata(site, f"driftform-{name}", f"{name} = driftform_{name}")


@pytest.fixture
def site(tmp_path, monkeypatch):
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    for name in [name for name in sys.modules if name in ("driftform_one", "driftform_two")]:
        monkeypatch.delitem(sys.modules, name)
    return folder


def test_a_scenario_of_a_plugin_is_listed_and_loaded_by_its_name(site):
    install(site, "one", {"narrow.toml": NARROW, "notes.txt": "no scenario"})
    assert read_scenarios()["narrow"] == NARROW
    assert "notes" not in read_scenarios()
    study = load_study("narrow", run={"seed": 0})
    assert study.scenario.flow.speed == 0.5 and len(study.scenario.targets) == 10


def test_errors_in_it_name_it_and_the_line(site):
    install(site, "one", {"narrow.toml": NARROW.replace("speed", "sped")})
    with pytest.raises(InputError, match=r"narrow \(built in\):4: .*did you mean 'speed'"):
        load_study("narrow")


def test_a_built_in_scenario_cannot_be_replaced(site):
    install(site, "one", {"pipe-inspection.toml": NARROW})
    assert "a water main" in read_scenarios()["pipe-inspection"]


def test_a_plugin_that_cannot_be_imported_hides_no_other(site):
    install(site, "one", {"narrow.toml": NARROW})
    install(site, "two", {}, package="driftform_missing.scenarios")
    assert {"narrow", "paper", "pipe-inspection"} <= set(read_scenarios())
