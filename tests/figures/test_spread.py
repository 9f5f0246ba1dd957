"""Flights of one agent under different conditions."""

import numpy as np
import pytest

from driftform_paper.report import compute_band, spread_svg


def test_the_band_is_the_deviation_of_the_height_along_the_pipe(fly):
    flights = [fly(rise=rise) for rise in (-0.05, 0.05)]
    paths, mean, deviation = compute_band(flights, np.array([8.0, 0.0, 0.0]))
    assert len(paths) == 2
    assert mean[:, 2] == pytest.approx(np.zeros(len(mean)), abs=1e-9)
    assert deviation == pytest.approx(0.05 * mean[:, 0], abs=1e-6)


def test_every_path_ends_at_its_closest_approach(fly):
    [path], mean, deviation = compute_band([fly(rise=0.1)], np.array([3.0, 0.0, 0.5]))
    # The foot of the perpendicular from the target: (3 + 0.05) / (1 + 0.01).
    assert path[-1, 0] == pytest.approx(3.05 / 1.01, abs=1e-3)
    assert mean[-1, 0] == pytest.approx(path[-1, 0])
    assert deviation.max() == 0


def test_there_is_a_panel_with_all_flights_for_each_target(read, pipe, fly, points):
    repeats = {name: ([fly(rise=rise) for rise in (0.0, 0.02, 0.04)], "a note") for name in pipe.targets}
    picture = read(spread_svg(repeats, pipe, "Flown again", "Three times each."))
    assert len(picture.all("mean")) == len(picture.all("band")) == len(picture.all("target")) == len(pipe.targets)
    assert picture.outside() == []
    assert picture.overlapping_texts() == []


def test_a_flight_that_was_released_past_its_target_is_drawn_as_a_point(read, pipe, fly):
    backwards = {"TP5": ([fly(samples=1), fly(samples=1)], "")}
    assert read(spread_svg(backwards, pipe, "t", "d")).outside() == []
