"""How far cubics are from the motion whose positions and velocities they have."""

import numpy as np
import pytest

from driftform.motion.path.curve import bound_cubic_error, evaluate_path


def along_z(values):
    """Vectors (k, 3) with these components."""
    return np.outer(values, [0.0, 0.0, 1.0])


@pytest.mark.parametrize("steps", [20, 40])
def test_the_error_between_samples_is_that_of_a_cubic(steps):
    t = np.linspace(0, 2, steps + 1)
    position, velocity = along_z(np.sin(3 * t)), along_z(3 * np.cos(3 * t))
    middles = t[:-1] + 1 / steps
    between = evaluate_path(t, position, velocity, middles)[:, 2]
    off = np.abs(between - np.sin(3 * middles)).max()
    assert bound_cubic_error(t, position, velocity) == pytest.approx(off, rel=0.05)
    # A kink at a sample is part of the path, and so is a sample that occurs twice.
    after = np.maximum(t - 1, 0)
    assert bound_cubic_error(t, along_z(after**2), along_z(2 * after)) < 1e-12
    twice = np.repeat(np.arange(steps + 1), 2)
    assert bound_cubic_error(t[twice], position[twice], velocity[twice]) == bound_cubic_error(t, position, velocity)
    assert bound_cubic_error(t[:2], position[:2], velocity[:2]) == 0.0
