"""A sealed print is trimmed by putty in its pockets, which sheet, check and accounts know."""

import json

import pytest
from prints import chain_body, job_of, weigh_meshes

from driftform import open_agent
from driftform.agent import MassElement, mass_properties
from driftform_frusta.kit_options import PartOptions
from driftform_kit.hang import find_reading, share_putty, trim_in_water
from driftform_kit.sheet.contents import plan_sheet

BODY = chain_body("ssssssss", "ssssss", made_as="kit", pockets={"diameter": 0.005})
PUTTY = [MassElement.of_putty(pocket) for pocket in BODY.pockets]
WATER = 1000.0


def test_parts_core_and_putty_weigh_and_balance_as_simulated_and_the_sheet_says_so():
    mass, cog, _ = weigh_meshes(BODY, PartOptions(kit=True, segments=96))
    whole, putty = mass_properties(BODY), sum(one.mass for one in PUTTY)
    assert mass + putty == pytest.approx(whole.mass, rel=1e-6)
    assert mass * cog[0] + sum(one.mass * one.x for one in PUTTY) == pytest.approx(whole.mass * whole.cog[0], abs=1e-8)
    sheet = plan_sheet(job_of(BODY), PartOptions(kit=True))
    table = {name: full for name, full, _ in sheet.weights}
    assert table["putty"] == pytest.approx(putty) and table["closed kit"] == pytest.approx(whole.mass, rel=1e-6)
    [step] = [text for text in sheet.steps if text.startswith("Press ")]
    assert all(
        f"{1e3 * one.mass:.2f}\u00a0g" in step and f"{1e3 * (one.x - BODY.outer[0, 0]):.1f}" in step for one in PUTTY
    )


@pytest.mark.parametrize("missing", [0.0012, -0.0009, 0.02])
def test_two_pockets_share_the_putty_so_that_weight_and_balance_are_right(missing):
    x = 0.01
    found = [change for change, _ in share_putty(BODY, missing, WATER, x)]
    weight = sum(one.mass for one in found) * (1 - WATER / 10_200)
    if missing == 0.02:
        # Both are full then.
        assert [one.mass for one in found] == pytest.approx([one.mass for one in PUTTY])
    else:
        assert weight == pytest.approx(missing)
        assert sum(one.mass * (one.x - x) for one in found) == pytest.approx(0, abs=1e-12)


def test_trim_and_check_say_what_the_pockets_of_a_sealed_print_take(call):
    word = "-".join(["addF-tiltp-0-L-moveF"] * 5 + ["addB-tiltn-1-L-moveB"] * 3)
    setting = "builder.pockets.diameter=0.005"
    agent, fluid = (design := open_agent(word, setting)).agent, design.scenario.fluid
    given = (
        word,
        "--set",
        setting,
        "--simulator",
        "native",
        "--net-weight",
        1e3 * find_reading(agent, fluid, fluid.celsius) - 1.0,
    )
    facts = json.loads(call("trim", *given, "--json").stdout)
    assert facts["missing"] == pytest.approx(1e-3) and facts["rest"] == pytest.approx(0, abs=1e-9)
    assert facts["added"] == {} and facts["pockets"] and "trimmed" in facts["ends"]
    full = trim_in_water(design, find_reading(agent, fluid, fluid.celsius) - 0.004)
    water = 1 - fluid.density / 10_200
    assert full["rest"] == pytest.approx(0.004 - water * sum(pocket["change"] for pocket in full["pockets"]), rel=1e-3)
    assert "g of tungsten putty into the pocket at the " in call("trim", *given).stdout
    assert "changes the net weight by -" in call("check", word, "--set", setting, "--no-programs").stdout
