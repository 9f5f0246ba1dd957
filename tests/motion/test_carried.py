"""Neutral bodies in turbulent water: flights with inertia, not tracers."""

import math

import pytest
from carried import Carrying

from driftform.testing.bodies import spheroid_body


def test_neutral_balls_do_not_gather_at_the_wall_of_a_narrow_main():
    count = 80
    [found] = Carrying(spheroid_body(0.03, 0.03), 0.15, 1.0, (6,)).observe(count)
    assert found.outer == pytest.approx(0.1, abs=3 * math.sqrt(0.09 / count))
    assert found.touching <= 0.06
    assert found.speed == pytest.approx(1.0, abs=0.02)
