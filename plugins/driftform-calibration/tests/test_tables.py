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


NONE = np.nan
READ = {
    "columns in any order": (
        "y,t,x,remark\n-0.1,0.0,0.5,held\n-0.2,0.5,0.6,\n",
        [0, 0.5],
        {"": [[0.5, -0.1], [0.6, -0.2]]},
    ),
    "a track in space": ("t,x,y,z\n0,1,2,3\n", [0], {"": [[1, 2, 3]]}),
    "a height": ("t,z\n0,0.3\n1,0.2\n", [0, 1], {"": [[NONE, 0.3], [NONE, 0.2]]}),
    "decimal commas where semicolons separate": ("t;x;y\n0,033;-1,2E-2;0,5\n", [0.033], {"": [[-0.012, 0.5]]}),
    "units in centimetres": ("A: t / s,A: x (cm),Position y (cm) Run #1\n0,1,2\n", [0], {"": [[1, 2]]}, "cm"),
    "units in millimetres": ("time_s\tx_mm\ty_mm\n0\t1\t2\n", [0], {"": [[1, 2]]}, "mm"),
    "minutes": ("t (min),x (mm),y (mm)\n2,1,2\n", [120], {"": [[1, 2]]}, "mm"),
    "pixels": ("t [ms];x [px];y [px]\n1000;1;2\n", [1], {"": [[1, 2]]}, "px"),
    "Tracker, with a frame without a point": (
        "mass A\t\t\nt\tx\ty\n0.00E0\t1.1E-2\t-2.0E-3\n3.33E-2\t\t\n",
        [0, 0.0333],
        {"": [[0.011, -0.002], [NONE, NONE]]},
    ),
    "DeepLabCut": (
        "scorer,net,net,net,net,net,net\nbodyparts,nose,nose,nose,tail,tail,tail\n"
        "coords,x,y,likelihood,x,y,likelihood\n0,10.5,20.5,0.99,30.0,21.0,0.98\n1,11.5,22.5,0.40,31.0,23.0,0.97\n",
        [0, 1],
        {"nose": [[10.5, 20.5], [11.5, 22.5]], "tail": [[30, 21], [31, 23]]},
        "px",
    ),
    "points by the names of columns": (
        "frame,nose_x,nose_y,tail.x,tail.y\n0,1,2,3,4\n",
        [0],
        {"nose": [[1, 2]], "tail": [[3, 4]]},
    ),
    "no names": ("0 0.1 0.2\n0.5 0.3 0.4\n", [0, 0.5], {"": [[0.1, 0.2], [0.3, 0.4]]}),
    "Kinovea": (
        '"Time (ms)";"Drop 1/0/X";"Drop 1/0/Y"\n0;0,10;0,20\n33;0,11;0,19\n',
        [0, 0.033],
        {"drop 1/0": [[0.10, 0.20], [0.11, 0.19]]},
    ),
    "an older Kinovea": (
        "#Kinovea Trajectory data export\n#T X Y\n0:00:00:96 1,5 2,5\n0:00:01:00 1,6 2,4\n",
        [0.96, 1.0],
        {"": [[1.5, 2.5], [1.6, 2.4]]},
    ),
    "quoted decimal commas": (
        't,x,y\n"0,0","0,1","0,5"\n"0,5","0,2","0,4"\n',
        [0, 0.5],
        {"": [[0.1, 0.5], [0.2, 0.4]]},
    ),
}


@pytest.mark.parametrize("name", READ)
def test_tracks_are_read_as_programs_and_people_write_them(write, name):
    text, t, points, *unit = READ[name]
    table = read_table(write(text))
    assert table.t == pytest.approx(t)
    assert table.points.keys() == points.keys()
    for key, places in points.items():
        np.testing.assert_allclose(table.points[key], places, rtol=1e-12)
    assert not unit or table.unit == unit[0]
    assert table.is_frames == (name == "DeepLabCut" or text.startswith("frame"))
    assert table.is_image == (name == "DeepLabCut")
    assert table.is_spatial == (name == "a track in space")


