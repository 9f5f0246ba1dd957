"""Fitness against flights, a panel for each target."""

import numpy as np
import pytest

from driftform.figures.trend import Trend, trend_svg

FLIGHTS = np.array([10.0, 20.0, 30.0])


def trend(name="TP1", fitness=((90.0, 94.0, 98.0), (92.0, 96.0, 100.0)), random=((90.0, 91.0, 92.0),)):
    return Trend(name, FLIGHTS, np.array(fitness), np.array(random).reshape(-1, 3))


def drawn(read, *trends, title="Fitness"):
    return read(trend_svg(trends, title, "the search"))


def test_the_mean_over_repeats_is_drawn_where_the_axes_say(read, points):
    picture = drawn(read, trend())
    # The grid lines carry the values of fitness at their left ends.
    lines = [
        (float(text.text), points(line)[0, 1])
        for line in picture.root.iter("{http://www.w3.org/2000/svg}line")
        for text in picture.root.iter("{http://www.w3.org/2000/svg}text")
        if line.get("stroke") == "#e6ebef"
        and text.get("text-anchor") == "end"
        and (text.text or "").replace(".", "").isdigit()
        and abs(float(text.get("y")) - 4 - points(line)[0, 1]) < 0.01
    ]
    slope, shift = np.polyfit([y for _, y in lines], [value for value, _ in lines], 1)
    mean = points(picture.one("mean"))
    assert slope * mean[:, 1] + shift == pytest.approx([91, 95, 99], abs=0.02)
    # Ten flights to the right each: the panel begins at zero.
    assert np.diff(mean[:, 0]) == pytest.approx(np.diff(mean[:, 0])[0], abs=0.02)


def test_the_deviation_reaches_from_the_lowest_to_the_highest_of_two_repeats(read, points):
    bars = points(drawn(read, trend()).one("deviation")).reshape(-1, 2, 2)
    mean = points(drawn(read, trend()).one("mean"))
    assert bars.mean(axis=1) == pytest.approx(mean, abs=0.02)
    assert (bars[:, 1, 1] > bars[:, 0, 1]).all()


def test_one_run_alone_has_neither_deviation_nor_random_search(read):
    picture = drawn(read, trend(fitness=((90.0, 94.0, 98.0),), random=()))
    assert not picture.all("deviation") and not picture.all("band")
    assert any("one run" in text for text in picture.texts)
    assert "random search" not in picture.texts


@pytest.mark.parametrize("count", [1, 3, 10, 23])
def test_any_number_of_targets_fits_in_the_picture_and_no_text_covers_another(read, count):
    picture = drawn(read, *(trend(f"target-{i}") for i in range(count)))
    assert len(picture.all("mean")) == count
    assert picture.outside() == []
    assert picture.overlapping_texts() == []
