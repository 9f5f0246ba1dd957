import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.figures.projection import PLAN, SIDE, drawing_times, silhouette, simplify_polyline
from driftform.motion.path.interpolation import interpolate_positions

unit = st.lists(st.floats(-1, 1), min_size=4, max_size=4).map(np.array).filter(lambda q: np.linalg.norm(q) > 0.1)


@settings(deadline=None, max_examples=40)
@given(data=st.data(), quaternion=unit, view=st.sampled_from([SIDE, PLAN]))
def test_a_silhouette_reaches_as_far_as_the_body_does(agents, data, quaternion, view):
    body = data.draw(agents).body
    w, x, y, z = quaternion = quaternion / np.linalg.norm(quaternion)
    axis = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    drawn = np.vstack(silhouette(body, quaternion, view, 0.0))
    for angle in np.linspace(0, 2 * np.pi, 7):
        direction = np.zeros(3)
        direction[list(view)] = np.cos(angle), np.sin(angle)
        along = float(axis @ direction)
        # A disc square to the axis reaches its radius times the sine of the angle between axis and direction.
        reach = body.outer @ (along, np.sqrt(max(0.0, 1 - along**2)))
        # Rims are drawn with 20 corners, which lie on the circle: between them 1 - cos(pi / 20) is cut off.
        short = reach.max() - (drawn @ direction[list(view)]).max()
        assert -1e-6 <= short <= 0.0125 * body.outer[:, 1].max() + 1e-6


@settings(deadline=None, max_examples=40)
@given(st.lists(st.tuples(st.floats(0, 100), st.floats(0, 100)), min_size=2, max_size=30))
def test_a_simplified_line_stays_within_its_tolerance(line):
    line = np.array(line)
    kept = simplify_polyline(line, 2.0)
    assert (kept[[0, -1]] == line[[0, -1]]).all()
    starts, chords = kept[:-1], np.diff(kept, axis=0)
    squared = np.maximum((chords**2).sum(axis=1), 1e-30)
    for point in line:
        s = np.clip(((point - starts) * chords).sum(axis=1) / squared, 0, 1)
        assert np.linalg.norm(starts + s[:, None] * chords - point, axis=1).min() <= 2.0 + 1e-9


def test_the_path_passes_through_the_samples_and_ends_at_the_given_time(fly):
    trajectory = fly(rise=0.1, samples=10)
    assert interpolate_positions(trajectory, trajectory.t) == pytest.approx(trajectory.position)
    cut = interpolate_positions(trajectory, drawing_times(trajectory, stop=4.3))
    assert cut[-1] == pytest.approx([4.3, 0, 0.43])
    assert (np.diff(cut[:, 0]) > 0).all()
