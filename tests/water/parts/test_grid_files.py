"""Velocities on a grid are the same from every format, in any order of nodes, and what is no regular grid is refused."""

import numpy as np
import pytest
from grids import axes_of, make_data_set, table_of, write_csv, write_netcdf3, write_netcdf4, write_vtk
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.util import foreign
from driftform.water.parts.grid_files import VelocityGrid, read_grid

ORIGIN, SPACING, SHAPE = np.array([-0.3, 0.1, 2.0]), np.array([0.1, 0.05, 0.2]), (4, 5, 6)


@pytest.fixture(scope="module", autouse=True)
def in_this_process():
    """Read in this process: one for each file takes a third of a second. tests/util/test_hostile_files.py has these."""

    def call(function, path, memory):
        try:
            return function(str(path))
        except OSError as error:
            raise ValueError(f"cannot be read: {error}") from None

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(foreign, "call_apart", call)
        yield


@pytest.fixture
def grid():
    return make_grid()


def make_grid(seed=0):
    return VelocityGrid(ORIGIN, SPACING, np.random.default_rng(seed).normal(size=(*SHAPE, 3)))


def each(names, **attributes):
    return {name: dict(attributes) for name in names}


def agree(found, expected, error=1e-12):
    np.testing.assert_allclose(found.origin, expected.origin, atol=error)
    np.testing.assert_allclose(found.spacing, expected.spacing, rtol=max(error, 1e-9))
    np.testing.assert_allclose(found.velocity, expected.velocity, rtol=error, atol=error)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_the_nodes_of_a_table_may_be_in_any_order(tmp_path_factory, seed):
    path, rng = tmp_path_factory.mktemp("grid") / "current.csv", np.random.default_rng(seed)
    grid = make_grid(seed)
    write_csv(path, rng.permutation(table_of(grid)))
    agree(read_grid(path), grid)


@settings(deadline=None, max_examples=25)
@given(st.sets(st.integers(0, 119), max_size=40))
def test_nodes_that_a_table_leaves_out_have_no_velocity(tmp_path_factory, left_out):
    path, grid = tmp_path_factory.mktemp("grid") / "current.csv", make_grid()
    table = np.delete(table_of(grid), sorted(left_out), axis=0)
    if any(len(np.unique(table[:, a])) < SHAPE[a] for a in range(3)):
        return
    write_csv(path, table)
    grid.velocity.reshape(-1, 3)[sorted(left_out)] = np.nan
    agree(read_grid(path), grid)


@pytest.mark.parametrize(
    "names",
    [
        ("Points:0", "Points:1", "Points:2", "U:0", "U:1", "U:2"),
        ("Points_0", "Points_1", "Points_2", "velocity_0", "velocity_1", "velocity_2"),
        ("x", "y", "z", "current_x", "current_y", "current_z"),
    ],
)
def test_the_columns_of_other_programs_are_understood(tmp_path, grid, names):
    write_csv(tmp_path / "current.csv", table_of(grid), names)
    agree(read_grid(tmp_path / "current.csv"), grid)


def test_a_table_may_be_in_utf16(tmp_path, grid):
    write_csv(tmp_path / "current.csv", table_of(grid))
    text = (tmp_path / "current.csv").read_text()
    (tmp_path / "current.csv").write_text(text, encoding="utf-16")
    agree(read_grid(tmp_path / "current.csv"), grid)


@pytest.mark.peers
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_the_dimensions_of_a_netcdf_file_may_be_in_any_order(tmp_path, grid, order):
    grid.velocity[1, 2, 3] = np.nan
    write_netcdf3(tmp_path / "current.nc", grid, order)
    agree(read_grid(tmp_path / "current.nc"), grid)


