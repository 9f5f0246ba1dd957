"""The grammar of B-splines keeps the promises of a grammar, and its bodies are what its numbers say."""

import math

import pytest

from driftform.errors import InputError
from driftform.testing import GrammarContract
from driftform_bspline.grammar import BSplineGrammar, BSplineOptions
from driftform_frusta.builder import FrustaBuilder, FrustaOptions

GRAMMAR = BSplineGrammar(BSplineOptions())


class TestBSpline(GrammarContract):
    nonsense = (*GrammarContract.nonsense, "0.05", "nan" + ",0" * 9, "5" + ",0" * 9)

    def plugin(self):
        return GRAMMAR


def test_even_control_points_are_a_cone():
    # Those of a line lie at the means of their knots (Greville 1969).
    fore = BSplineGrammar(BSplineOptions(points=3)).parse("0.09,0.003,0.006,0.009,0.09,0,0,0")
    modules = BSplineGrammar(BSplineOptions(points=3)).express(fore).fore
    assert [module.tilt for module in modules] == pytest.approx([math.atan(0.1)] * 12)
    assert sum(module.length for module in modules) == pytest.approx(0.09 * math.hypot(1, 0.1))


def test_a_body_is_as_long_as_its_two_sides_and_as_wide_as_its_control_points_allow():
    genome = GRAMMAR.parse("0.08,0.01,0.01,0.01,0.01,0.05,0,0,0,-0.005")
    body = FrustaBuilder(FrustaOptions()).build(GRAMMAR.express(genome))
    dome = FrustaOptions().core_radius + FrustaOptions().clearance + FrustaOptions().wall
    assert body.length == pytest.approx(0.13, abs=1e-6)
    assert body.max_diameter == pytest.approx(2 * (dome + 0.01), rel=1e-6)
    assert body.outer[1, 1] == pytest.approx(dome - 0.005, abs=1e-4)


def test_a_number_out_of_its_bounds_is_named():
    with pytest.raises(InputError, match=r"symbol 2 is '0\.5', expected -0\.012 to 0\.012"):
        GRAMMAR.parse("0.05,0.5" + ",0" * 8)
