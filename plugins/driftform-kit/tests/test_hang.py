"""``driftform trim --net-weight``: a print of any outside gets the net weight of the design."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.agent import mass_properties
from driftform.design.opening import open_agent
from driftform.water.disturbances import Condition
from driftform.water.prints import disturb_body
from driftform_kit.hang import ADDED, find_reading, trim_in_water


def find_net_weight(agent, fluid):
    return agent.mass.mass - fluid.density * agent.mass.volume


WORD = "addF-tiltp-2-L-moveF-addF-tiltn-1-L-moveF-addB-tiltn-2-L-moveB-addB-tiltp-2-L-moveB"
CALM = Condition()
WATER = ["fluid.density=999.1", "fluid.expansion=1.51e-4", "fluid.celsius=15"]


@pytest.fixture(scope="module")
def design():
    neutral = ["builder.core_mass=0.02507", "flow.speed=2.0", "flight.horizon=3.0"]
    return open_agent(WORD, "paper", [*neutral, *WATER])


@pytest.mark.parametrize("celsius", [5.0, 15.0, 24.0])
@pytest.mark.parametrize("outside", [-1e-4, 1e-4])
def test_a_print_that_is_trimmed_in_a_bucket_has_the_designs_net_weight_in_the_main(design, celsius, outside):
    fluid, body = design.scenario.fluid, design.agent.body
    printed = disturb_body(replace(CALM, outside=outside, mass=1.02), body, fluid)
    # The sealed print hangs in the bucket: Archimedes at its own temperature.
    bucket = disturb_body(replace(CALM, warmer=celsius - 15), printed, fluid)
    there = mass_properties(bucket)
    shown = there.mass - fluid.density_at(celsius) * there.volume
    facts = trim_in_water(design, shown, celsius)
    assert abs(facts["missing"]) > 5e-5
    # What is missing is added as a piece that displaces water, or as foam.
    added = facts["added"]["steel"] if facts["added"] else -35.0 * -facts["foam"]
    volume = added / 7850.0 if facts["added"] else facts["foam"]
    main = mass_properties(printed)
    net = main.mass + added - 999.1 * (main.volume + volume)
    # The volume of the print, off by 2 ml, counts with the difference of two densities of water.
    assert net == pytest.approx(find_net_weight(design.agent, fluid), abs=1e-5)


def test_the_reading_follows_the_temperature_of_the_bucket_and_the_pressure(design):
    fluid, agent = design.scenario.fluid, design.agent
    assert find_reading(agent, fluid, 15.0) == pytest.approx(find_net_weight(agent, fluid), abs=1e-12)
    # 93e-6 1/K of ABS, thrice, are more than the expansion of water of 15 degrees C.
    step = find_reading(agent, fluid, 15.5) - find_reading(agent, fluid, 14.5)
    assert step == pytest.approx(-999.1 * agent.mass.volume * (3 * 93e-6 - 1.51e-4), rel=0.01)
    body = replace(agent.body, squeeze=0.01)
    squeezed = replace(agent, body=body, mass=mass_properties(body))
    lighter = find_reading(squeezed, fluid, 15.0) - find_net_weight(squeezed, fluid)
    assert lighter == pytest.approx(-0.01 * 999.1 * agent.mass.volume, rel=1e-6)


def test_what_is_added_outside_weighs_what_is_missing_under_water(design):
    fluid = design.scenario.fluid
    facts = trim_in_water(design, find_net_weight(design.agent, fluid) - 0.002)
    assert facts["missing"] == pytest.approx(0.002)
    for name, mass in facts["added"].items():
        assert mass - 999.1 * mass / ADDED[name] == pytest.approx(0.002)
    assert np.diff(list(facts["added"].values())).max() > 0 and facts["foam"] == 0
    heavy = trim_in_water(design, find_net_weight(design.agent, fluid) + 0.002)
    assert heavy["foam"] * (999.1 - 35.0) == pytest.approx(0.002) and heavy["added"] == {}


def test_untrimmed_it_flies_with_the_net_weight_that_the_scale_shows(done):
    arguments = ("--simulator", "native", "--json", "--set", "flow.speed=2.0", "--set", "builder.core_mass=0.02507")
    shown = done("trim", WORD, *arguments, "--net-weight", "0.5", "--scenario", "paper")
    heavier = shown["net_weight"] - shown["flight_net_weight"]
    # The same weight at the core, by another road.
    heavy = ("--set", f"builder.core_mass={0.02507 + heavier!r}")
    flown = done("simulate", WORD, *arguments[:-2], *heavy, "--scenario", "paper")
    assert shown["untrimmed"] == pytest.approx(flown["fitness"], abs=0.05)
    text = done("trim", WORD, *arguments[:2], *arguments[3:], "--net-weight", "0.5", "--scenario", "paper")
    assert "should weigh" in text and "cm3 of foam" in text


def test_what_no_scale_under_water_shows_is_refused(refused):
    for arguments, words in (
        (("--net-weight", "300"), "hangs under water"),
        (("--net-weight", "1", "--kit"), "--kit: does not go with --net-weight"),
        (("--net-weight", "1", "--water-temperature", "290"), "degrees C"),
        (("--water-temperature", "20"), "goes with --net-weight"),
    ):
        assert words in refused("trim", WORD, *arguments, "--scenario", "paper", "--simulator", "native")


def test_a_difference_that_the_scale_does_not_show_needs_nothing(design):
    wanted = find_net_weight(design.agent, design.scenario.fluid)
    assert trim_in_water(design, wanted + 2e-5)["foam"] == 0
    assert trim_in_water(design, wanted - 2e-5)["added"] == {}
