"""Misses under disturbed conditions, a strip for each target."""

import numpy as np
import pytest

from driftform.figures.strip import SMALLEST, Strip, strip_svg


def drawn(read, *strips):
    return read(strip_svg(strips, "Robustness", "Disturbed flights."))


def test_every_disturbed_flight_is_a_dot_at_its_miss(read, points):
    picture = drawn(read, Strip("TP1", 0.01, np.array([0.01, 0.1, 1.0]), 1.0))
    # The last mark is that of the legend.
    x = [points(dot).mean(axis=0)[0] for dot in picture.all("disturbed")]
    assert len(x) == 3
    assert x[1] - x[0] == pytest.approx(x[2] - x[1], abs=0.02), "decades are equally wide"
    nominal = points(picture.one("nominal"))
    assert nominal[:, 0].mean() == pytest.approx(x[0], abs=0.02)


def test_the_promised_miss_is_drawn_and_written(read, points):
    picture = drawn(read, Strip("TP1", 0.1, np.array([0.1, 0.3]), 0.25))
    assert "250 mm" in picture.texts
    x = [points(dot).mean(axis=0)[0] for dot in picture.all("disturbed")]
    assert x[0] < float(picture.one("promised").get("x1")) < x[1]


def test_misses_of_zero_or_without_a_bound_stay_on_the_page(read):
    picture = drawn(
        read, Strip("TP1", 0.0, np.array([0.0, SMALLEST / 10, 5.0]), 5.0), Strip("B", 2.0, np.full(2, np.inf), np.inf)
    )
    assert picture.outside() == []
    assert "unknown" in picture.texts


@pytest.mark.parametrize("count", [1, 10, 40])
def test_any_number_of_targets_fits_and_no_text_covers_another(read, count):
    rng = np.random.default_rng(1)
    strips = [Strip(f"target-{i}", 1.0, rng.uniform(0.001, 9, 20), 8.0) for i in range(count)]
    picture = drawn(read, *strips)
    assert picture.outside() == []
    assert picture.overlapping_texts() == []
