"""What a strategy found: an archive as a map of its cells, a front as points."""

import numpy as np
import pytest

from driftform.figures.result import result_svg
from driftform.interfaces import Result

COLUMNS = {
    "mass": np.array([0.11, 0.12, 0.19]),
    "length": np.array([0.0, 0.01, 0.3]),
    "fitness": np.array([50.0, 60.0, 99.0]),
}


def test_the_best_of_each_cell_colours_it(read):
    grid = [(0.1, 0.2, 5), (0.0, 0.3, 3)]
    picture = read(result_svg(Result("Kept.", COLUMNS, ("mass", "length"), grid, "fitness"), "Archive", {"mass": "kg"}))
    low, high = picture.all("cell")
    swatches = [swatch.get("fill") for swatch in picture.all("swatch")]
    assert [cell.get("fill") for cell in (low, high)] == [swatches[0], swatches[-1]]
    assert float(low.get("x")) < float(high.get("x")) and float(low.get("y")) > float(high.get("y"))
    assert float(low.get("width")) == pytest.approx((float(high.get("x")) - float(low.get("x"))) / 4, abs=0.02)
    assert {"Kept. 2 of 15 cells are filled.", "mass (kg)", "best fitness of the cell", "60", "99"} <= set(
        picture.texts
    )
    assert picture.outside() == [] and picture.overlapping_texts() == []


@pytest.mark.parametrize("rows", [0, 1, 3])
def test_each_row_of_a_front_is_a_point_however_few_there_are(read, rows):
    columns = {name: values[:rows] for name, values in COLUMNS.items()}
    picture = read(result_svg(Result("A front.", columns, ("mass", "fitness")), "Front", {"fitness": "%"}))
    places = [(float(dot.get("cx")), -float(dot.get("cy"))) for dot in picture.all("row")]
    assert places == sorted(places) and len(places) == rows
    assert picture.outside() == []


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"columns": {"mass": [0.1], "length": [0.1, 0.2]}}, "as many in each"),
        ({"columns": {"mass": [np.nan]}}, "finite numbers"),
        ({"axes": ("mass", "weight")}, "or none, of mass, length, fitness"),
        ({"axes": ("mass", "length"), "grid": [(0.0, 1.0, 5), (1.0, 1.0, 5)], "colour": "fitness"}, "1 to 1000 cells"),
    ],
)
def test_a_result_that_cannot_be_drawn_is_refused(values, words):
    with pytest.raises(ValueError, match=words):
        Result(**{"meaning": "A table.", "columns": COLUMNS} | values)
