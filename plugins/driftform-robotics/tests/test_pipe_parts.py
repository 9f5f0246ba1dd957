"""The wall of a pipe with parts as boxes: none reaches into the water, and none of a sphere's ways through the wall is open."""

import numpy as np
import pytest

from driftform.water import Scenario
from driftform_robotics.models.pipe import list_bores

PARTS = [
    {"length": 0.5},
    {"kind": "bend", "radius": 0.3, "roll_deg": 90},
    {"kind": "tee", "branch_radius": 0.05, "share": 0.3, "branch": [{"length": 0.3, "outlet": "up"}]},
    {"kind": "reducer", "length": 0.2, "radius": 0.07},
    {"length": 0.3, "outlet": "on"},
]


@pytest.fixture(scope="module")
def boxes():
    """Position, axes (columns) and half size of every box of the wall, in the world frame."""
    pipe = Scenario.model_validate({"pipe": {"radius": 0.1, "parts": PARTS}}).pipe
    found = [
        (b.position + b.rotation @ p.position, b.rotation @ p.rotation, p.size / 2)
        for b in list_bores(pipe)
        for p in b.make_planks()
    ]
    return pipe, [np.array(values) for values in zip(*found, strict=True)]


def covers(boxes, point, margin=0.0):
    position, axes, half = boxes
    local = np.einsum("kji,kj->ki", axes, point - position)
    return bool((np.abs(local) <= half + margin).all(axis=1).any())


def test_the_water_along_the_axes_is_free(boxes):
    pipe, found = boxes
    for placed in pipe.layout.parts:
        for axis in placed.part.list_axes(0.02):
            for point, radius in zip(axis.points, axis.radii, strict=True):
                assert not covers(found, point, margin=0.5 * radius)


def test_the_wall_is_closed_except_where_the_branch_leaves(boxes):
    pipe, found = boxes
    rng = np.random.default_rng(0)
    for placed in pipe.layout.parts:
        if placed.part.list_exits()[0].radius == 0.05 or len(placed.part.list_exits()) > 1:
            continue
        axis = placed.part.list_axes(0.01)[0]
        for k in rng.integers(1, len(axis.points) - 1, size=20):
            along = axis.points[k + 1] - axis.points[k - 1]
            across = np.cross(along, rng.standard_normal(3))
            across /= np.linalg.norm(across)
            ray = axis.points[k] + axis.radii[k] * np.linspace(0.95, 1.08, 40)[:, None] * across
            assert any(covers(found, point) for point in ray)


def test_the_wall_of_the_run_is_open_into_the_branch(boxes):
    pipe, found = boxes
    [tee] = [placed.part for placed in pipe.layout.parts if len(placed.part.list_exits()) > 1]
    for height in np.linspace(0.0, tee.legs[2], 30):
        assert not covers(found, tee.origin + height * tee.branch_axes[0])
