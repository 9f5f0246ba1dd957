"""Rotations against each other and against scipy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from driftform.util.rotations import (
    matrix_from_quaternion,
    quaternion_from_rotation_vector,
    rotation_from_quaternion,
    rotation_from_vector,
    rotation_vector_from_quaternion,
)

vectors = st.tuples(*[st.floats(-4, 4)] * 3).map(np.array)


def matrix(vector):
    return np.array(rotation_from_vector(*vector))


@given(vectors)
def test_a_rotation_vector_turns_as_scipy_says(vector):
    assert matrix(vector) == pytest.approx(Rotation.from_rotvec(vector).as_matrix(), abs=1e-12)


@given(vectors)
def test_its_quaternion_is_the_same_rotation(vector):
    quaternion = quaternion_from_rotation_vector(vector[None])
    assert np.linalg.norm(quaternion) == pytest.approx(1, abs=1e-12)
    assert matrix_from_quaternion(quaternion)[0] == pytest.approx(matrix(vector), abs=1e-12)


@given(vectors, st.floats(0.1, 10))
def test_the_kernel_of_a_quaternion_turns_the_same_whatever_its_length(vector, length):
    [quaternion] = length * quaternion_from_rotation_vector(vector[None])
    assert np.array(rotation_from_quaternion(*quaternion)) == pytest.approx(matrix(vector), abs=1e-12)


@given(vectors)
def test_there_and_back_again_is_the_same_attitude(vector):
    [quaternion] = quaternion_from_rotation_vector(vector[None])
    again = rotation_vector_from_quaternion(quaternion)
    assert np.linalg.norm(again) <= np.pi + 1e-9
    assert matrix(again) == pytest.approx(matrix(vector), abs=1e-9)


@pytest.mark.parametrize("angle", [1e-3, 1.0001e-4, 0.9999e-4, 1e-9, 0.0])
def test_small_angles_are_exact_on_either_side_of_the_series(angle):
    vector = angle * np.array([0.6, 0.0, 0.8])
    assert matrix(vector) == pytest.approx(Rotation.from_rotvec(vector).as_matrix(), abs=1e-15)


def test_a_turn_about_y_leaves_the_plane_exactly():
    for turned in (
        matrix(np.array([0.0, 0.7, 0.0])),
        np.array(rotation_from_quaternion(np.cos(0.35), 0.0, np.sin(0.35), 0.0)),
    ):
        assert turned[1] == pytest.approx([0, 1, 0], abs=0)
        assert turned[:, 1] == pytest.approx([0, 1, 0], abs=0)
