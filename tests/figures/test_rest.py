"""Where a body floats: against Archimedes, in words and on the page."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.figures.layout import MINUS
from driftform.figures.rest import describe_rest
from driftform.figures.section import section_svg
from driftform.motion.forces.model import flight_model
from driftform.motion.path.stability import stable_rest
from driftform.water import Fluid, Scenario

DENSITY = 1000.0
RADIUS, LENGTH = 0.02, 0.2


def water(**options):
    return Scenario(fluid=Fluid(density=DENSITY, **options))


@pytest.fixture
def tube(make_agent):
    """A cylinder from x = -0.1 m to 0.1 m, of a given share of the water's density, its COG at ``cog``."""

    def make(share, cog=0.0):
        agent = make_agent(LENGTH / 2, LENGTH / 2, [RADIUS] * 5)
        mass = share * DENSITY * agent.mass.volume
        inertia = mass * np.diag([RADIUS**2 / 2, LENGTH**2 / 12, LENGTH**2 / 12])
        properties = replace(agent.mass, mass=mass, cog=[cog, 0, 0], cob=[0, 0, 0], inertia=inertia)
        return replace(agent, mass=properties)

    return make


def test_a_long_log_of_half_the_density_floats_level_with_its_axis_in_the_surface(tube):
    rest = stable_rest(flight_model(tube(0.5), water(water_level=0.0)))
    assert rest.pitch == pytest.approx(0, abs=0.02)
    assert rest.height == pytest.approx(0, abs=1e-4)
    assert "float level, 50 % under water" in describe_rest(tube(0.5), water())


@pytest.mark.parametrize(("cog", "nose"), [(-0.08, "nose up"), (0.08, "nose down")])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
def test_a_float_with_a_weight_at_one_end_floats_upright_as_deep_as_archimedes_says(tube, share, cog, nose):
    assert f"upright, {nose}, {100 * share:.0f} %" in describe_rest(tube(share, cog), water())
    # The heavy end is below; of the length, that share is under water.
    draft = LENGTH / 2 - stable_rest(flight_model(tube(share, cog), water(water_level=0.0))).height
    assert draft == pytest.approx(share * LENGTH, abs=2e-3)


def test_a_body_heavier_than_water_sinks_and_hangs_by_its_centre_of_buoyancy(tube):
    assert describe_rest(tube(1.2, 0.05), water()) == "Sinks and hangs upright, nose down."
    assert describe_rest(tube(1.2, -0.05), water()) == "Sinks and hangs upright, nose up."
    assert describe_rest(tube(1.2), water()) == "Sinks and hangs in any attitude."


def test_the_text_depends_on_whether_the_scenario_has_a_surface(tube):
    assert describe_rest(tube(0.5), water()).startswith("Rises; at a surface it would float")
    assert describe_rest(tube(0.5), water(water_level=0.3)).startswith("Floats level")


def test_net_buoyancy_is_that_of_the_scenario_s_water(read, tube):
    agent = tube(0.5)
    newtons = 0.5 * DENSITY * agent.mass.volume * 9.81
    assert f"+{newtons:.3g} N" in read(section_svg(agent, "", water())).texts
    assert any("N" in text and text.startswith(MINUS) for text in read(section_svg(tube(1.2), "", water())).texts)
    assert not any(text.endswith(" N") for text in read(section_svg(agent)).texts)


@settings(deadline=None, max_examples=40)
@given(data=st.data(), fluid=st.sampled_from([None, Fluid(), Fluid(water_level=0.1)]), title=st.text(max_size=200))
def test_any_body_in_water_or_not_gives_a_picture_that_keeps_to_its_page(read, agents, data, fluid, title):
    scenario = fluid and Scenario(fluid=fluid)
    picture = read(section_svg(data.draw(agents), title, scenario))
    assert picture.outside() == []
    assert picture.overlapping_texts() == []
