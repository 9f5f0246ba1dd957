"""``driftform simulate --film`` and ``--still``: what is told of them, and what is refused before anything is flown."""

import json
import signal
import struct
import sys
import time

import pytest

WORD = "addB-tiltn-1-M-moveB-addB-tiltp-1-L-moveB"
FLIP_BOOK = ("simulate", WORD, "--simulator", "fake", "--renderer", "flip-book", "--out", "flight")
SMALL = ("--set", "renderer.exudyn.width=64", "--set", "renderer.exudyn.height=64", "--set", "renderer.exudyn.fps=1")


@pytest.mark.usefixtures("fakes")
def test_a_film_is_made_where_it_is_wanted_and_told_of(call, tmp_path):
    result = call(*FLIP_BOOK, "--film", "films/book.txt")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "films" / "book.txt").read_text() == "20 pages of 9 s\n"
    assert result.stdout.splitlines()[-1] == "film:       films/book.txt"
    assert {path.name for path in (tmp_path / "flight").iterdir()} == {"trajectory.csv", "flight.svg"}


@pytest.mark.usefixtures("fakes")
def test_a_film_that_fails_is_one_line_and_leaves_the_other_files(call, tmp_path):
    result = call(*FLIP_BOOK, "--film", "book.txt", "--set", "renderer.flip-book.torn=true")
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-1] == "error: the last page is torn"
    assert not (tmp_path / "book.txt").exists()
    assert (tmp_path / "flight" / "trajectory.csv").exists()


@pytest.mark.peers
def test_a_real_film_is_made_by_default(call, tmp_path):
    from driftform.testing.renderer import read_film

    both = ("--film", "flight.gif", "--still", "flight.png")
    result = call("simulate", WORD, "--scenario", "paper", *both, *SMALL, "--json")
    assert result.exit_code == 0, result.stderr
    frames = read_film(tmp_path / json.loads(result.stdout)["film"])
    assert frames.shape == (10, 64, 64, 3)
    still(tmp_path / "flight.png")


@pytest.mark.peers
def test_a_directory_is_no_film(refused, tmp_path):
    (tmp_path / "here.mp4").mkdir()
    assert "--film here.mp4: is a directory" in refused("simulate", WORD, "--film", "here.mp4")
    (tmp_path / "file").touch()
    assert "choose another --film" in refused("simulate", WORD, "--film", "file/film.mp4")


def test_without_an_encoder_it_says_what_to_install_and_flies_nothing(call, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    result = call("simulate", WORD, "--film", "film.mp4")
    assert result.exit_code == 1
    [line] = result.stderr.splitlines()
    assert line.startswith("error: ") and 'pip install "driftform[film]"' in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.peers
@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
def test_an_interrupted_film_leaves_nothing(start, tmp_path):
    quick = ("--set", "renderer.exudyn.view=side", "--set", "renderer.exudyn.rays=1")
    with start("simulate", WORD, "--film", "films/flight.mp4", *quick, cwd=tmp_path) as process:
        while not list(tmp_path.glob("films/*")):
            assert process.poll() is None
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=600)
    assert process.returncode == 130
    assert err.splitlines()[-1] == "interrupted"
    assert list((tmp_path / "films").iterdir()) == []


def still(path):
    """A picture that was made, and its size in pixels is 64 x 64."""
    made = path.read_bytes()
    assert made.startswith(b"\x89PNG") and made[16:24] == struct.pack(">II", 64, 64)
    return made


def test_by_default_a_still_is_of_the_closest_approach(call, tmp_path):
    told = json.loads(call("simulate", WORD, "--still", "one.png", *SMALL, "--json").stdout)
    assert told["still"] == "one.png"
    closest = min(told["closest"].values(), key=lambda approach: approach["distance"])
    for name, at in (("two.png", closest["t"]), ("three.png", closest["t"] / 2)):
        call("simulate", WORD, "--still", name, "--still-at", repr(at), *SMALL)
    one, two, three = (still(tmp_path / f"{name}.png") for name in ("one", "two", "three"))
    assert one == two != three


def test_a_still_needs_no_encoder_and_is_told_of(call, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    result = call("simulate", WORD, "--still", "stills/flight.png", *SMALL)
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "still:      stills/flight.png"
    still(tmp_path / "stills" / "flight.png")


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (("--still", "flight.jpg"), "--still flight.jpg: a still by 'exudyn' ends in .png"),
        (("--still-at", "3"), "--still-at is the moment of a still: give --still FILE too"),
        (("--still", "here.png"), "--still here.png: is a directory"),
        (
            ("--still", "flight.png", "--film", "flight.avi"),
            "--film flight.avi: a film by 'exudyn' ends in .mp4 or .gif",
        ),
        (("--film", "flight.mp4.txt"), "--film flight.mp4.txt: a film by 'exudyn' ends in .mp4 or .gif"),
        (("--film", "a.mp4", "--renderer", "exudin"), "--renderer exudin: no renderer is named 'exudin'; did you mean"),
    ],
)
def test_a_film_or_a_still_that_cannot_be_made_is_refused_before_anything_is_flown(refused, tmp_path, options, why):
    (tmp_path / "here.png").mkdir()
    assert why in refused("simulate", WORD, *options)
    assert [path.name for path in tmp_path.iterdir()] == ["here.png"]


@pytest.mark.parametrize("at", ["-1", "100", "nan"])
def test_a_moment_that_the_flight_does_not_have_is_refused(refused, at, tmp_path):
    line = refused("simulate", WORD, "--still", "flight.png", "--still-at", at)
    assert f"--still-at {at}: the flight goes from 0 to " in line
    assert not (tmp_path / "flight.png").exists()


@pytest.mark.usefixtures("fakes")
def test_a_renderer_that_makes_no_stills_says_so(refused):
    assert "'flip-book' makes films, but not stills" in refused(*FLIP_BOOK, "--still", "book.txt")