@pytest.mark.peers
@pytest.mark.parametrize(
    ("attributes", "kind", "packed"),
    [
        (each("uvw", _FillValue=-999.0), "f8", lambda v: np.nan_to_num(v, nan=-999.0)),
        (each("uvw", missing_value=-99.0), "f8", lambda v: np.nan_to_num(v, nan=-99.0)),
        (each("uvw", valid_range=[-9.0, 9.0]), "f8", lambda v: np.nan_to_num(v, nan=1e4)),
        (
            each("uvw", scale_factor=1e-9, add_offset=0.5, _FillValue=-(2**63)),
            "i8",
            lambda v: np.where(np.isnan(v), -(2**63), np.rint((np.nan_to_num(v) - 0.5) * 1e9).astype(int)),
        ),
        (each("uvw", units="cm s-1"), "f8", lambda v: 100 * v),
        (each("uvw", units="Kilometers per Second"), "f8", lambda v: v / 1000),
        (each("uvw", units="m day-1"), "f8", lambda v: 86400 * v),
        (each("uvw", units="cm/min"), "f8", lambda v: 6000 * v),
        (each("uvw", units="knots"), "f8", lambda v: v * 3600 / 1852),
    ],
)
def test_velocities_are_what_the_attributes_of_a_netcdf_file_say(tmp_path, grid, attributes, kind, packed):
    grid.velocity[1, 2, 3] = np.nan
    write_netcdf4(tmp_path / "current.nc", grid, attributes, kind, packed)
    found = read_grid(tmp_path / "current.nc").velocity
    np.testing.assert_allclose(found, grid.velocity, rtol=1e-9, atol=1e-9)


@pytest.mark.peers
def test_axes_in_kilometres_are_metres_and_what_is_not_known_is_refused_by_its_attribute(tmp_path, grid):
    write_netcdf4(
        tmp_path / "km.nc", VelocityGrid(ORIGIN / 1e3, SPACING / 1e3, grid.velocity), each("xyz", units="KiloMetres")
    )
    agree(read_grid(tmp_path / "km.nc"), grid)
    for attributes, words in [
        ({"x": {"units": "degrees_east"}}, "has units = 'degrees_east' on x, expected for example m, "),
        ({"v": {"units": "kg"}}, "has units = 'kg' on v"),
        ({"z": {"positive": "Down"}}, "has positive = 'Down' on z"),
        ({"z": {"long_name": "Depth below the surface"}}, "has long_name = 'Depth below"),
        ({"z": {"_CoordinateZisPositive": "down"}}, "has _CoordinateZisPositive = 'down'"),
        ({"w": {"standard_name": "downward_sea_water_velocity"}}, "has standard_name = 'downward"),
    ]:
        write_netcdf4(tmp_path / "current.nc", grid, attributes)
        with pytest.raises(ValueError, match=words):
            read_grid(tmp_path / "current.nc")
    write_netcdf4(tmp_path / "up.nc", grid, {"z": {"positive": "up", "long_name": "depth"}})
    agree(read_grid(tmp_path / "up.nc"), grid)


@pytest.mark.peers
@pytest.mark.parametrize("kind", ["vti", "vts", "vtu"])
def test_every_data_set_that_vtk_writes_is_read_as_points_with_velocities(tmp_path, grid, kind):
    grid.velocity[1, 2, 3] = np.nan
    for suffix, modes in ((kind, ("Ascii", "Binary", "Appended")), ("vtk", ("Ascii", "Binary", "Version 3.0"))):
        for mode in modes:
            write_vtk(tmp_path / f"current.{suffix}", make_data_set(grid, kind), mode)
            # VTK has points in single precision, and few digits in text.
            agree(read_grid(tmp_path / f"current.{suffix}"), grid, 1e-5)


