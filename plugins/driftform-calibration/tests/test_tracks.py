"""Tracks: what is mended and said, and what is refused."""

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.testing.bodies import cylinder_body
from driftform_calibration.tracks import Reading, Track, check_track, read_track

BODY = cylinder_body(0.2, 0.02)


def fall(n=40, fps=60.0):
    """A fall from rest: times, and points to the right and up, m."""
    t = np.arange(n) / fps
    return t, np.column_stack([0.05 * t, -2.0 * t**2])


def track_of(t, points):
    return Track("film.csv", t, points[None])


def write_csv(path, t, points, names="t,x,y"):
    rows = [f"{a!r},{x!r},{y!r}" for a, (x, y) in zip(t.tolist(), points.tolist(), strict=True)]
    path.write_text("\n".join([names, *rows]) + "\n", encoding="utf-8")
    return path


def without_points(t, points):
    points[[3, 17]], t[8] = np.nan, np.nan
    return t, points


T, POINTS = fall()


@pytest.mark.parametrize(
    ("t", "points", "kept", "notes"),
    [
        (T, POINTS, slice(None), ()),
        (
            *without_points(*fall()),
            np.delete(np.arange(40), [3, 8, 17]),
            ("3 of 40 rows without a time or a point left out",),
        ),
        (np.delete(T, np.s_[15:30]), np.delete(POINTS, np.s_[15:30], axis=0), np.r_[0:15, 30:40], ()),
        (T[::-1], POINTS[::-1], slice(None), ("times go back 39 times: rows were put in the order of time",)),
        (np.repeat(T, 2), np.repeat(POINTS, 2, axis=0), slice(None), ("40 rows with the time of another left out",)),
    ],
    ids=["sound", "empty rows", "a gap", "backwards", "exported twice"],
)
def test_what_can_be_mended_is_mended_and_said(t, points, kept, notes):
    found = check_track("film.csv", track_of(t, points))
    assert found.notes == notes
    assert np.array_equal(found.t, T[kept]) and np.array_equal(found.points[0], POINTS[kept])


@pytest.mark.parametrize(("period", "lost"), [(5, 1), (10, 1), (9, 2)])
def test_frames_that_were_lost_in_a_rhythm_get_their_time_back(period, lost):
    t, points = fall(150, 60.0)
    noisy = points + np.random.default_rng(period).normal(0, 0.001, points.shape)
    kept = np.flatnonzero(np.arange(len(t)) % (period + lost) < period)
    found = check_track("film.csv", track_of(t[: len(kept)], noisy[kept]))
    assert found.t == pytest.approx(t[kept])
    assert found.notes == (
        f"after every {period} frames {lost} of them missing, by regular jumps of the points: times were corrected",
    )


def test_neither_noise_nor_a_bounce_is_a_rhythm():
    t, points = fall(150, 60.0)
    tracks = [points + np.random.default_rng(seed).normal(0, 0.003, points.shape) for seed in range(40)]
    for height in (0.2, 0.5, 0.9):
        fallen = np.sqrt(height / 2.0)
        up = np.where(t < fallen, height - 2.0 * t**2, 1.5 * (t - fallen) - 2.0 * (t - fallen) ** 2)
        tracks.append(np.column_stack([0.05 * t, np.abs(up)]))
    for track in tracks:
        assert np.array_equal(check_track("film.csv", track_of(t, track)).t, t)


def test_two_objects_in_one_track_are_refused():
    t, points = fall()
    other = points + np.array([0.3, 0.0])
    with pytest.raises(InputError, match="two points at 40 times, as if it followed two objects"):
        check_track("film.csv", track_of(np.repeat(t, 2), np.stack([points, other], axis=1).reshape(-1, 2)))
    alternating = np.where((np.arange(40) % 3 == 0)[:, None], other, points)
    with pytest.raises(InputError, match=r"its points scatter by .* as if it followed two objects"):
        check_track("film.csv", track_of(t, alternating))
    later = np.where((np.arange(40) >= 20)[:, None], other + np.array([0.0, 0.5]), points)
    with pytest.raises(
        InputError, match=f"between t = {t[19]:.3f} and {t[20]:.3f} s, .* or it followed another object .* cut it there"
    ):
        check_track("film.csv", track_of(t, later))


def test_a_single_wrong_point_is_said_and_left_to_the_robust_fit():
    t, points = fall()
    points[25] += [1.0, 0.0]
    [note] = check_track("film.csv", track_of(t, points)).notes
    assert note.startswith("2 jumps") and f"{t[24]:.3f}" in note


def test_a_film_that_begins_long_before_the_release_does_not_jump():
    _t, points = fall()
    held = np.repeat(points[:1], 200, axis=0) + 1e-4 * np.sin(np.arange(200))[:, None]
    times = np.arange(240) / 60
    assert check_track("film.csv", track_of(times, np.vstack([held, points]))).notes == ()


