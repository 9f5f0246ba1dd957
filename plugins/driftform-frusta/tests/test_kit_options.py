"""What may be asked of a kit, and what is refused before anything is drawn."""

import pytest
from pydantic import ValidationError

from driftform_frusta.kit_options import PartOptions


def test_by_default_the_hull_is_one_sealed_part():
    assert PartOptions().kit is False


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"o_ring": 0.0015}, "needs a sleeve of 0.0014 m or more, not 0.0012"),
        # A groove of 1.5 mm, in 1.9 mm of sleeve.
        ({"o_ring": 0.002125, "sleeve": 0.00185}, "needs a sleeve of 0.0019 m or more"),
        ({"o_ring": 0.0015, "sleeve": 0.0019, "lap": 0.004}, "needs a lap of"),
        ({"o_ring": 0.0015, "sleeve": 0.0019, "joint": "rabbet"}, "rabbet has no room for an O-ring"),
        ({"clearance": 0.0}, "clearance"),
        ({"joint": "screw"}, "joint"),
        ({"bed": (0.2, 0.2)}, "bed"),
        ({"bed": (0.2, 0.2, 0.0)}, "bed"),
        ({"engrave": "x" * 41}, "engrave"),
    ],
)
def test_what_contradicts_itself_is_refused(options, why):
    with pytest.raises(ValidationError, match=why):
        PartOptions(**options)


def test_a_bed_may_be_a_list_as_in_a_study_file():
    assert PartOptions(bed=[0.2, 0.2, 0.25]).bed == (0.2, 0.2, 0.25)


def test_an_o_ring_that_fits_its_sleeve_is_taken():
    assert PartOptions(o_ring=0.0015, sleeve=0.0014).groove == pytest.approx(0.001)


def test_a_third_ball_of_ballast_is_refused_with_what_to_do():
    two = [[-0.04, 0.006], [0.045, 0.008]]
    assert len(PartOptions(kit=True, ballast=two).ballast) == 2
    with pytest.raises(ValueError, match="a kit holds at most 2 balls of ballast, not 3: replace two of them"):
        PartOptions(kit=True, ballast=[*two, [0.05, 0.004]])
