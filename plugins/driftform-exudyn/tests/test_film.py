"""What is in the pictures of a film, and what becomes of a film that cannot be made."""

import signal
import sys
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from driftform.errors import WorkFailedError
from driftform.figures.style import BLUE
from driftform.study import load_study
from driftform.testing.agents import hollow_agent
from driftform.testing.renderer import drifting_trajectory, read_film
from driftform.water import Pipe, Scenario, Segment
from driftform_exudyn import encoder
from driftform_exudyn.film import ExudynRenderer, FilmOptions
from driftform_exudyn.headless import defer_interrupts
from driftform_exudyn.scene import Pose, Scene
from driftform_exudyn.shapes import make_ball
from driftform_exudyn.stage import Camera, Stage
from driftform_exudyn.surroundings import list_bores, upright_axes
from driftform_exudyn.views import FollowView, SideView

PIPE = Pipe(segments=(Segment(start=(0, 0, 0), end=(1, 0, 0), radius=0.15),))
UPRIGHT = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


@pytest.fixture
def agent():
    """A tube of 60 mm about its core."""
    return hollow_agent()


def scene(agent, flight=None, scenario=None, frames=5):
    flight = drifting_trajectory(0.8, turn=0.0) if flight is None else flight
    t = np.linspace(0, flight.t[-1], frames)
    return Scene(agent, flight, scenario or Scenario(pipe=PIPE), t, letter_height=8.0)


HULL, NOSE, TARGET = "hull", "nose", "target"


def pixels(image, what):
    """Columns and rows of the pixels that have a colour, in whatever light; the path is as blue as a nose."""
    red, green, blue = np.moveaxis(image.astype(int), 2, 0)
    masks = {
        HULL: (red - blue > 60) & (green > 0.62 * red),
        TARGET: (red - blue > 60) & (green < 0.55 * red),
        NOSE: blue - red > 90,
    }
    return np.argwhere(masks[what])[:, ::-1]


def middle(image, what):
    found = pixels(image, what)
    assert len(found), f"no {what} is seen"
    return found.mean(axis=0)


# Where things are in an image.


@pytest.mark.parametrize("distance", [np.inf, 0.6, 2.0])
@pytest.mark.parametrize("focus", [(0.0, 0.0, 0.0), (5.0, 1.0, -0.9)])
def test_a_thing_is_where_the_laws_of_perspective_put_it(distance, focus):
    stage = Stage(make_ball((0, 0, 0), 0.01, BLUE), Camera(UPRIGHT, 400.0, distance), rays=1)
    for place in np.array([(0.0, 0, 0), (0.1, 0, 0.05), (-0.1, 0.3, 0.1), (0.05, -0.2, -0.08)]):
        image = stage.render((200, 120), np.array(focus), Pose(place + focus, np.eye(3)), [])
        shrunk = 400 / (1 + place[1] / distance)
        assert middle(image, NOSE) == pytest.approx((99.5 + shrunk * place[0], 59.5 - shrunk * place[2]), abs=0.8)


# What the views show.


@pytest.mark.parametrize("downstream", [(1, 0, 0), (0, 1, 0), (-0.6, 0.8, 0)])
def test_seen_from_the_side_the_agent_goes_from_left_to_right(agent, downstream):
    pipe = Pipe(segments=(Segment(start=(0, 0, 0), end=tuple(map(float, downstream)), radius=0.15),))
    flight = drifting_trajectory(0.8, turn=0.0)
    flight = replace(flight, position=flight.t[:, None] * downstream, velocity=0 * flight.velocity)
    view = SideView(scene(agent, flight, Scenario(pipe=pipe)), (240, 120), rays=1, captioned=False)
    columns = [middle(view.render(frame), HULL)[0] for frame in range(5)]
    assert (np.diff(columns) > 20).all()
    # 0.8 m of a pipe of 1 m.
    assert 150 < columns[-1] - columns[0] < 200


def test_a_small_agent_is_magnified_from_the_side_and_the_image_says_so(agent):
    long_pipe = Pipe(segments=(Segment(start=(0, 0, 0), end=(30, 0, 0), radius=1),))
    view = SideView(scene(agent, scenario=Scenario(pipe=long_pipe)), (400, 100), rays=1, captioned=False)
    found = pixels(view.render(0), HULL)
    assert 6 <= np.ptp(found[:, 0]) <= 20, "it would be less than a pixel"
    assert any(shape.get("text") == "agent drawn 20 times its size" for shape in view._still)