def test_likelihoods_are_read_and_a_guess_is_said(write):
    assert read_table(write(READ["DeepLabCut"][0])).likelihood["nose"].tolist() == [0.99, 0.4]
    assert read_table(write(READ["no names"][0])).notes == ("no row of names: columns are taken as t, x, y",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("t,x\n" + 30_000 * "0,1\n", "has more than 20000 rows or 20 MB: keep those of one flight"),
        ("a,b\n1,2\n", "no row names its columns: expected t"),
        ("t,x,y\n,,\n", "holds no numbers"),
        ("t,x,y\n,1,2\n2025-11-28T10:00:00,1,2\n", "'2025-11-28T10:00:00' in row 2 below the names is not a number"),
        ("t,x (m),y (cm)\n0,1,2\n", "several units: cm, m"),
        ("t,x (mm),y\n0,1,2\n", "several units: none, mm"),
        ("t (days),x (m)\n0,1\n", "the unit 'days' of its times is not known; take s, "),
        ("scorer,net\n0,1\n", "has no rows 'bodyparts' and 'coords'"),
        ("t,nose_x,nose_y,tail_x,tail_y,tail_z\n0,1,2,3,4,5\n", "some of its points have three coordinates"),
        ("t,x,y,x,y\n0,1,2,3,4\n", "two columns x"),
    ],
)
def test_what_is_no_track_is_refused_in_one_line(write, text, message):
    with pytest.raises(InputError, match=message) as error:
        read_table(write(text))
    assert len(error.value.args) == 1 and "\n" not in str(error.value)


def test_a_file_that_is_no_text_or_does_not_exist_is_refused(tmp_path):
    film = tmp_path / "film.mp4"
    film.write_bytes(b"\0\0\0 ftypisom\0\0\2\0" + bytes(range(256)))
    with pytest.raises(InputError, match="is not a text file"):
        read_table(film)
    with pytest.raises(InputError, match="cannot be read"):
        read_table(tmp_path / "absent.csv")


SLEAP = "track,frame_idx,instance.score,core.x,core.y,core.score\nA,7,0.9,300,400,0.9\nA,8,0.9,301,404,0.9\n"
TRACKMATE = (
    "LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME\n"
    "Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame\nLabel,Spot ID,Track ID,Quality,X,Y,Z,T,Frame\n"
    ",,,(quality),({unit}),({unit}),({unit}),({time}),\n"
    "ID1,1,A,5,300,400,0,{first},7\nID2,2,A,5,301,404,0,{second},8\n"
)
TRACKPY = (
    ",y,x,mass,size,ecc,signal,raw_mass,ep,frame,particle\n0,400,300,9,2,.1,5,9,.1,7,A\n1,404,301,9,2,.1,5,9,.1,8,A\n"
)


IMAGEJ = " \tTrack n°\tSlice n°\tX\tY\tDistance\tVelocity\tPixel Value\n1\tA\t7\t300\t400\t-1\t-1\t9\n2\tA\t8\t301\t404\t4\t4\t9\n"


def test_columns_of_velocities_are_not_points(write):
    table = read_table(write("mass A\t\t\t\nt (s)\tx (cm)\ty (cm)\tv_y (cm/s)\n0\t1\t2\t\n0.1\t3\t4\t20\n"))
    assert (list(table.points), table.unit) == ([""], "cm")
    assert table.points[""].tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize(
    ("text", "point", "unit", "t"),
    [
        (SLEAP, "core", "", [7, 8]),
        (TRACKPY, "", "", [7, 8]),
        (IMAGEJ, "", "", [7, 8]),
        (TRACKMATE.format(unit="pixel", time="sec", first=0.0, second=0.033), "", "px", [0.0, 0.033]),
        (TRACKMATE.format(unit="mm", time="frame", first=7, second=8), "", "mm", [7, 8]),
    ],
)
def test_programs_with_a_row_for_each_object_and_frame_count_downward_from_the_top(write, text, point, unit, t):
    table = read_table(write(text))
    seen = table.points[point]
    assert seen[np.isfinite(seen).all(axis=1)].tolist() == [[300.0, 400.0], [301.0, 404.0]]
    assert table.t[np.isfinite(table.t)].tolist() == t
    assert (table.is_image, table.unit, table.is_frames) == (True, unit, t[0] == 7)


