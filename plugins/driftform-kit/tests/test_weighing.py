"""Kits that are weighed without being cut, against those that are cut."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.agent import solid_of_revolution
from driftform.errors import WorkFailedError
from driftform.types import Module, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.kit_options import KitOptions
from driftform_kit.cutting.accounting import kit_moments
from driftform_kit.cutting.bay import Ball, is_held
from driftform_kit.cutting.kernels import move_line, read_radius
from driftform_kit.cutting.pieces import _draw_parts, make_kit
from driftform_kit.cutting.weighing import plan_kit

TILTS = st.sampled_from([-0.8, -0.4, -0.2, 0.0, 0.0, 0.2, 0.4, 0.8])
SIDES = st.lists(st.builds(Module, st.sampled_from([0.004, 0.01, 0.02]), TILTS), max_size=14).map(tuple)
BODIES = st.builds(
    lambda fore, aft, clearance: FrustaBuilder(FrustaOptions(clearance=clearance)).build(
        Morphology(fore, aft)
    ),
    SIDES,
    SIDES,
    st.sampled_from([0.0002, 0.0002, 0.003]),
)
KITS = st.sampled_from(
    [
        KitOptions(),
        KitOptions(joint="rabbet"),
        KitOptions(joint="rabbet", clearance=0.0004, lap=0.01),
        KitOptions(joint="sleeve"),
        KitOptions(joint="sleeve", sleeve=0.0008, lap=0.004),
        KitOptions(sleeve=0.0016, lap=0.008, o_ring=0.0015),
        KitOptions(bed=(0.25, 0.21, 0.08)),
    ]
)


@settings(max_examples=150, deadline=None)
@given(BODIES, KITS)
def test_a_kit_weighs_what_its_parts_do_when_it_is_cut(body, options):
    try:
        kit = make_kit(body, options)
    except WorkFailedError:
        return
    planned, cut = plan_kit(body, options).added, kit_moments(kit)
    wall = solid_of_revolution(body.outer) - solid_of_revolution(body.cavity)
    mass = cut.volume * body.hull_density + body.core.mass
    off = planned - (cut - wall)
    assert abs(off.volume) * body.hull_density < 2e-6 * mass
    assert abs(off.first) * body.hull_density < 2e-6 * mass * body.length
    assert abs(off.second) < 3e-5 * cut.second
    assert abs(off.polar) < 3e-5 * cut.polar


@settings(max_examples=60, deadline=None)
@given(BODIES, KITS)
def test_the_core_has_a_seat_where_the_parts_as_drawn_do_not_hold_it(body, options):
    try:
        plan = plan_kit(body, options)
    except WorkFailedError:
        return
    gap, core = 1e3 * options.clearance, Ball(0.0, plan.hull.core)
    parts = _draw_parts(plan.hull, plan.joints, gap)
    for side, latitude in zip((-1, 1), plan.seats, strict=True):
        if latitude is None:
            # A hair more of play decides nothing, except on the edge.
            assert any(is_held(parts, core, side, gap + more) for more in (0.0, 0.02))
        else:
            assert not all(is_held(parts, core, side, gap + more) for more in (0.0, -0.02))


def test_a_line_that_is_moved_keeps_its_distance_and_loses_short_edges():
    line = np.array([[-100.0, 105.0], [0.0, 5.0], [0.1, 5.0], [4.0, 8.9], [100.0, 8.9]])
    inner, outer = move_line(line, 1.0), move_line(line, -1.0)
    assert read_radius(inner, 50.0) == pytest.approx(7.9)
    assert read_radius(inner, 2.0) == pytest.approx(read_radius(line, 2.0) - math.sqrt(2))
    assert read_radius(inner, -9.0) == pytest.approx(read_radius(line, -9.0) - math.sqrt(2))
    # Outward, the two slopes meet above what was flat between them.
    assert read_radius(outer, 0.05) == pytest.approx(5.0 - 0.05 + math.sqrt(2))
    assert len(np.unique(outer[:, 0])) == len(np.unique(inner[:, 0])) - 1
