"""In what an agent's surroundings depart from those of its design is said, with numbers."""

import pytest

from driftform.design.opening import open_agent


@pytest.fixture
def agent(finished_run):
    return str(finished_run[0] / "best" / "TP1" / "agent.json")


def test_an_agent_in_the_surroundings_of_its_design_departs_in_nothing(agent):
    assert open_agent(agent).list_departures() == []
    assert open_agent(agent, settings=["flow.speed=1.005", "simulator.use=native"]).list_departures() == []


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("fluid.density=1000", ["1000 kg/m3", "1024 kg/m3"]),
        ("flow.speed=0.8", ["0.8 m/s", "1 m/s"]),
        ("flow.kind=log_law", ["'log_law'", "'uniform'"]),
        ("pipe.segments.0.radius=0.9", ["0.9 m", "1 m"]),
        ("pipe.segments.0.end.0=12", ["course"]),
        ("contact.friction=0.3", ["friction"]),
        ("hydrodynamics.drag=strips", ["'strips'", "'none'"]),
        ("builder.hull_density=1100", ["it weighs", " g, and "]),
    ],
)
def test_each_departure_is_named_with_its_numbers(agent, setting, words):
    first, last = open_agent(agent, settings=[setting]).list_departures()
    assert all(word in first for word in words), first
    assert last.startswith("it was not evolved for this (net buoyancy ")


def test_the_net_buoyancy_of_both_waters_is_right(agent):
    fresh = open_agent(agent, settings=["fluid.density=1000"])
    there = fresh.mass.volume * 1000 * 9.81 - fresh.mass.mass * 9.81
    assert f"(net buoyancy {there:+.3f} N, and {open_agent(agent).net_buoyancy:+.3f} N" in fresh.list_departures()[-1]


def test_a_word_has_no_design_to_depart_from():
    word = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
    assert open_agent(word, settings=["fluid.density=1000"]).list_departures() == []


@pytest.mark.long
def test_simulate_and_inspect_warn(agent, call):
    options = ("--set", "fluid.density=1000", "--set", "simulator.use=native")
    result = call("simulate", agent, *options)
    assert "warning: the water has 1000 kg/m3" in result.stderr, result.output
    assert "the water has 1000 kg/m3" in call("inspect", agent, *options).stdout