@pytest.mark.parametrize(("pitch", "where"), [(0.0, (1, 0)), (0.8, (1, 1)), (-0.8, (1, -1)), (2.5, (-1, 1))])
def test_seen_from_close_by_the_fore_end_points_where_the_attitude_does(agent, pitch, where):
    flight = drifting_trajectory(turn=0.0)
    half = np.full(len(flight.t), pitch / 2)
    flight = replace(flight, quaternion=np.column_stack([np.cos(half), 0 * half, np.sin(half), 0 * half]))
    image = FollowView(scene(agent, flight, Scenario()), (240, 160), rays=1).render(0)
    # The path is as blue as the nose; at the release it has no length yet.
    offset = middle(image[20:], NOSE) - middle(image[20:], HULL)
    assert np.sign(np.where(np.abs(offset) < 4, 0, offset)) == pytest.approx(where)


# What a still shows.


LEVEL, UPRIGHT_POSE, ASLANT = 0.0, -np.pi / 2, 0.6


def still_of(agent, flight, scenario, at):
    t = np.union1d(np.linspace(0, flight.t[-1], 9), at)
    return Scene(agent, flight, scenario, t, letter_height=8.0, still=int(np.searchsorted(t, at)))


def held(pitch):
    """A flight with the same attitude all the way."""
    flight = drifting_trajectory(0.8, turn=0.0)
    half = np.full(len(flight.t), pitch / 2)
    zero = 0 * half
    velocity = np.column_stack([np.cos(2 * half), zero, np.sin(2 * half), zero, zero, zero])
    quaternion = np.column_stack([np.cos(half), zero, np.sin(half), zero])
    return replace(flight, quaternion=quaternion, velocity=velocity)


@pytest.mark.parametrize("pitch", [LEVEL, UPRIGHT_POSE, ASLANT])
def test_on_a_still_the_agent_is_as_large_as_fits_as_it_lies(agent, pitch):
    seen = still_of(agent, held(pitch), Scenario(), 0.4)
    image = FollowView(seen, (240, 160), rays=1).render(seen.still)
    room = (np.abs(pixels(image, HULL) - (119.5, 79.5)).max(axis=0) + 0.5) / (120, 80)
    # What is nearer than the axis looks larger, by less than 1.3.
    assert 1 / 1.3 - 0.02 < room.max() < 0.98


@pytest.mark.parametrize(("slow", "every"), [(10, 0.5), (1, 0.1)])
def test_a_still_shows_the_agent_at_equal_intervals_and_says_at_which(agent, slow, every):
    flight = held(LEVEL)
    flight = replace(flight, t=flight.t * slow, position=flight.position * slow)
    pipe = Pipe(segments=(Segment(start=(0, 0, 0), end=(0.8 * slow, 0, 0), radius=0.1 * slow),))
    seen = still_of(agent, flight, Scenario(pipe=pipe), 0.0)
    view = SideView(seen, (480, 160), rays=1, captioned=False)
    columns = np.unique(pixels(view.render(seen.still), HULL)[:, 0])
    first = columns[np.append(True, np.diff(columns) > 2)]
    assert len(first) == round(0.8 * slow / every) + 1
    assert np.ptp(np.diff(first)) <= 2
    assert any(shape.get("text", "").endswith(f"every {every:g} s") for shape in view._still)


@pytest.mark.parametrize("size", [(240, 64), (64, 240)])
def test_seen_from_close_by_the_whole_agent_is_in_a_picture_of_any_shape(agent, size):
    flying = scene(agent, drifting_trajectory(0.8, turn=2.0))
    view = FollowView(flying, size, rays=1)
    for frame in range(5):
        image = view.render(frame)
        found = pixels(image, HULL)
        assert len(found) > 100
        assert (found > 2).all() and (found < np.array(size) - 3).all()


