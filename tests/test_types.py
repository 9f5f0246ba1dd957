"""What the values compute about themselves."""

import numpy as np
import pytest

from driftform.errors import WorkFailedError
from driftform.pipeline import require_success
from driftform.types import End, MassProperties, Trajectory, freeze
from driftform.water import Fluid


def make_trajectory(end):
    return Trajectory(np.array([0.0, 1.23456]), np.zeros((2, 3)), np.zeros((2, 4)), np.zeros((2, 6)), end)


@pytest.mark.parametrize(
    ("given", "shape"),
    [((), (None,)), ((), (1,)), ((3,), (2,)), ((2, 3), (None, 2)), ((2,), (None, 2)), ((2, 2, 2), (None, 2))],
)
def test_an_array_of_another_shape_is_refused(given, shape):
    with pytest.raises(ValueError, match=r"^values has shape .*, expected "):
        freeze(np.zeros(given), shape, "values")


@pytest.mark.parametrize("shape", [(0, 2), (3, 2)])
def test_an_array_is_copied_and_read_only(shape):
    given = np.ones(shape, order="F")
    kept = freeze(given, (None, 2), "values")
    given[:] = 2.0
    np.testing.assert_array_equal(kept, np.ones(shape))
    assert kept.flags.c_contiguous and not kept.flags.writeable


@pytest.mark.parametrize(("mass", "newtons"), [(0.9, 0.98), (1.0, 0.0), (1.1, -0.98)])
def test_net_buoyancy_is_positive_for_what_floats(mass, newtons):
    properties = MassProperties(mass, np.zeros(3), np.eye(3), 0.001, np.zeros(3))
    assert properties.net_buoyancy(Fluid(density=1000.0, gravity=9.8)) == pytest.approx(newtons)


@pytest.mark.parametrize("end", [end for end in End if end.failed])
def test_a_failed_flight_is_refused_by_name_with_its_time_and_reason(end):
    with pytest.raises(WorkFailedError, match=rf"^TP1: the flight ended after 1\.23 s: {end}$"):
        require_success(make_trajectory(end), "TP1")


@pytest.mark.parametrize("end", [end for end in End if not end.failed])
def test_a_sound_flight_is_not_refused(end):
    flight = make_trajectory(end)
    require_success(flight, "TP1")
    assert flight.failure is None