@pytest.mark.parametrize(
    ("t", "points", "message"),
    [
        (np.arange(3) / 60, np.zeros((3, 2)), "has 3 usable points, at least 5 are needed"),
        (16.7 * np.arange(9), fall(9)[1], "its times are 16.7 apart: give --fps N if"),
        (np.arange(9) / 60, np.zeros((9, 2)), "do not move"),
        (np.arange(9) / 60, np.full((9, 2), np.nan), "has 0 usable points"),
    ],
)
def test_a_track_that_cannot_be_mended_is_refused_in_one_line(t, points, message):
    with pytest.raises(InputError, match=message) as error:
        check_track("film.csv", track_of(t, points))
    assert str(error.value).startswith("film.csv: ")


def test_lengths_are_read_in_the_unit_that_is_named(tmp_path):
    t, points = fall()
    path = write_csv(tmp_path / "film.csv", t, 1000 * points)
    in_mm = read_track(path, BODY, Reading(unit="mm"))
    assert in_mm.points[0] == pytest.approx(points)
    with pytest.raises(InputError, match="unit 'inch' is not known"):
        read_track(path, BODY, Reading(unit="inch"))
    named = write_csv(tmp_path / "named.csv", t, 100 * points, "t,x (cm),y (cm)")
    assert read_track(named, BODY, Reading()).points[0] == pytest.approx(points)
    for reading, option in ((Reading(unit="mm"), "unit mm"), (Reading(scale=0.01), "scale 0.01")):
        with pytest.raises(InputError, match=f"its coordinates are in cm; leave out --{option}"):
            read_track(named, BODY, reading)


def test_pixels_need_a_scale_and_point_down(tmp_path):
    t, points = fall()
    path = write_csv(tmp_path / "film.csv", t, points * [500.0, -500.0], "t,x_px,y_px")
    imagej = write_csv(tmp_path / "imagej.csv", np.arange(40), points * [100.0, -100.0], "Slice,X,Y")
    for pixels in (path, imagej):
        with pytest.raises(InputError, match="give --scale, the metres per pixel"):
            read_track(pixels, BODY, Reading(fps=60.0))
    assert read_track(imagej, BODY, Reading(unit="cm", fps=60.0)).points[0] == pytest.approx(points), (
        "of a calibrated picture"
    )
    found = read_track(path, BODY, Reading(scale=0.002))
    assert found.points[0] == pytest.approx(points)
    assert "y is taken to point down" in found.notes[0]
    up = read_track(path, BODY, Reading(scale=0.002, y_down=False))
    assert up.points[0][:, 1] == pytest.approx(-points[:, 1]) and up.notes == ()


def test_frames_need_their_rate(tmp_path):
    t, points = fall()
    path = write_csv(tmp_path / "film.csv", np.arange(40), points, "frame,x,y")
    with pytest.raises(InputError, match="has frames and no times; give --fps"):
        read_track(path, BODY, Reading())
    assert read_track(path, BODY, Reading(fps=60.0)).t == pytest.approx(t)
    path = write_csv(tmp_path / "film.csv", np.arange(40), points)
    assert read_track(path, BODY, Reading(fps=60.0)).t == pytest.approx(t), "a column t may count frames"


def test_time_stamps_count_from_the_first(tmp_path):
    t, points = fall(150)
    path = write_csv(tmp_path / "film.csv", np.round(1764320000 + t, 6), points)
    found = read_track(path, BODY, Reading())
    assert found.notes == () and found.t == pytest.approx(t, abs=2e-6)


def test_the_ends_of_the_body_are_known_and_other_points_must_be_placed(tmp_path):
    t, points = fall()
    rows = [f"{a},{x},{y},{x},{y}" for a, (x, y) in zip(t, points, strict=True)]
    path = tmp_path / "film.csv"
    path.write_text("\n".join(["t,nose_x,nose_y,tail_x,tail_y", *rows]), encoding="utf-8")
    assert read_track(path, BODY, Reading()).places == (0.1, -0.1)
    placed = read_track(path, BODY, Reading(points={"nose": 0.03}))
    assert placed.places == (0.03, -0.1)
    path.write_text("\n".join(["t,Dot 1/0/X,Dot 1/0/Y,Dot 2/0/X,Dot 2/0/Y", *rows]), encoding="utf-8")
    with pytest.raises(InputError, match=r"the points dot 1/0, dot 2/0; .* --point 'dot 1/0=0.01' .* with --object"):
        read_track(path, BODY, Reading())
    assert read_track(path, BODY, Reading(target="Dot 2/0")).places == (0.0,)
    with pytest.raises(InputError, match=r"--point eye: .* has no such point"):
        read_track(path, BODY, Reading(points={"eye": 0.0}))


def test_unlikely_points_of_deeplabcut_are_left_out(tmp_path):
    t, points = fall()
    path = tmp_path / "film.csv"
    rows = [f"{k},{500 * x},{-500 * y},{0.2 if k == 7 else 0.9}" for k, (x, y) in enumerate(points)]
    head = ["scorer,n,n,n", "bodyparts,core,core,core", "coords,x,y,likelihood"]
    path.write_text("\n".join([*head, *rows]), encoding="utf-8")
    found = read_track(path, BODY, Reading(scale=0.002, fps=60.0))
    assert len(found.t) == 39 and t[7] not in found.t
    assert any("less likely than 0.6" in note for note in found.notes)