def test_targets_are_seen(agent):
    bare, aimed = Scenario(pipe=PIPE), Scenario(pipe=PIPE, targets={"leak": (0.7, 0.0, -0.05)})
    before, after = (
        SideView(scene(agent, scenario=s), (240, 120), rays=1, captioned=False).render(0) for s in (bare, aimed)
    )
    changed = np.abs(before.astype(int) - after).max(axis=2) > 40
    view = SideView(scene(agent, scenario=aimed), (240, 120), rays=1, captioned=False)
    right, _, up = view._px_per_m * (np.array([0.7, 0.0, -0.05]) - view._centre)
    column, row = int(120 + right), int(60 - up)
    assert changed[row - 1 : row + 2, column - 1 : column + 2].all()


# Which moments are shown.


@pytest.mark.peers
def test_slow_motion_has_as_many_more_frames(agent, tmp_path):
    counts = []
    for speed in (1.0, 0.25):
        options = FilmOptions(width=64, height=64, fps=5, speed=speed, view="side", rays=1)
        path = tmp_path / f"{speed}.mp4"
        written = ExudynRenderer(options).film(
            agent, drifting_trajectory(0.8), Scenario(pipe=PIPE), path, lambda *_: None
        )
        counts.append(len(read_film(path)))
        assert written.facts == {"frames": counts[-1], "seconds": counts[-1] / 5, "size_px": [64, 64]}
    assert counts == [5, 17]


# Films that cannot be made.


def film(agent, path):
    options = FilmOptions(width=64, height=64, fps=5, view="side", rays=1)
    return ExudynRenderer(options).film(agent, drifting_trajectory(), Scenario(pipe=PIPE), path, lambda *_: None)


@pytest.mark.peers
def test_a_name_that_looks_like_a_protocol_or_an_option_is_only_a_name(agent, tmp_path, monkeypatch):
    from pathlib import Path

    monkeypatch.chdir(tmp_path)
    for name in ("pipe:1.mp4", "-y.gif", "100%d.mp4"):
        film(agent, Path(name))
        assert Path(name).stat().st_size > 0


@pytest.mark.peers
def test_if_ffmpeg_fails_its_last_line_is_reported_and_no_file_is_left(agent, monkeypatch, tmp_path):
    # The Python interpreter rejects ffmpeg's options.
    monkeypatch.setattr(encoder, "find_ffmpeg", lambda: sys.executable)
    for suffix in (".mp4", ".gif"):
        with pytest.raises(WorkFailedError, match=r"^ffmpeg failed: \S"):
            film(agent, tmp_path / f"film{suffix}")
    assert list(tmp_path.iterdir()) == []


def test_an_interruption_waits_until_exudyn_is_done():
    before, done = signal.getsignal(signal.SIGINT), False
    with pytest.raises(KeyboardInterrupt), defer_interrupts():
        signal.raise_signal(signal.SIGINT)
        done = True
    assert done and signal.getsignal(signal.SIGINT) is before


def test_a_png_file_holds_the_pixels():
    drawn = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    image = Image.open(BytesIO(encoder.png_bytes(drawn)))
    assert (image.format, image.mode, image.size) == ("PNG", "RGB", (5, 7))
    assert (np.asarray(image) == drawn).all()


@pytest.fixture(scope="module")
def junction():
    return load_study("t-junction").scenario


def test_the_cylinders_of_a_junction_follow_its_parts(junction):
    bores = list_bores(junction.pipe, upright_axes(junction)[2])
    assert {round(bore.radius, 9) for bore in bores} == {0.05, 0.1}
    for bore in bores:
        points = bore.point(np.linspace(0.1, 0.9, 5) * bore.length, 0.5 * bore.radius, np.pi / 2)
        assert (junction.pipe.layout.find_part(points) >= 0).all()
    ends = np.array([bore.start + bore.length * bore.axes[0] for bore in bores])
    for outlet in junction.pipe.layout.outlets:
        assert np.linalg.norm(ends - outlet.opening.centre, axis=1).min() < 1e-9


def test_a_bore_that_runs_towards_the_viewer_shows_its_lower_half():
    scenario = Scenario.model_validate({"pipe": {"segments": [{"start": (0, 0, 0), "end": (0, 2, 0), "radius": 0.5}]}})
    [bore] = list_bores(scenario.pipe, np.array([0.0, -1.0, 0.0]))
    np.testing.assert_allclose(bore.axes[2], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(bore.axes @ bore.axes.T, np.eye(3), atol=1e-12)