@pytest.mark.peers
def test_the_axes_of_a_rectilinear_grid_are_its_nodes(tmp_path, grid):
    numbers = [" ".join(map(repr, axis.tolist())) for axis in axes_of(grid)]
    vectors = " ".join(map(repr, grid.velocity.transpose(2, 1, 0, 3).ravel().tolist()))
    extent = " ".join(f"0 {count - 1}" for count in grid.shape)
    array = '<DataArray type="Float64" Name="{}" NumberOfComponents="{}" format="ascii">{}</DataArray>'
    axes = "".join(array.format(name, 1, values) for name, values in zip("xyz", numbers, strict=True))
    (tmp_path / "current.vtr").write_text(
        f'<VTKFile type="RectilinearGrid"><RectilinearGrid WholeExtent="{extent}"><Piece Extent="{extent}"><PointData>'
        f"{array.format('velocity', 3, vectors)}</PointData><Coordinates>{axes}</Coordinates></Piece></RectilinearGrid></VTKFile>"
    )
    agree(read_grid(tmp_path / "current.vtr"), grid)


def stretched(table):
    table[:, 0] = np.sign(table[:, 0]) * table[:, 0] ** 2
    return table


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda table: table[:0], "has no line below its header"),
        (lambda table: table[:, :5], "has 6 columns in its header, but 5 below it"),
        (lambda table: table[table[:, 0] < -0.05], "has 3 different values of x; at least 4 are needed"),
        (stretched, "nodes are not evenly spaced along x; resample it"),
        (lambda table: np.concatenate([table, table[:1]]), "has several velocities at one node"),
        (lambda table: np.where(table == table[7, 2], np.inf, table), "has coordinates that are not finite"),
    ],
)
def test_what_is_no_regular_grid_is_refused_in_a_few_words(tmp_path, grid, change, words):
    write_csv(tmp_path / "current.csv", change(table_of(grid)))
    with pytest.raises(ValueError, match=words):
        read_grid(tmp_path / "current.csv")


PEER = pytest.mark.peers

BOMB = b"""<VTKFile type="ImageData"><ImageData WholeExtent="1 3000 1 3000 1 3000" Origin="0 0 0" Spacing="1 1 1">
<Piece Extent="1 3000 1 3000 1 3000"><PointData></PointData></Piece></ImageData></VTKFile>"""


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.csv", b"", "has no coordinates: it has no columns"),
        ("a.csv", b"x,y,z,u,v,w\n", "has no line below its header"),
        ("a.csv", b"x,y,z,u,v,w\n\nm,m,m,m/s,m/s,m/s\n1,2,3,4,5,6\n", "numbers in line 3: 'm'; .* such as x .mm."),
        ("a.csv", b"x,y,z,u,v,w\n1,2,3,4,5,6\n1,2,3,4,5\n", "numbers in line 3: invalid column index 5"),
        ("a.csv", b"x,y,z,u,v,w\n" + b"0,1," * 5 + b"0,1\n", "header, but 12 below it; with decimal commas, separate"),
        ("a.csv", b"x,y,z,u,v,w,vx,vy,vz\n1,2,3,4,5,6,7,8,9\n", "several velocities: u, v, w; vx, vy, vz; keep one"),
        ("a.csv", b"x,y,z,p\n1,2,3,4\n", "has no velocity: it has x, y, z, p"),
        ("a.csv", b"x,y,z,u [Pa],v,w\n1,2,3,4,5,6\n", "has units = 'Pa' on u, expected for example m/s"),
        ("a.stl", b"solid", "the format '.stl' is unknown"),
        *(
            pytest.param("a.nc", content, "is not a NetCDF file that can be read", marks=PEER)
            for content in (b"", b"CDF\x01zzzz", b"\x89HDF\r\n\x1a\n" + bytes(100))
        ),
        *(pytest.param("a.vtk", content, "is not a VTK file", marks=PEER) for content in (b"", b"nonsense\n")),
        pytest.param("a.vti", BOMB, "has 27000000000 nodes or more; at most 3000000 are read", marks=PEER),
        *(
            pytest.param("a.vtu", text, "is not a VTK file", marks=PEER)
            for text in (b"", b"<VTKFile></VTKFile>", b"<other/>")
        ),
    ],
)
def test_a_damaged_file_is_refused_in_a_few_words_and_prints_nothing(tmp_path, capfd, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=words):
        read_grid(tmp_path / name)
    assert capfd.readouterr() == ("", "")


