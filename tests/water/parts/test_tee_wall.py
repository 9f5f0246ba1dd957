"""The wall of a tee as the flow sees it, against its definition."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.water.parts.tee_wall import Junction, wall_level
from driftform.water.parts.walls import edge_point

JUNCTIONS = [
    Junction(0.5, math.pi / 2, 0.1),
    Junction(1.0, math.pi / 2, 0.2),
    Junction(1.0, math.radians(60), 0.2),
    Junction(0.3, math.radians(35), 0.03),
]


def near_wall(junction, seed):
    """A point within two fillets of the rounded edge, or of one of the bores beyond it."""
    rng = np.random.default_rng(seed)
    centre = np.array(edge_point(rng.uniform(0, math.pi), junction.array(), 0)[0])
    centre[1] *= rng.choice([-1, 1])
    return centre + 2 * junction.fillet * rng.uniform(-1, 1, 3)


@pytest.mark.parametrize("junction", JUNCTIONS)
@settings(max_examples=200)
@given(seed=st.integers(0, 2**32))
def test_the_level_is_a_distance(junction, seed):
    point, wall, h = near_wall(junction, seed), junction.array(), 1e-6
    level, normal = wall_level(*point, wall)
    if abs(level) > 0.3 * junction.fillet:
        return
    slope = [
        (wall_level(*(point + h * e), wall)[0] - wall_level(*(point - h * e), wall)[0]) / (2 * h) for e in np.eye(3)
    ]
    assert slope == pytest.approx(normal, abs=1e-4)
    foot = point - level * np.array(normal)
    assert wall_level(*foot, wall)[0] == pytest.approx(0, abs=1e-9)
