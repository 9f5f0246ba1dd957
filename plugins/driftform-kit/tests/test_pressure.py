"""What a hull withstands, as check, sheet, inspect and report say it."""

from dataclasses import replace
from pathlib import Path

import pytest

from driftform import open_agent
from driftform.interfaces import Flown, PrintJob, ReportJob
from driftform.types import State
from driftform_frusta import driftform_report
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.strength import describe_strength
from driftform_kit.checks.mesh import MeshChecker, MeshOptions
from driftform_kit.sheet.contents import plan_sheet

WORD = "-".join(["addF-tiltp-0-L-moveF"] * 3)


@pytest.fixture(scope="module")
def pressed():
    """An agent for three bar."""
    return open_agent(WORD, "builder.pressure=3e5")


def find(design, job, folder):
    [written] = design.export_files("stl", folder / "hull.stl")
    found = MeshChecker(MeshOptions()).check(PrintJob((Path(written.path),), export=job))
    return [finding for finding in found if finding.check == "pressure"]


def test_check_says_what_fails_first_and_fails_below_what_was_asked_for(pressed, tmp_path):
    job = pressed.export_job()
    assert job.document["environment"]["builder"]["pressure"] == 3e5
    [passed] = find(pressed, job, tmp_path)
    facts = describe_strength(pressed.agent.body, job.scenario.fluid)
    assert (passed.state, passed.detail) == (State.PASS, facts["summary"]) and facts["pressure"] >= 6e5
    asked = {"environment": {"builder": {"pressure": facts["pressure"], "safety": 2.0}}}
    [failed] = find(pressed, replace(job, document=asked), tmp_path)
    assert failed.state is State.FAIL
    assert failed.detail.endswith(f"builder.pressure and safety ask for {2 * facts['pressure'] / 1e5:g} bar")
    unknown = replace(job, agent=replace(job.agent, body=replace(job.agent.body, hull_density=1111.0)))
    assert find(pressed, unknown, tmp_path) == []


def test_sheet_inspect_and_report_agree(pressed):
    job = pressed.export_job()
    facts = describe_strength(pressed.agent.body, job.scenario.fluid)
    settings = dict(plan_sheet(job, PartOptions(kit=True)).settings)
    assert settings["withstands"] == f"{facts['pressure'] / 1e5:.3g} bar ({facts['part']})"
    assert [part["thickness"] for part in facts["parts"] if part["name"].endswith("end")], "it has flat ends"
    assert settings["lost per bar"] == f"{1000 * facts['lost_per_bar']:.2g} g"
    assert pressed.inspect()["strength"] == facts
    best = {"TP<1>": Flown("agent", pressed.agent, pressed.trace(), 50.0)}
    report = driftform_report(ReportJob("run", job.scenario, best))
    assert report == {"Hulls under pressure": f"<ul><li>TP&lt;1&gt;: {facts['summary']}</li></ul>"}
    solid = replace(pressed.agent, body=replace(pressed.agent.body, hull_density=1111.0))
    assert driftform_report(ReportJob("run", job.scenario, {"TP1": replace(best["TP<1>"], agent=solid)})) == {}
