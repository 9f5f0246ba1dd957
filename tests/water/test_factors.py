"""The table ``[calibration]``: what it accepts, what it does to agents and contact, and how disturbed flights draw from it."""

import numpy as np
import pytest
from pydantic import ValidationError

from driftform.study import load_study
from driftform.testing.bodies import hollow_body
from driftform.types import Coefficients
from driftform.water import Calibration, Factors
from driftform.water.disturbances import disturb_scenario, draw_conditions
from driftform.water.scenario import Robustness

TABLE = Calibration.model_validate(
    {
        "cross_drag": (1.4, 1.3, 1.5),
        "hull_density": (0.95, 0.93, 0.97),
        "restitution": 1.2,
        "correlations": [("cross_drag", "hull_density", -0.8)],
    }
)


def test_a_value_alone_has_no_interval():
    assert TABLE.factors == Factors(cross_drag=1.4, hull_density=0.95, restitution=1.2)
    assert set(TABLE.intervals) == {"cross_drag", "hull_density"}
    assert Calibration().is_empty and not TABLE.is_empty


@pytest.mark.parametrize(
    "table",
    [
        {"cross_drag": (1.2, 1.3, 1.4)},
        {"cross_drag": 0.0},
        {"cross_drag": True},
        {"cross_drag": "1.2"},
        {"drag": 1.2},
        {"correlations": [("drag", "friction", 0.5)]},
        {"correlations": [("cross_drag", "friction", 1.5)]},
    ],
)
def test_what_is_no_calibration_is_refused(table):
    with pytest.raises(ValidationError):
        Calibration.model_validate(table)


def test_factors_scale_what_they_name():
    body, added = hollow_body(), np.diag([1.0, 2.0, 2.0, 0.0, 3.0, 3.0])
    assert TABLE.factors.scale_body(body).hull_density == pytest.approx(0.95 * body.hull_density)
    assert Factors().scale_body(body) is body
    scaled = Factors(axial_drag=2.0, cross_drag=3.0, added_mass=0.5).scale_coefficients(
        Coefficients(added, quadratic_damping=np.eye(6))
    )
    assert scaled.added_mass == pytest.approx(0.5 * added)
    assert np.diag(scaled.quadratic_damping) == pytest.approx([2, 3, 3, 2, 3, 3])
    assert TABLE.factors.scale_restitution(0.5) == pytest.approx(0.6)
    assert Factors(restitution=5.0).scale_restitution(0.5) == 1.0


def test_disturbed_flights_draw_a_factor_from_its_interval_as_correlated_as_the_table_says():
    drawn = np.array([c.calibrated for c in draw_conditions(Robustness(), 2000, (1,), TABLE)])
    for column, (low, high) in zip(drawn.T, ((1.3, 1.5), (0.93, 0.97)), strict=True):
        assert np.mean((column >= low) & (column <= high)) == pytest.approx(0.9, abs=0.01)
    assert np.corrcoef(drawn.T)[0, 1] == pytest.approx(-0.8, abs=0.03)


def test_a_deviate_of_the_quantile_is_an_end_of_an_interval_that_is_not_symmetric():
    table = Calibration.model_validate({"axial_drag": (1.2, 1.0, 1.7), "friction": (0.02, 0.01, 0.5)})
    q = Calibration.quantile
    drawn = table.draw_factors(np.array([[q, 0.0], [-q, q], [0.5 * q, -q], [0.0, -5.0 * q]]))
    np.testing.assert_allclose(drawn, [[1.7, 0.02], [1.0, 0.5], [1.45, 0.01], [1.2, Factors.MIN]], atol=1e-12)


def test_the_factors_that_are_correlated_share_their_deviates():
    table = Calibration.model_validate(
        dict.fromkeys(("axial_drag", "added_mass", "friction"), (1.0, 0.5, 1.5))
        | {"correlations": [("friction", "axial_drag", 0.6), ("added_mass", "added_mass", 0.2)]}
    )
    mixed = (table.draw_factors(np.eye(3)) - 1.0) * Calibration.quantile / 0.5
    np.testing.assert_allclose(mixed.T @ mixed, [[1, 0, 0.6], [0, 1, 0], [0.6, 0, 1]], atol=1e-12)


def test_the_blanket_uncertainty_of_drag_is_left_for_drags_that_were_not_measured():
    scenario = load_study("pipe-inspection").scenario.model_copy(update={"calibration": TABLE})
    conditions = draw_conditions(Robustness(drag=0.2), 200, (2,), TABLE)
    factors = [disturb_scenario(c, scenario).calibration.factors for c in conditions]
    cross, axial = (np.array([getattr(f, name) for f in factors]) for name in ("cross_drag", "axial_drag"))
    assert np.std(cross) == pytest.approx(0.1 / 1.645, rel=0.1)
    assert np.std(axial) == pytest.approx(0.2, rel=0.1)
    assert {f.restitution for f in factors} == {1.2}
    plain = draw_conditions(Robustness(drag=0.2), 200, (2,))
    empty = scenario.model_copy(update={"calibration": Calibration()})
    both = [disturb_scenario(c, empty).calibration.factors for c in plain]
    assert all(f.cross_drag == f.axial_drag for f in both)
