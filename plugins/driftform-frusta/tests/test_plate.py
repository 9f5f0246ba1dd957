"""Parts on the bed: apart, within it, and the same way every time."""

from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform_frusta.plate import GAP, arrange

BED = (250.0, 210.0)
sides = st.floats(1, 250)
parts = st.lists(st.tuples(sides, st.floats(1, 210)), min_size=1, max_size=12)


@given(parts)
def test_parts_on_a_plate_keep_their_gap_and_stay_on_the_bed_whose_middle_is_that_of_their_rows(sizes):
    spots = arrange(sizes, BED)
    plates = [spot.plate for spot in spots]
    assert set(plates) == set(range(max(plates) + 1))
    boxes = [(s.x - a / 2, s.y - b / 2, s.x + a / 2, s.y + b / 2) for (a, b), s in zip(sizes, spots, strict=True)]
    for left, front, right, back in boxes:
        assert -BED[0] / 2 - 1e-9 <= left and right <= BED[0] / 2 + 1e-9
        assert -BED[1] / 2 - 1e-9 <= front and back <= BED[1] / 2 + 1e-9
    for (i, a), (j, b) in combinations(enumerate(boxes), 2):
        if plates[i] == plates[j]:
            apart = max(a[0] - b[2], b[0] - a[2], a[1] - b[3], b[1] - a[3])
            assert apart >= GAP - 1e-9
    for plate in set(plates):
        own = [each for each, number in zip(boxes, plates, strict=True) if number == plate]
        assert min(b[1] for b in own) + max(b[3] for b in own) == pytest.approx(0, abs=1e-6)


def test_small_parts_share_a_row_and_large_ones_take_another():
    spots = arrange([(60, 60)] * 4, BED)
    assert {spot.plate for spot in spots} == {0}
    assert len({spot.y for spot in spots}) == 2
    assert len(arrange([(60, 60)] * 3, BED)) == 3
    assert {spot.y for spot in arrange([(60, 60)] * 3, BED)} == {0}


def test_what_has_no_room_goes_on_another_plate():
    assert [spot.plate for spot in arrange([(200, 150), (200, 150)], BED)] == [0, 1]


def test_a_part_larger_than_the_bed_has_a_plate_to_itself():
    spots = arrange([(20, 20), (300, 300), (20, 20)], BED)
    assert spots[0].plate == spots[2].plate != spots[1].plate
    assert (spots[1].x, spots[1].y) == (0, 0)
