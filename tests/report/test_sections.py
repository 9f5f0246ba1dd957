"""Sections of a report that plugins add by the hook ``driftform_report``."""

from types import SimpleNamespace

import pytest

import driftform_calibration
from driftform import hookimpl
from driftform.errors import WorkFailedError
from driftform.interfaces import ReportJob
from driftform.plugins.discovery import PluginModule
from driftform.runs.run import StoredRun
from driftform.search.report.contents import collect_contents
from driftform.search.report.page import page_html
from driftform.water import Scenario


def collect_with(run, monkeypatch, *hooks):
    """The contents of a run, with plugins of which each has one of the hooks."""
    modules = [
        PluginModule("mine", "mine", f"mine-{number}", "1.0", SimpleNamespace(driftform_report=hookimpl(hook)))
        for number, hook in enumerate(hooks)
    ]
    monkeypatch.setattr("driftform.search.report.contents.find_modules", lambda: modules)
    return collect_contents(StoredRun.open(run))


def list_masses(job):
    return {"Masses": "".join(f"<i>{name} {flown.agent.mass.mass:.6f}</i>" for name, flown in job.best.items())}


def test_a_section_shows_what_its_plugin_makes_of_the_best_agents(run_with_page, monkeypatch):
    contents = collect_with(run_with_page, monkeypatch, list_masses, lambda job: {})
    assert list(contents.added) == ["Masses"] and contents.problems == []
    page = page_html(contents)
    assert ">Masses</h2>" in page
    for entry in contents.entries:
        assert f"<i>{entry.target} {entry.agent.mass.mass:.6f}</i>" in page


@pytest.mark.parametrize(
    ("returned", "reason"),
    [
        (None, "TypeError: 'NoneType' object is not iterable"),
        ({"Masses": 3}, "TypeError: expected texts by their headings"),
        (SystemExit("gone"), "SystemExit: gone"),
        (WorkFailedError("no table of masses"), "no table of masses"),
    ],
)
def test_a_plugin_that_fails_is_one_line_of_the_page_and_the_others_keep_theirs(
    returned, reason, run_with_page, monkeypatch
):
    def fail(job):
        if isinstance(returned, BaseException):
            raise returned
        return returned

    contents = collect_with(run_with_page, monkeypatch, fail, list_masses)
    [problem] = contents.problems
    assert problem.startswith(f"driftform_report of mine-0 failed: {reason}")
    assert "driftform_report of mine-0 failed" in page_html(contents)
    assert list(contents.added) == ["Masses"]


def test_only_a_calibrated_model_has_a_section_of_its_factors():
    assert driftform_calibration.driftform_report(ReportJob("run", Scenario(), {})) == {}
    calibration = {"cross_drag": (1.4, 1.3, 1.6), "tracks": 3}
    scenario = Scenario(calibration=calibration)
    [(heading, table)] = driftform_calibration.driftform_report(ReportJob("run", scenario, {})).items()
    assert heading == "Calibration" and "By 3 filmed flights" in table
    assert "<td>1.4</td><td>1.3 to 1.6</td>" in table
