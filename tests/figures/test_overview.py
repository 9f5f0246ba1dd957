from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.figures.gallery import GalleryEntry
from driftform.figures.overview import overview_svg
from driftform.water import Scenario

RISE = {"TP5": 0.001, "TP6": 0.07, "TP7": -0.07, "TP8": 0.098, "TP9": -0.024, "TP10": 0.013}


@pytest.fixture(scope="module")
def flights(fly, make_agent):
    return [
        GalleryEntry(name, make_agent(0.02 + 0.02 * i, 0.05, [0.012, 0.03 + 0.01 * i, 0.02]), fly(rise=rise), 0.1 * i)
        for i, (name, rise) in enumerate(RISE.items())
    ]


def test_each_flight_is_firm_up_to_its_closest_approach_and_faint_all_along(read, points, pipe, flights):
    picture = read(overview_svg(flights, pipe, "Six"))
    firm, faint = picture.all("firm"), picture.all("faint")
    assert len(firm) == len(faint) == len(flights)
    for flight, line, whole in zip(flights, firm, faint, strict=True):
        course = np.array([1, 0, RISE[flight.name]])
        foot = course * (course @ pipe.targets[flight.name]) / (course @ course)
        assert picture.to_world(points(line))[-1] == pytest.approx(foot[[0, 2]], abs=2e-3)
        assert picture.to_world(points(whole))[-1, 0] == pytest.approx(9, abs=2e-3)


def test_targets_are_crosses_where_the_axes_say_in_the_colour_of_their_flight(read, points, pipe, flights):
    picture = read(overview_svg(flights, pipe, "Six"))
    crosses = picture.all("target")
    places = picture.to_world(np.array([points(e).mean(axis=0) for e in crosses]))
    assert places == pytest.approx(pipe.target_array()[:, [0, 2]], abs=1e-3)
    assert [e.get("stroke") for e in crosses] == [e.get("stroke") for e in picture.all("firm")]
    assert len({e.get("stroke") for e in crosses}) == len(flights)


def test_the_bodies_of_the_gallery_share_the_scale_of_the_bar(read, points, pipe, flights):
    picture = read(overview_svg(flights, pipe, "Six"))
    bar = np.ptp(points(picture.one("scale-bar"))[:, 0])
    px_per_m = bar / (0.001 * float(picture.one("scale-bar-label").text.removesuffix(" mm")))
    for flight, outline in zip(flights, picture.all("outline"), strict=True):
        drawn = np.ptp(points(outline), axis=0)
        body = flight.agent.body
        assert drawn == pytest.approx(px_per_m * np.array([body.length, body.max_diameter]), abs=0.05)


def test_targets_that_share_a_flight_share_a_line_in_the_gallery_and_a_colour(read, pipe, flights):
    shared = [replace(flights[1], name=name, value=error) for name, error in (("TP6", 0.1), ("TP9", 2.5))]
    picture = read(overview_svg([flights[0], *shared, flights[2]], pipe, "Shared"))
    assert len(picture.all("outline")) == 3
    assert {"TP6, TP9", "0.10, 2.50 %"} <= set(picture.texts)
    assert any(text.startswith("3 flights") for text in picture.texts)
    colours = dict(zip(pipe.target_names, (e.get("stroke") for e in picture.all("target")), strict=True))
    assert colours["TP6"] == colours["TP9"] != colours["TP5"]
    assert picture.overlapping_texts() == []


@settings(deadline=None, max_examples=25)
@given(data=st.data())
def test_any_bodies_and_any_number_of_them_keep_to_the_page(read, fly, pipe, agents, data):
    bodies = data.draw(st.lists(agents, max_size=12))
    flights = [GalleryEntry(f"F{i}", agent, fly(samples=5), 99.99) for i, agent in enumerate(bodies)]
    picture = read(overview_svg(flights, pipe, "Some"))
    assert picture.outside() == []
    assert picture.overlapping_texts() == []


def test_a_flight_whose_name_is_not_a_target_is_cut_at_the_nearest(read, points, pipe, fly, make_agent):
    flight = GalleryEntry("mine", make_agent(0.05, 0.05, [0.02, 0.02]), fly(), 1.0)
    picture = read(overview_svg([flight], pipe, "One"))
    assert picture.to_world(points(picture.one("firm")))[-1] == pytest.approx([4.5, 0], abs=2e-3)


def test_open_water_has_no_targets_to_cut_at(read, points, fly, make_agent):
    flight = GalleryEntry("mine", make_agent(0.05, 0.05, [0.02, 0.02]), fly(), 1.0)
    picture = read(overview_svg([flight], Scenario(), "One"))
    assert picture.outside() == []
    assert points(picture.one("firm"))[-1] == pytest.approx(points(picture.one("faint"))[-1])
