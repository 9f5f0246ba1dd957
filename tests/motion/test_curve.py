"""How far cubics are from the motion whose positions and velocities they have."""

import numpy as np
import pytest

from driftform.motion.forces.state import SAMPLE
from driftform.motion.path.curve import bound_cubic_error, evaluate_path


def along_z(t, height, velocity):
    """Raw samples of a motion along z."""
    samples = np.zeros((len(t), SAMPLE))
    samples[:, 0], samples[:, 3], samples[:, 4], samples[:, 10] = t, height, 1.0, velocity
    return samples


@pytest.mark.parametrize("steps", [20, 40])
def test_the_error_between_samples_is_that_of_a_cubic(steps):
    t = np.linspace(0, 2, steps + 1)
    samples = along_z(t, np.sin(3 * t), 3 * np.cos(3 * t))
    middles = t[:-1] + 1 / steps
    between = evaluate_path(t, samples[:, 1:4], samples[:, 8:11], middles)[:, 2]
    off = np.abs(between - np.sin(3 * middles)).max()
    assert bound_cubic_error(samples) == pytest.approx(off, rel=0.05)
    # A kink at a sample is part of the path, and so is a sample that occurs twice.
    after = np.maximum(t - 1, 0)
    assert bound_cubic_error(along_z(t, after**2, 2 * after)) < 1e-12
    assert bound_cubic_error(samples[np.repeat(np.arange(steps + 1), 2)]) == bound_cubic_error(samples)
    assert bound_cubic_error(samples[:2]) == 0.0
