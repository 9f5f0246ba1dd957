"""Files of tracks: every format that people have, and one clear line for what is none."""

import numpy as np
import pytest

from driftform.errors import InputError
from driftform_calibration.tables import read_table


@pytest.fixture
def write(tmp_path):
    def write_file(text, name="track.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write_file


def test_plain_columns_are_read_in_any_order(write):
    table = read_table(write("y,t,x,remark\n-0.1,0.0,0.5,held\n-0.2,0.5,0.6,\n"))
    assert table.t.tolist() == [0.0, 0.5]
    assert table.points[""].tolist() == [[0.5, -0.1], [0.6, -0.2]]
    assert not table.is_frames and not table.is_spatial


def test_a_third_coordinate_makes_a_track_in_space_and_z_alone_is_a_height(write):
    assert read_table(write("t,x,y,z\n0,1,2,3\n")).points[""].tolist() == [[1.0, 2.0, 3.0]]
    heights = read_table(write("t,z\n0,0.3\n1,0.2\n")).points[""]
    assert np.isnan(heights[:, 0]).all() and heights[:, 1].tolist() == [0.3, 0.2]


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("t (s),x (cm),y (cm)\n0,1,2\n", "cm"),
        ("time_s\tx_mm\ty_mm\n0\t1\t2\n", "mm"),
        ("t [ms];x [px];y [px]\n1000;1;2\n", "px"),
    ],
)
def test_units_in_the_names_of_columns_are_understood(write, text, unit):
    table = read_table(write(text))
    assert table.unit == unit
    assert table.points[""].tolist() == [[1.0, 2.0]]
    assert table.t.tolist() == ([1.0] if "ms" in text else [0.0])


def test_decimal_commas_are_numbers_where_semicolons_separate(write):
    table = read_table(write("t;x;y\n0,033;-1,2E-2;0,5\n"))
    assert table.t.tolist() == [0.033]
    assert table.points[""].tolist() == [[-0.012, 0.5]]


def test_an_angle_counts_counterclockwise_and_a_pitch_nose_down(write):
    assert read_table(write("t,x,y,angle_deg\n0,0,0,90\n")).angle == pytest.approx(np.pi / 2)
    assert read_table(write("t,x,y,pitch_deg\n0,0,0,30\n")).angle == pytest.approx(-np.pi / 6)
    assert read_table(write("t,x,y,pitch\n0,0,0,0.5\n")).angle == pytest.approx(-0.5)
    assert np.isnan(read_table(write("t,x,y\n0,0,0\n")).angle).all()


def test_an_export_of_tracker_has_the_name_of_the_track_above_its_columns(write):
    table = read_table(write("mass A\t\t\nt\tx\ty\n0.00E0\t1.1E-2\t-2.0E-3\n3.33E-2\t\t\n"))
    assert table.t == pytest.approx([0.0, 0.0333])
    assert table.points[""][0].tolist() == [0.011, -0.002]
    assert np.isnan(table.points[""][1]).all(), "a frame without a point"


def test_of_several_objects_one_must_be_chosen(write):
    tracker = write("mass A\t\t\tmass B\t\nt\tx\ty\tx\ty\n0\t1\t2\t3\t4\n")
    with pytest.raises(InputError, match=r"follows 2 objects \(mass A, mass B\); choose one with --object"):
        read_table(tracker)
    assert read_table(tracker, "mass B").points[""].tolist() == [[3.0, 4.0]]
    with pytest.raises(InputError, match="has no such object; did you mean"):
        read_table(tracker, "mass")
    with pytest.raises(InputError, match="two columns x"):
        read_table(write("t,x,y,x,y\n0,1,2,3,4\n"))


DEEPLABCUT = """scorer,net,net,net,net,net,net
bodyparts,nose,nose,nose,tail,tail,tail
coords,x,y,likelihood,x,y,likelihood
0,10.5,20.5,0.99,30.0,21.0,0.98
1,11.5,22.5,0.40,31.0,23.0,0.97
"""


def test_an_export_of_deeplabcut_has_frames_points_and_likelihoods(write):
    table = read_table(write(DEEPLABCUT))
    assert table.is_frames and table.is_image and table.unit == "px"
    assert table.t.tolist() == [0.0, 1.0]
    assert table.points["tail"].tolist() == [[30.0, 21.0], [31.0, 23.0]]
    assert table.likelihood["nose"].tolist() == [0.99, 0.4]


def test_of_several_animals_one_must_be_chosen(write):
    path = write(
        "scorer,net,net,net,net\nindividuals,one,one,two,two\nbodyparts,core,core,core,core\n"
        "coords,x,y,x,y\n0,1,2,3,4\n"
    )
    with pytest.raises(InputError, match="follows 2 objects"):
        read_table(path)
    assert read_table(path, "two").points["core"].tolist() == [[3.0, 4.0]]


def test_several_points_are_told_apart_by_the_names_of_their_columns(write):
    table = read_table(write("frame,nose_x,nose_y,tail.x,tail.y\n0,1,2,3,4\n"))
    assert table.is_frames
    assert {name: values.tolist() for name, values in table.points.items()} == {
        "nose": [[1.0, 2.0]],
        "tail": [[3.0, 4.0]],
    }


def test_numbers_without_names_are_taken_in_the_usual_order_and_that_is_said(write):
    table = read_table(write("0 0.1 0.2\n0.5 0.3 0.4\n"))
    assert table.t.tolist() == [0.0, 0.5]
    assert table.points[""].tolist() == [[0.1, 0.2], [0.3, 0.4]]
    assert table.notes == ("no row of names: columns are taken as t, x, y",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("a,b\n1,2\n", "no row names its columns: expected t"),
        ("t,x,y\nnone,none,none\n", "holds no numbers"),
        ("t,x (m),y (cm)\n0,1,2\n", "several units: cm, m"),
        ("scorer,net\n0,1\n", "has no rows 'bodyparts' and 'coords'"),
        ("t,nose_x,nose_y,tail_x,tail_y,tail_z\n0,1,2,3,4,5\n", "some of its points have three coordinates"),
    ],
)
def test_what_is_no_track_is_refused_in_one_line(write, text, message):
    with pytest.raises(InputError, match=message) as error:
        read_table(write(text))
    assert len(error.value.args) == 1 and "\n" not in str(error.value)


def test_a_file_that_is_no_text_or_does_not_exist_is_refused(tmp_path):
    film = tmp_path / "film.mp4"
    film.write_bytes(bytes(range(128, 256)))
    with pytest.raises(InputError, match="export the track as CSV"):
        read_table(film)
    with pytest.raises(InputError, match="cannot be read"):
        read_table(tmp_path / "absent.csv")
