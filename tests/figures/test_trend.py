"""Fitness against flights, a panel for each target."""

import numpy as np
import pytest

from driftform.figures.trend import POINTS, Curve, choose_points, trend_svg

FLIGHTS = np.array([10.0, 20.0, 30.0])
TWO = np.array([[90.0, 94.0, 98.0], [92.0, 96.0, 100.0]])


def drawn(read, panels, title="Fitness"):
    return read(trend_svg(panels, title, "Best so far"))


def test_the_mean_over_repeats_is_drawn_where_the_axes_say(read, points):
    picture = drawn(read, {"TP1": [Curve.of_mean("search", FLIGHTS, TWO)]})
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
    edges = slope * points(picture.one("band"))[:, 1] + shift
    assert edges == pytest.approx([90, 94, 98, 100, 96, 92], abs=0.02)


@pytest.mark.parametrize("count", [1, 3, 10, 23])
def test_any_number_of_targets_and_searches_fits_in_the_picture_and_no_text_covers_another(read, count):
    curves = [Curve.of_mean(f"a search by the name of {k}", FLIGHTS, TWO[:1]) for k in range(count)]
    picture = drawn(read, {f"target-{i}": curves for i in range(count)})
    assert len(picture.all("mean")) == count**2
    assert not picture.all("band"), "one run has no spread"
    assert picture.outside() == []
    assert picture.overlapping_texts() == []


def test_a_curve_of_many_flights_is_drawn_at_a_few_and_ends_with_the_last():
    assert choose_points(3).tolist() == [1, 2, 3]
    assert len(choose_points(10_000)) == POINTS and choose_points(10_000)[-1] == 10_000
