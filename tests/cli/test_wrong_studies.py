"""Studies that cannot do what their author wants: refused, or warned of, before the first flight.

A warning or a refusal comes within the first second of a command. That is processor time: other work on the machine
does not count.
"""

import json
import time
import tomllib
from pathlib import Path

import pytest

from driftform.errors import InputError
from driftform.study import load_study

pytestmark = pytest.mark.usefixtures("ideal_water")

PIPE = "pipe.segments=[{start=[0,0,0],end=[%s],radius=%s}]"

WRONG = tomllib.loads(Path(__file__).with_name("wrong_studies.toml").read_text(encoding="utf-8"))
"""What the author got wrong: the settings, and what the line says that refuses or warns."""


def load_and_list(settings):
    return load_study("paper", settings=[*settings, "run.seed=1"]).list_warnings()


def test_the_built_in_scenarios_give_no_warning():
    for name in ("paper", "pipe-inspection"):
        assert load_study(name).list_warnings() == []


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_study_is_refused_or_warned_of_in_the_first_second(name):
    settings, verdict = WRONG[name]["settings"], "refused" if "refused" in WRONG[name] else "warned"
    load_and_list([])  # Imports are the same for all.
    began = time.process_time()
    if verdict == "refused":
        with pytest.raises(InputError) as caught:
            load_and_list(settings)
        lines = [str(line) for line in caught.value.args]
    else:
        lines = load_and_list(settings)
    assert time.process_time() - began < 1
    assert any(WRONG[name][verdict] in line for line in lines), lines
    # One mistake, one line: nobody reads the third.
    assert verdict == "refused" or len(lines) <= 2
    assert all("\n" not in line for line in lines)


@pytest.mark.parametrize(
    "settings",
    [
        ["targets={A=[4,0.3,0.2]}", "release.yaw_deg=5"],
        ["targets={A=[4,0.3,0.2]}", "flow.kind=turbulent", "flow.upstream=100"],
        ["targets={A=[4,0.3,0.2]}", "release.position=[0,0.1,0]"],
        ["targets={A=[4,0.3,0.2]}", "release.velocity=[1,0.1,0]"],
        ["flow.speed=-1", "flow.acceleration=0.5"],
        ["flow.speed=-1", "release.position=[8.9,0,0]"],
        ["flow.speed=0", "release.velocity=[1,0,0]"],
        ["flight.horizon=8.6"],
        [PIPE % ("0,0,-9", 1), "targets={A=[0,0,-4]}", "flow.speed=0.1"],
        [PIPE % ("9,9,0", 1), "targets={A=[4,4,0.3]}"],
    ],
)
def test_a_study_that_can_do_it_gives_no_warning(settings):
    assert load_and_list(settings) == []


def test_the_check_lists_warnings_as_text_and_as_json(call):
    Path("mine.toml").write_text('base = "paper"\n[targets]\nA = [4, 0.3, 0]\n[flow]\nspeed = 0\n')
    text = call("scenarios", "check", "mine.toml")
    assert text.exit_code == 0
    assert text.stdout.startswith("mine.toml is valid, with 2 warnings")
    warned = [line for line in text.stdout.splitlines() if line.startswith("warning: ")]
    found = json.loads(call("scenarios", "check", "mine.toml", "--json").stdout)
    assert [f"warning: {line}" for line in found["warnings"]] == warned
    assert len(warned) == 2


def test_a_search_warns_before_its_first_flight_and_keeps_stdout_for_json(run, tmp_path):
    settings = ("paper", "--set", "targets={A=[1,0.3,0]}", "--evaluations", 2, "--workers", 1, "--simulator", "native")
    done = run("evolve", *settings, "--out", "run", "--json", cwd=tmp_path)
    first = done.stderr.splitlines()[0]
    assert first.startswith("warning: no flight leaves the vertical plane")
    assert [f"warning: {line}" for line in json.loads(done.stdout)["warnings"]] == [first]


@pytest.mark.long
def test_a_run_says_the_commonest_reason_of_its_failures(run, tmp_path):
    settings = ("paper", "--set", "pipe.segments.0.radius=0.0135", "--set", "targets={A=[1,0,0]}", "--seed", 1)
    options = ("--evaluations", 12, "--workers", 1, "--simulator", "native", "--strategy", "random")
    printed = run("evolve", *settings, *options, "--out", "run", cwd=tmp_path).stdout
    found = json.loads(run("resume", "run", "--workers", 1, "--json", cwd=tmp_path).stdout)
    failed, failure = found["failed"], found["commonest_failure"]
    assert 0 < failure["count"] <= failed < 12
    assert "in a bore of 27 mm" in failure["reason"]
    assert f"failed most often ({failure['count']} of {failed}): {failure['reason']}" in printed
    run("report", "run", cwd=tmp_path)
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert f"{failed} of 12 flights failed, {failure['count']} of them like this: {failure['reason']}" in page
