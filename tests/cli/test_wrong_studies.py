"""Studies that cannot do what their author wants: refused, or warned of, before the first flight.

A warning or a refusal comes within the first second of a command. That is processor time: other work on the machine
does not count.
"""

import json
import time
from pathlib import Path

import pytest

from driftform.errors import InputError
from driftform.study import load_study

pytestmark = pytest.mark.usefixtures("ideal_water")


PIPE = "pipe.segments=[{start=[0,0,0],end=[%s],radius=%s}]"
BEND = "pipe={segments=[],radius=%s,parts=[{length=1},{kind='bend',angle_deg=%s,radius=%s},{length=1}]}"
ONE = "targets={A=[4,0,0.2]}"

WRONG = {
    # What the author got wrong: the settings, "refused" or "warned", and what the line says.
    "the core's mass in grams": (["builder.core_mass=50"], "warned", "50 kg has a radius of 10 mm"),
    "the water's density in g/cm3": (["fluid.density=1.024"], "warned", "fluid.density = 1.024 kg/m3 is not"),
    "the viscosity in cSt": (["fluid.viscosity=0.9"], "warned", "1 cSt is 1e-6"),
    "the dynamic viscosity": (["fluid.viscosity=1.0e-3"], "warned", "it is kinematic"),
    "gravity in cm/s2": (["fluid.gravity=981"], "warned", "fluid.gravity = 981 m/s2 is not"),
    "the hull's density in g/cm3": (["builder.hull_density=1.05"], "warned", "ABS has 1050"),
    "the current in litres per second": (["flow.speed=80"], "warned", "flow.speed = 80 m/s is more than"),
    "a pipe that is wider than long": (
        [PIPE % ("1.2,0,0", 1), "targets={A=[1,0,0]}"],
        "warned",
        "1.2 m long and 2 m wide",
    ),
    "a surface above the pipe": (["fluid.water_level=3"], "warned", "whole pipe, whose top is at z 1 m"),
    "a surface below the release": (["fluid.water_level=-0.4"], "refused", "released above the water"),
    "a target in the air": (
        ["fluid.water_level=0.1"],
        "warned",
        "targets TP2, TP4, TP6 and TP8 lie above the water, by up to 600 mm",
    ),
    "a release past the targets": (["release.position=[8.8,0,0]"], "warned", "upstream of the release"),
    "a release in the wall": (["release.position=[0,0,-0.995]"], "refused", "radius 1000 mm"),
    "a release across a narrow pipe": (
        [PIPE % ("9,0,0", 0.05), "targets={A=[4,0,0.02]}", "release.pitch_deg=90"],
        "warned",
        "of 12 random agents cannot be released",
    ),
    "a target beside a vertical pipe's axis": (
        [PIPE % ("0,0,9", 1), "targets={A=[0.5,0,4]}"],
        "warned",
        "no flight leaves the pipe's axis, and target A lies off it, by up to 500 mm",
    ),
    "two targets at one point": (["targets={A=[1,0,0],B=[1,0,0]}"], "warned", "A and B are the same point"),
    "a current that turns round too soon": (["flow.acceleration=-1"], "warned", "passes at most 500 mm of the pipe"),
    "a horizon in milliseconds": (["flight.horizon=20000"], "warned", "more than 100 times the 9 s"),
    "friction in percent": (["contact.friction=8"], "warned", "more than rubber on concrete"),
    "a release that is off by metres": (
        ["robustness.conditions=5", "robustness.position=0.8"],
        "warned",
        "robustness.position = 0.8 m is large",
    ),
    "eddies that outlast the gusts": (
        ["gusts.smoothing=10"],
        "refused",
        "gusts.smoothing = 10: should be less than or equal to 1",
    ),
    "modules in millimetres": (["grammar.large=10"], "refused", "less than or equal to 0.5 m"),
    "microseconds between gusts": (["gusts.smoothing=0.001"], "refused", "should be greater than or equal to 0.01"),
    "gusts where they were once": (
        ["flow={kind='turbulent',intensity=1}"],
        "refused",
        "unknown key 'intensity' in [flow]",
    ),
    "oil with the profile of water": (
        ["fluid.viscosity=1e-3", "flow={kind='log_law',speed=1.0,upstream=1000}"],
        "warned",
        "Re_D = 2000; it holds from 4000 to 1e+08; take flow.kind = 'developed'",
    ),
    "water that is neither laminar nor turbulent": (
        ["fluid.viscosity=6e-4", "flow={kind='developed',speed=1.0,upstream=1000}"],
        "warned",
        "the profile is unknown from 2300 to 4000",
    ),
    "a flow that had no room to develop": (
        ["flow={kind='developed',speed=1.0}"],
        "warned",
        "set flow.upstream to the length of the same bore before the inlet",
    ),
    "a core of a metre": (["builder.core_radius=1"], "refused", "no agent can be released"),
    # Those that everybody makes.
    "a pipe in millimetres": ([PIPE % ("6000,0,0", 100), ONE], "warned", "divide millimetres by 1000"),
    "targets off the plane": (["targets={A=[4,0.3,0.2]}"], "warned", "by up to 300 mm: release the agent with a yaw"),
    "a current away from the targets": (["flow.speed=-1"], "warned", "carries an agent away from targets TP1"),
    "a slow current in a short flight": (
        ["flow.speed=0.01", "flight.horizon=5"],
        "warned",
        "set flight.horizon to more than 850 s",
    ),
    "no current": (["flow.speed=0"], "warned", "the water is at rest"),
    "a horizon that is too short": (["flight.horizon=3"], "warned", "set flight.horizon to more than 8.5 s"),
    "a body that fills the bore": (
        [PIPE % ("9,0,0", 0.02), "targets={A=[4,0,0]}"],
        "warned",
        "b = 0.5725; it holds from 0 to 0.3",
    ),
    "a target at the release": (
        ["targets={A=[0.05,0,0.02]}"],
        "warned",
        "target A lies 53.85 mm from the release, less than the length of an agent",
    ),
    "a target on the wall": (
        ["targets={A=[4,0,-0.998]}"],
        "warned",
        "no nearer than its radius, 11.45 mm: every agent misses by 9.45 mm or more",
    ),
    "a bend in radians": (
        [BEND % (0.1, 0.785, 0.3), "flow.kind=log_law", "targets={A=[0.8,0,0]}"],
        "warned",
        "angle_deg is in degrees, and 0.785 rad are 44.98 degrees",
    ),
    "the diameter of a pipe for its radius": (
        [BEND % (0.2, 45, 0.3), "flow.kind=log_law", "targets={A=[0.8,0,0]}"],
        "warned",
        "is pipe.radius a diameter?",
    ),
    "a bore narrower than the core": ([PIPE % ("9,0,0", 0.01), "targets={A=[4,0,0]}"], "refused", "in a bore of 20 mm"),
}


def load_and_list(settings):
    return load_study("paper", settings=[*settings, "run.seed=1"]).list_warnings()


def test_the_built_in_scenarios_give_no_warning():
    for name in ("paper", "pipe-inspection"):
        assert load_study(name).list_warnings() == []


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_study_is_refused_or_warned_of_in_the_first_second(name):
    settings, verdict, part = WRONG[name]
    load_and_list([])  # Imports are the same for all.
    began = time.process_time()
    if verdict == "refused":
        with pytest.raises(InputError) as caught:
            load_and_list(settings)
        lines = [str(line) for line in caught.value.args]
    else:
        lines = load_and_list(settings)
    assert time.process_time() - began < 1
    assert any(part in line for line in lines), lines
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