@pytest.mark.parametrize(
    ("text", "objects", "chosen", "point", "found"),
    [
        ("mass A\t\t\tmass B\t\nt\tx\ty\tx\ty\n0\t1\t2\t3\t4\n", "mass A, mass B", "mass B", "", [[3.0, 4.0]]),
        (
            "scorer,net,net,net,net\nindividuals,one,one,two,two\nbodyparts,core,core,core,core\ncoords,x,y,x,y\n0,1,2,3,4\n",
            "one, two",
            "two",
            "core",
            [[3.0, 4.0]],
        ),
        ("time,x1,y1,x2,y2\n0.0,1,2,3,4\n0.02,,,5,6\n", "1, 2", "2", "2", [[3.0, 4.0], [5.0, 6.0]]),
        (SLEAP + "B,7,0.9,500,600,0.9\n", "A, B", "B", "core", [[500.0, 600.0]]),
    ],
    ids=["Tracker", "DeepLabCut", "idtracker", "SLEAP"],
)
def test_of_several_objects_one_must_be_chosen(write, text, objects, chosen, point, found):
    path = write(text)
    with pytest.raises(InputError, match=rf"follows 2 objects \({objects}\); choose one with --object"):
        read_table(path)
    table = read_table(path, chosen)
    assert table.points[point].tolist() == found
    assert table.is_image == (point != "")
    with pytest.raises(InputError, match="has no such object; did you mean"):
        read_table(path, f"{chosen}x")


@pytest.mark.parametrize("picture", ["labeled-data/drop/img{}.png", "labeled-data,drop,2_img{}_v2.png"])
def test_labels_of_deeplabcut_by_hand_have_the_numbers_of_their_pictures(write, picture):
    gap = "," * picture.count(",")
    rows = "".join(f"{picture.format(n)},{x},20.5\n" for n, x in (("007", 10.5), ("012", 11.5)))
    table = read_table(write(f"scorer,{gap}me,me\nbodyparts,{gap}core,core\ncoords,{gap}x,y\n{rows}"))
    assert table.t.tolist() == [7.0, 12.0]
    assert table.points["core"].tolist() == [[10.5, 20.5], [11.5, 20.5]]


@pytest.mark.parametrize(
    ("cells", "values"),
    [
        (["1.234", "0.5"], [1.234, 0.5]),
        (["1,234", "0,500"], [1.234, 0.5]),
        (["12,345", "1234"], [12.345, 1234.0]),
        (["1,100.7", "2,000.0"], [1100.7, 2000.0]),
        (["1.100,7", "2.000,0"], [1100.7, 2000.0]),
        (["1,234", "0.5"], [1234.0, 0.5]),
        (["1.234.567", "2"], [1234567.0, 2.0]),
        (["1\u202f100,5", "1'200,5"], [1100.5, 1200.5]),
        (["1 100,5", "999,5"], [1100.5, 999.5]),
    ],
)
def test_points_and_commas_in_numbers_mean_what_all_of_them_show(write, cells, values):
    table = read_table(write("t;x;y\n" + "".join(f"{k};{cell};{k}\n" for k, cell in enumerate(cells))))
    assert table.points[""][:, 0].tolist() == values


def test_a_factor_of_a_thousand_is_asked_for_and_never_taken_in_silence(write):
    with pytest.raises(InputError, match=r"'1,100' may be 1.100 or 1100: export it with decimal points"):
        read_table(write("t;x;y\n0;1,100;1,500\n1;1,200;1,400\n"))
    with pytest.raises(InputError, match="decimal points and decimal commas"):
        read_table(write("t;x;y\n0;1,100.5;2\n1;1.100,5;3\n"))


def test_commas_that_separate_both_columns_and_decimals_are_joined_or_named(write):
    table = read_table(write("t,x,y\n0,0,0,1,0,5\n0,5,0,2,-0,4\n"))
    assert table.t.tolist() == [0.0, 0.5]
    assert table.points[""].tolist() == [[0.1, 0.5], [0.2, -0.4]]
    assert "taken from two cells" in table.notes[0]
    with pytest.raises(InputError, match=r"row 1 below the names has 5 cells for 3 names: if commas separate"):
        read_table(write("t,x,y\n0,0,1,0,5\n0,5,0,2,0,4\n"))