@pytest.mark.peers
@pytest.mark.parametrize("kind", ["vti", "vtu"])
def test_the_velocities_of_cells_are_averaged_to_the_points(tmp_path, kind):
    """The mean over the cells around an inner point of a linear field is its value at the point."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    grid = VelocityGrid(ORIGIN, SPACING, np.zeros((5, 4, 6, 3)))
    slopes = np.random.default_rng(2).normal(size=(3, 3))
    values = (grid.nodes()[:-1, :-1, :-1] + SPACING / 2) @ slopes
    data = make_data_set(grid, kind)
    data.GetPointData().Initialize()
    array = numpy_to_vtk(values.transpose(2, 1, 0, 3).reshape(-1, 3), deep=1)
    array.SetName("U")
    data.GetCellData().AddArray(array)
    # What a program hides, such as the inside of a solid, may be anything.
    hidden = np.zeros(len(values.reshape(-1, 3)), np.uint8)
    hidden[-1] = 32
    ghosts = numpy_to_vtk(hidden, deep=1)
    ghosts.SetName("vtkGhostType")
    data.GetCellData().AddArray(ghosts)
    write_vtk(tmp_path / f"cells.{kind}", data, "Binary")
    found = read_grid(tmp_path / f"cells.{kind}")
    inner = (slice(1, -1),) * 3
    expected = grid.nodes() @ slopes
    expected[-2:, -2:, -2:] = np.nan
    np.testing.assert_allclose(found.velocity[inner], expected[inner], atol=1e-12)
    np.testing.assert_allclose(found.velocity[0, 0, 0], values[0, 0, 0], atol=1e-12)
    other = numpy_to_vtk(np.zeros((len(hidden), 3)), deep=1)
    other.SetName("velocity")
    data.GetCellData().AddArray(other)
    write_vtk(tmp_path / f"cells.{kind}", data, "Binary")
    with pytest.raises(ValueError, match="has several velocities: U, velocity; keep one of them"):
        read_grid(tmp_path / f"cells.{kind}")


@pytest.mark.parametrize(
    ("before", "heads", "separator", "after", "scale"),
    [
        ("", ["x [mm]", "y [mm]", "z [mm]", "u (cm/s)", "v (cm/s)", "w (cm/s)"], ";", "", [1e3, 1e2]),
        (
            "\n[Name]\nPlane 1, cut\n\n[Spatial Fields]\nX, Y, Z\n\n[Data]\n",
            [f"{a} [ m ]" for a in "XYZ"] + [f"Velocity {c} [ m s^-1 ]" for c in "uvw"],
            ", ",
            "\n[Faces]\n0, 1, 2\n",
            [1, 1],
        ),
        ("", [f"{a}-coordinate" for a in "xyz"] + [f"{a}-velocity" for a in "xyz"], "  ", "", [1, 1]),
        ("", [f'"{a} (m)"' for a in "XYZ"] + [f'"Velocity[{a}] (cm/s)"' for a in "ijk"], ", ", "", [1, 1e2]),
        ("% Model,pipe.mph\n", ["% x", "y", "z", *(f"{c} (m/s)" for c in "uvw")], ",", "", [1, 1]),
    ],
    ids=["semicolons and units", "CFX", "Fluent", "STAR-CCM+", "COMSOL"],
)
def test_tables_are_read_as_other_programs_write_them(tmp_path, grid, before, heads, separator, after, scale):
    table = table_of(grid) * np.repeat(scale, 3)
    rows = [separator.join(map(repr, row)) for row in table.tolist()]
    if "[Data]" in before:
        grid.velocity[0, 0, 0] = np.nan
        rows[0] = separator.join([*rows[0].split(separator)[:3], "null", "null", "null"])
    text = before + "\n".join([separator.join(heads), *rows]) + "\n" + after
    (tmp_path / "current.csv").write_text(text.replace(".", ",") if separator == ";" else text)
    agree(read_grid(tmp_path / "current.csv"), grid)
