import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.figures.layout import MINUS
from driftform.figures.reach import reach_svg
from driftform.figures.style import RAMP
from driftform.runs.coverage import BOUNDS, CoverageMap, PipeGrid, map_coverage
from driftform.water import Pipe, Scenario, Segment


@pytest.fixture(scope="module")
def rising(fly):
    return [(i, fly(rise=rise)) for i, rise in enumerate((0.0, 0.03, 0.07, -0.05, 0.1))]


@pytest.fixture(scope="module")
def reach(pipe, rising):
    return map_coverage(rising, PipeGrid.of_scenario(pipe))


def boxes(path):
    """The lower left corners and the extents of the rectangles that a path is made of, px, (n, 4)."""
    found = []
    for part in path.get("d").split("Z")[:-1]:
        corners = np.array([[float(v) for v in pair.split()] for pair in part[1:].split("L")])
        low, high = corners.min(axis=0), corners.max(axis=0)
        found.append([*low, *(high - low)])
    return np.array(found)


def cells_of(picture, path, cells):
    """The cells whose middles lie inside the rectangles of a path."""
    found = set()
    for left, top, width, height in boxes(path):
        low, high = picture.to_world(np.array([[left, top + height], [left + width, top]]))
        centres = cells.centres()
        inside = ((centres > low) & (centres < high)).all(axis=1)
        found |= set(np.flatnonzero(inside).tolist())
    return found


def test_every_cell_has_the_colour_of_its_closest_flight(read, pipe, reach):
    picture = read(reach_svg(reach, pipe, "Some"))
    drawn = {path.get("fill"): cells_of(picture, path, reach.cells) for path in picture.all("reached")}
    for number, colour in enumerate(RAMP):
        low, high = (0.0, *BOUNDS)[number], (*BOUNDS, np.inf)[number]
        here = (reach.distance >= low) & (reach.distance < high)
        assert drawn.get(colour, set()) == set(np.flatnonzero(here & reach.reached).tolist())


def test_what_no_flight_crosses_is_white_and_hatched(read, pipe, reach):
    picture = read(reach_svg(reach, pipe, "Some"))
    bare = picture.one("unreached")
    assert bare.get("fill") == "#ffffff"
    assert cells_of(picture, bare, reach.cells) == set(np.flatnonzero(~reach.reached).tolist())
    assert picture.all("hatching")[0].get("d").count("M") == np.count_nonzero(~reach.reached)


def test_without_flights_all_is_bare_and_with_all_cells_lit_nothing_is(read, pipe):
    cells = PipeGrid.of_scenario(pipe)
    empty, full = CoverageMap(cells), CoverageMap(cells)
    full.visits[:], full.distance[:] = 1, 0.003
    nothing, everything = (read(reach_svg(r, pipe, "All or nothing")) for r in (empty, full))
    assert nothing.all("reached") == [] and len(nothing.all("unreached")) == 1
    assert everything.all("unreached") == [] and len(everything.all("reached")) == 1
    assert any("0 flights cross 0 of 1800 cells of 10 cm x 10 cm (0.0 %)" in text for text in nothing.texts)


def test_targets_are_crosses_with_names_where_the_axes_say(read, points, pipe, reach):
    picture = read(reach_svg(reach, pipe, "Some"))
    places = picture.to_world(np.array([points(e).mean(axis=0) for e in picture.all("target")]))
    assert places == pytest.approx(pipe.target_array()[:, [0, 2]], abs=1e-3)
    assert set(pipe.target_names) <= set(picture.texts)


def test_the_legend_has_every_colour_and_the_distances_between_them(read, points, pipe, reach):
    picture = read(reach_svg(reach, pipe, "Some"))
    swatches = picture.all("swatch")
    assert [swatch.get("fill") for swatch in swatches] == list(RAMP)
    texts = {e.text: points(e) for e in picture.root.iter() if e.tag.endswith("text")}
    for bound, swatch in zip(BOUNDS, swatches, strict=False):
        label = texts[f"{1000 * bound:g}"]
        assert label[:, 0].mean() == pytest.approx(points(swatch)[1, 0], abs=1)
    assert "no flight" in texts


segments = (
    st.tuples(*[st.tuples(*[st.floats(-20, 20)] * 3)] * 2, st.floats(0.2, 3))
    .filter(lambda s: np.linalg.norm(np.subtract(s[1], s[0])) > 1)
    .map(lambda s: Segment(start=s[0], end=s[1], radius=s[2]))
)


@pytest.mark.long
@settings(deadline=None, max_examples=25)
@given(segment=segments, name=st.text("abcW", min_size=1, max_size=20))
def test_any_pipe_keeps_to_the_page_and_its_labels_apart(read, segment, name):
    middle = tuple(np.add(segment.start, segment.end) / 2)
    scenario = Scenario(pipe=Pipe(segments=(segment,)), targets={name: middle})
    picture = read(
        reach_svg(CoverageMap(PipeGrid.of_scenario(scenario)), scenario, "Any pipe there may be, with a title " * 4)
    )
    assert picture.outside() == []
    assert picture.overlapping_texts() == []


def test_the_axes_are_the_worlds_where_the_pipe_lies_along_x_and_the_maps_elsewhere(read, pipe):
    along_x = Segment(start=(3.0, 0.0, -5.0), end=(12.0, 0.0, -5.0), radius=1.0)
    upright = Segment(start=(3.0, 0.0, -5.0), end=(3.0, 0.0, 4.0), radius=1.0)
    texts = []
    for segment in (along_x, upright):
        scenario = Scenario(pipe=Pipe(segments=(segment,)))
        texts.append(set(read(reach_svg(CoverageMap(PipeGrid.of_scenario(scenario)), scenario, "")).texts))
    assert {"x (m)", "z (m)", "12", f"{MINUS}5.0"} <= texts[0]
    assert {"along the pipe (m)", "up (m)", "9", "0.0"} <= texts[1]
