"""The current of a pipe as a file: read back as a grid, and interpolated as Gazebo does, it is the flow that was sampled."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from driftform.errors import InputError
from driftform.water import Scenario
from driftform.water.fittings import fitting_array
from driftform.water.parts.grid_files import read_grid
from driftform.water.parts.grid_flow import grid_velocities
from driftform.water.parts.profiles import AT_A_POINT
from driftform.water.parts.walls import wall_gaps
from driftform.water.velocity import flow_array, water_motion
from driftform_tees.currents import COLUMNS, MAX_NODES, sample_current, usual_spacing, write_current

BEND = [{"length": 0.5}, {"kind": "bend", "radius": 0.3, "roll_deg": 90}, {"length": 0.5}]


def bend(**tables):
    tables = {"flow": {"speed": 1.0}, "release": {"position": (0.1, 0.0, 0.0)}, **tables}
    return Scenario.model_validate({"pipe": {"radius": 0.1, "parts": BEND}, **tables})


@pytest.fixture(scope="module")
def grid():
    """The bend sampled at 20 cells per bore."""
    return sample_current(bend())


@pytest.fixture(scope="module")
def file(grid, tmp_path_factory):
    path = tmp_path_factory.mktemp("currents") / "bend.csv"
    write_current(path, grid)
    return path


@pytest.fixture(scope="module")
def water(grid):
    """Points in the bore between the ends, their distances from the wall, and the velocities there."""
    rng, scenario = np.random.default_rng(0), bend()
    fittings = fitting_array(scenario)
    points = rng.uniform(grid.origin, grid.end, (40_000, 3))
    gaps, _, inside = wall_gaps(points, fittings)
    kept = inside & (gaps > 0)
    arrays = np.empty((0, 8)), flow_array(scenario), AT_A_POINT, fittings
    exact = [water_motion(tuple(point), 0.0, *arrays)[0] for point in points[kept].tolist()]
    return points[kept], gaps[kept], np.array(exact)


def test_read_back_as_a_grid_it_is_the_flow_of_the_bend(file, water):
    """To 0.05 % of the mean speed (root mean square), and 2 % where straight and bend meet, where the flow has a kink."""
    points, gaps, exact = water
    fittings = fitting_array(bend(flow={"kind": "grid", "file": str(file), "speed": 1.0}))
    error = np.linalg.norm(grid_velocities(points, fittings) - exact, axis=1)
    assert np.sqrt(np.mean(error**2)) < 5e-4
    assert error.max() < 0.02
    assert error[gaps > 0.01].max() < 0.01


def test_interpolated_as_gazebo_does_it_is_the_flow_up_to_the_wall(file, water):
    """Gazebo interpolates linearly, and takes 0 for nodes that are left out."""
    points, _, exact = water
    found = read_grid(file)
    axes = [o + s * np.arange(n) for o, s, n in zip(found.origin, found.spacing, found.shape, strict=True)]
    values = np.nan_to_num(found.velocity)
    error = np.linalg.norm(RegularGridInterpolator(axes, values)(points) - exact, axis=1)
    assert np.sqrt(np.mean(error**2)) < 5e-3
    assert error.max() < 0.05


def test_the_file_has_one_time_and_the_columns_of_gazebo(file, grid):
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert tuple(rows[0]) == COLUMNS
    assert {row["timestamp"] for row in rows} == {"0"}
    assert len(rows) == np.isfinite(grid.velocity).all(axis=3).sum()
    # Gazebo compares all digits of coordinates: each plane of nodes has one text.
    assert [len({row[name] for row in rows}) for name in "xyz"] == [
        np.isfinite(grid.velocity).all(axis=3).any(axis=tuple({0, 1, 2} - {axis})).sum() for axis in range(3)
    ]


def test_the_flow_of_a_straight_pipe_can_be_exported_too(tmp_path):
    document = {
        "pipe": {"segments": [{"start": (0, 0, 0), "end": (2, 0, 1), "radius": 0.2}]},
        "flow": {"kind": "log_law", "speed": 0.5},
        "release": {"position": (0.1, 0, 0)},
    }
    scenario = Scenario.model_validate(document)
    found = sample_current(scenario, 0.02)
    place = np.array([1.0, 0.0, 0.5])
    node = np.rint((place - found.origin) / found.spacing).astype(int)
    nearest = found.origin + node * found.spacing
    expected = water_motion(
        tuple(nearest.tolist()),
        0.0,
        np.array([[0, 0, 0, *scenario.direction(), np.sqrt(5), 0.2]]),
        flow_array(scenario),
    )[0]
    np.testing.assert_allclose(found.velocity[tuple(node)], expected, rtol=1e-12)


def test_a_long_pipe_has_a_coarser_grid(monkeypatch):
    long = Scenario.model_validate(
        {
            "pipe": {"radius": 0.1, "parts": [{"length": 20.0}, {"kind": "bend", "radius": 0.3}, {"length": 20.0}]},
            "release": {"position": (0.1, 0, 0)},
        }
    )
    spacing = usual_spacing(long)
    assert spacing > 0.01
    with pytest.raises(InputError, match=f"choose at least {spacing:g} m"):
        sample_current(long, 0.01)
    assert MAX_NODES >= 4_000_000


def test_open_water_has_nothing_to_sample():
    with pytest.raises(InputError, match="no pipe"):
        sample_current(Scenario())


def test_the_file_that_was_told_of_is_there_and_can_be_flown_in(done):
    told = done("export-flow", "paper", "--spacing", "0.25", "--out", "c.csv", "--json")
    assert told["file"] == "c.csv" and told["speed"] == 1.0 and told["warnings"] == []
    lines = Path("c.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "timestamp,x,y,z,u,v,w"
    assert len(lines) == told["nodes"] + 1
    done("scenarios", "check", "paper", "--set", "flow={kind='grid',file='c.csv',speed=1.0}")


def test_gusts_that_are_left_out_are_told_of(done):
    flow = "flow={kind='turbulent',speed=1.0}"
    told = done("export-flow", "paper", "--spacing", "0.4", "--set", flow, "--out", "c.csv")
    assert "warning: gusts are left out" in told
    assert 'flow.kind = "grid", flow.file = "c.csv", flow.reference = 1' in told


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("paper", "--out", "c.vtk"), "choose a name that ends in .csv"),
        (("paper", "--spacing", "3"), "choose at most 0.5 m"),
        (("paper", "--spacing", "0"), "must be positive"),
        (("t-junction", "--spacing", "0.001"), "choose at least"),
    ],
)
def test_what_cannot_be_written_is_refused(arguments, words, refused):
    assert words in refused("export-flow", *arguments)
    assert not list(Path().glob("*.csv"))
