"""Velocities on regular grids, from files of CFD programs: CSV, NetCDF and VTK; and nodes without one, filled."""

import csv
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count, islice, product, takewhile
from pathlib import Path
from typing import Any, NamedTuple
from warnings import catch_warnings

import numpy as np

from driftform.errors import describe_error
from driftform.types import BoolArray, FloatArray
from driftform.util import foreign
from driftform.util.files import find_encoding

__all__ = ["VelocityGrid", "fill_nodes", "read_grid"]

MAX_NODES = 3_000_000
"""Most nodes of a grid: their velocities take 72 MB, and to read and to fill them takes 500 MB."""

MEMORY = 500 << 20
"""Memory in which a file is read, bytes."""

UNEVEN = 1e-3
"""Largest deviation of a node from its place in a regular grid, in spacings."""

_PREAMBLE = 50
"""Lines at the beginning of a table among which the names of its columns are looked for."""

LINEAR_LAYERS = 3
"""Layers of nodes beyond the water that are extrapolated linearly; further out the velocity is constant."""

_NAMES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
"""Names of columns, variables, vectors and units."""

LENGTHS: Mapping[str, float] = _NAMES["lengths"]
"""Units of coordinates, m."""

SPEEDS = {f"{m}/{s}": length / time for s, time in _NAMES["times"].items() for m, length in LENGTHS.items()} | _NAMES[
    "knots"
]
"""Units of velocities, m/s."""


class _TooLargeError(ValueError):
    """A file holds more than is read."""


@dataclass(frozen=True, eq=False)
class VelocityGrid:
    """Velocities at the nodes of a regular grid.

    Attributes:
        origin: first node, m, (3,).
        spacing: of the nodes along x, y and z, m, (3,).
        velocity: at the nodes, m/s, (nx, ny, nz, 3); NaN where the file has none.
    """

    origin: FloatArray
    spacing: FloatArray
    velocity: FloatArray

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of nodes along x, y and z."""
        nx, ny, nz, _ = self.velocity.shape
        return nx, ny, nz

    @property
    def end(self) -> FloatArray:
        """Last node, m, (3,)."""
        return np.asarray(self.origin + self.spacing * (np.array(self.shape) - 1))

    def nodes(self) -> FloatArray:
        """Return the positions of all nodes, m, (nx, ny, nz, 3)."""
        axes = [o + s * np.arange(n) for o, s, n in zip(self.origin, self.spacing, self.shape, strict=True)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def read_grid(path: Path) -> VelocityGrid:
    """Read a grid; the ending of the file's name, .csv, .nc, .vtk, .vti, .vtr, .vts or .vtu, decides the format.

    Raises:
        ValueError: if the file cannot be read, has no velocities, or is not a regular grid; the message does not name
            the file.
        ModuleNotFoundError: if netCDF4 or VTK, extras ``netcdf`` and ``vtk``, are missing.
    """
    if path.suffix.lower() == ".csv":
        try:
            return _read_csv(path)
        except OSError as error:
            raise ValueError(f"cannot be read: {error.strerror or error}") from None
    if path.suffix.lower() not in _READERS:
        known = ", ".join((".csv", *_READERS))
        raise ValueError(f"the format '{path.suffix}' is unknown; it must be one of {known}")
    return VelocityGrid(*foreign.call_apart(_read_foreign, path, memory=MEMORY))


def _read_foreign(name: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the values of a grid whose file a package of others reads, in a process with limits."""
    path = Path(name)
    grid = _READERS[path.suffix.lower()](path)
    return grid.origin, grid.spacing, grid.velocity


def _read_csv(path: Path) -> VelocityGrid:
    """Read a table, one node per row in any order, with the names of its columns in a line before.

    Columns are separated by commas, by semicolons (numbers may have decimal commas then) or by spaces. A name may end in a
    unit in brackets. Lines before the names, and what follows the table, as CFX writes them, are left out.
    """
    with path.open("rb") as start:
        encoding = find_encoding(start.read(65536))
    with path.open(encoding=encoding, errors="replace") as file:
        first = [*islice(file, _PREAMBLE)]
        heading, separator = _find_heading(first)
        heads = [_split_unit(cell) for cell in _split_cells(first[heading], separator)] if first else []
        names, units = [name for name, _ in heads], dict(heads)
        places, velocities = _choose("coordinates", units), _choose("velocity", units)
        below = chain(first[heading + 1 :], file)
        number = count(heading + 2)
        # CFX writes null where there is no value, and what else it knows of the surface after the table.
        rows = (
            line.replace(",", "," if separator == "," else ".").replace("null", "nan")
            for _, line in zip(number, takewhile(lambda line: not line.startswith("["), below), strict=False)
        )
        wide = next((len(_split_cells(line, separator)) for line in first[heading + 1 :] if line.strip()), len(names))
        if wide != len(names):
            hint = "; with decimal commas, separate columns by semicolons" if wide == 2 * len(names) else ""
            raise ValueError(f"has {len(names)} columns in its header, but {wide} below it{hint}")
        used = [*places, *velocities, *({"vtkValidPointMask"} & units.keys())]
        try:
            with catch_warnings(action="ignore"):
                table = np.loadtxt(
                    rows,
                    delimiter=separator,
                    ndmin=2,
                    usecols=[names.index(name) for name in used],
                    quotechar='"',
                    max_rows=MAX_NODES + 1,
                )
        except ValueError as error:
            cell = re.match("could not convert string ('.*') to", str(error))
            raise ValueError(
                f"is not a table of numbers in line {next(number) - 1}: {cell[1][:40] if cell else error}; it must have numbers alone, "
                "nan where there are none, and units in the names, such as x [mm]"
            ) from None
    if not table.size:
        raise ValueError("has no line below its header")
    table[:, :6] *= [find_unit(name, units[name], LENGTHS if name in places else SPEEDS) for name in used[:6]]
    table[(table[:, 6:] == 0).any(axis=1), 3:] = np.nan
    return _sort_nodes(table[:, :3], table[:, 3:6])


def _split_cells(line: str, separator: str | None) -> list[str]:
    line = line.lstrip("%# ")
    return (
        line.split() if separator is None else next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    )


def _find_heading(lines: Sequence[str]) -> tuple[int, str | None]:
    """Return which line of the beginning of a table has the names of its columns, and what separates them.

    It is the first with names of coordinates, of CFX that below ``[Data]``; else the first line, which is then shown as what
    the file has.
    """
    begin = next((number for number, line in enumerate(lines) if line.startswith("[Data]")), 0)
    for number, line in enumerate(lines[begin:], begin):
        separator = next((mark for mark in ";," if mark in line), None)
        names = {_split_unit(cell)[0] for cell in _split_cells(line, separator)}
        if any(names.issuperset(places) for places in _NAMES["coordinates"]):
            return number, separator
    return 0, ","


def _split_unit(head: str) -> tuple[str, str]:
    """Return the name of a column, and the unit in brackets after it; the unit is empty if there is none."""
    found = re.fullmatch(r"(.*?)\s*[\[(]([^\[(]*)[\])]", head.strip())
    return (found[1], found[2]) if found else (head.strip(), "")


def _choose(what: str, found: Mapping[str, object]) -> Sequence[str]:
    known: list[list[str]] = _NAMES[what]
    several = [names for names in known if all(name in found for name in names)]
    if len(several) > 1 and what == "velocity":
        raise ValueError(f"has several velocities: {'; '.join(map(', '.join, several))}; keep one of them")
    if several:
        return several[0]
    choices = "; ".join(", ".join(names) for names in known)
    raise ValueError(f"has no {what}: it has {', '.join(map(str, found)) or 'no columns'}, but not {choices}")


def find_unit(name: str, unit: str, known: Mapping[str, float]) -> float:
    """Return a unit, as programs write it, in SI units; 1 for an empty one. Raises ValueError if it is not ``known``."""
    plain = re.sub(r"[\s.*^_]", "", unit)
    for spelling, short in _NAMES["spellings"].items():
        plain = re.sub(spelling, short, plain, flags=re.IGNORECASE)
    if plain and plain not in known:
        raise ValueError(f"has units = '{unit}' on {name}, expected for example {', '.join([*known][:4])}")
    return known.get(plain, 1.0)


def _check_count(nodes: float) -> None:
    if nodes > MAX_NODES:
        raise ValueError(f"has {nodes:.0f} nodes or more; at most {MAX_NODES} are read")


def _sort_nodes(points: FloatArray, velocities: FloatArray) -> VelocityGrid:
    """Return the grid of nodes in any order; nodes that are left out have no velocity."""
    _check_count(len(points))
    if not np.isfinite(points).all():
        raise ValueError("has coordinates that are not finite")
    index, axes = np.empty(points.shape, dtype=np.int64), []
    for a in range(3):
        values = np.unique(points[:, a])
        # Coordinates with few digits differ slightly from node to node.
        starts = np.concatenate([[True], np.diff(values) > 1e-5 * (values[-1] - values[0])])
        axes.append(_check_axis("xyz"[a], values[starts]))
        place = (points[:, a] - axes[-1][0]) / axes[-1][1]
        index[:, a] = np.rint(place)
        if np.abs(place - index[:, a]).max() > 10 * UNEVEN:
            raise ValueError(f"is not a regular grid: its nodes are not evenly spaced along {'xyz'[a]}")
    shape = tuple(int(count) for _, _, count in axes)
    if np.prod(shape) > MAX_NODES:
        raise ValueError(
            f"is not a regular grid: {len(points)} nodes have {' x '.join(map(str, shape))} different coordinates"
        )
    flat = np.ravel_multi_index(tuple(index.T), shape)
    if len(np.unique(flat)) < len(flat):
        raise ValueError("has several velocities at one node; the current must be steady")
    velocity = np.full((*shape, 3), np.nan)
    velocity.reshape(-1, 3)[flat] = velocities
    origin, spacing, _ = np.array(axes).T
    return VelocityGrid(origin, spacing, velocity)


def _check_axis(name: str, values: FloatArray) -> tuple[float, float, int]:
    """Return origin, spacing and number of nodes along an axis."""
    if len(values) < 4:
        raise ValueError(f"has {len(values)} different values of {name}; at least 4 are needed")
    spacing = (values[-1] - values[0]) / (len(values) - 1)
    if np.abs(values - values[0] - spacing * np.arange(len(values))).max() > UNEVEN * spacing:
        raise ValueError(
            f"is not a regular grid: its nodes are not evenly spaced along {name}; resample it, for example with the filter "
            "ResampleToImage of ParaView"
        )
    return float(values[0]), float(spacing), len(values)


def _read_netcdf(path: Path) -> VelocityGrid:
    """Read variables x, y, z with one dimension each, and u, v, w with the three dimensions in any order."""
    variables = _load_variables(path)
    places = _choose("coordinates", variables)
    velocities = _choose("velocity", variables)
    for name in (places[2], velocities[2]):
        attributes = variables[name].attributes
        for key, value in attributes.items():
            if "up" not in attributes.get("positive", "").lower() and re.search("down|depth", value, re.IGNORECASE):
                raise ValueError(f"has {key} = '{value}' on {name}; z and its velocity must be positive upward")
    names = []
    for name in places:
        dimensions = variables[name].dimensions
        if len(dimensions) != 1:
            raise ValueError(f"has a variable {name} with {len(dimensions)} dimensions instead of one")
        names.append(dimensions[0])
    axes = [
        variables[name].values * find_unit(name, variables[name].attributes.get("units", ""), LENGTHS)
        for name in places
    ]
    order = [np.argsort(values) for values in axes]
    found = [_check_axis(name, values[o]) for name, values, o in zip("xyz", axes, order, strict=True)]
    parts = []
    for name in velocities:
        dimensions, values = variables[name].dimensions, variables[name].values
        kept = [d for d in dimensions if values.shape[dimensions.index(d)] > 1 or d in names]
        if sorted(kept) != sorted(names):
            raise ValueError(
                f"has a variable {name} over {', '.join(dimensions)}, expected {', '.join(names)}; the current must be steady"
            )
        values = values.reshape([values.shape[dimensions.index(d)] for d in kept])
        values = values.transpose([kept.index(n) for n in names])[np.ix_(*order)]
        parts.append(values * find_unit(name, variables[name].attributes.get("units", ""), SPEEDS))
    origin, spacing, _ = np.array(found).T
    return VelocityGrid(origin, spacing, np.stack(parts, axis=-1))


class _Variable(NamedTuple):
    """A variable of a NetCDF file: its dimensions, its values, NaN where they are missing, and its attributes of meaning."""

    dimensions: tuple[str, ...]
    values: FloatArray
    attributes: Mapping[str, str]


def _load_variables(path: Path) -> dict[str, _Variable]:
    """Return the variables with numbers; netCDF4 unpacks them, and masks fill values and what is out of the valid range."""
    import netCDF4

    found, where = {}, ""
    try:
        with netCDF4.Dataset(path) as file:
            for name, variable in file.variables.items():
                if getattr(variable.dtype, "kind", "") not in "fiu":
                    continue
                where = f" in its variable {name}"
                if variable.size > MAX_NODES:
                    raise _TooLargeError(
                        f"has {variable.size} values in the variable {name}; a grid has at most {MAX_NODES} nodes"
                    )
                values = np.ma.filled(np.ma.array(variable[...], dtype=np.float64), np.nan)
                attributes: dict[str, str] = {
                    key: str(variable.getncattr(key)).strip()
                    for key in ("units", "positive", "_CoordinateZisPositive", "standard_name", "long_name")
                    if key in variable.ncattrs()
                }
                found[name] = _Variable(variable.dimensions, values, attributes)
    except _TooLargeError:
        raise
    except Exception as error:
        # Damaged files raise whatever the first wrong byte leads to: KeyError, RuntimeError, MemoryError and others.
        reason = error.strerror if isinstance(error, OSError) else describe_error(error)
        raise ValueError(f"is not a NetCDF file that can be read{where}: {reason}") from None
    return found


def _read_vtk(path: Path) -> VelocityGrid:
    """Read a data set of VTK, legacy or XML, of any kind, with a vector at each point, or in each cell.

    Finite-volume programs have one velocity for each cell: a point has the mean of the cells around it.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkCellDataToPointData
    from vtkmodules.vtkFiltersGeneral import vtkImageDataToPointSet, vtkRectilinearGridToPointSet

    data = _load_data_set(path)
    vectors = _find_vector(data.GetPointData())
    cells = data.GetCellData()
    if vectors is None and (found := _find_vector(cells)) is not None:
        if (ghosts := cells.GetArray("vtkGhostType")) is not None:
            vtk_to_numpy(found)[vtk_to_numpy(ghosts) & 32 != 0] = np.nan
        data = _convert(vtkCellDataToPointData(), data)
        vectors = _find_vector(data.GetPointData())
    if vectors is None:
        parts = (data.GetPointData(), cells)
        names = [part.GetArrayName(i) for part in parts for i in range(part.GetNumberOfArrays())]
        raise ValueError(
            f"has no velocity: its points and cells have {', '.join(names) or 'no data'}, but not a vector of three numbers named "
            f"{', '.join(_NAMES['vectors'])}"
        )
    velocity = np.array(vtk_to_numpy(vectors), dtype=np.float64)
    if (valid := data.GetPointData().GetArray("vtkValidPointMask")) is not None:
        velocity[vtk_to_numpy(valid) == 0] = np.nan
    if (ghosts := data.GetPointData().GetArray("vtkGhostType")) is not None:
        velocity[vtk_to_numpy(ghosts) & 2 != 0] = np.nan
    for kind, convert in (("ImageData", vtkImageDataToPointSet), ("RectilinearGrid", vtkRectilinearGridToPointSet)):
        if data.IsA(f"vtk{kind}"):
            data = _convert(convert(), data)
    return _sort_nodes(np.array(vtk_to_numpy(data.GetPoints().GetData()), dtype=np.float64), velocity)


def _load_data_set(path: Path) -> Any:
    """Return the data set of a VTK file. What VTK prints of a damaged file becomes the reason why it is refused."""
    from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOLegacy import vtkDataSetReader
    from vtkmodules.vtkIOXML import vtkXMLGenericDataObjectReader

    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    reader = vtkDataSetReader() if path.suffix.lower() == ".vtk" else vtkXMLGenericDataObjectReader()
    if path.suffix.lower() == ".vtk":
        for part in ("Vectors", "Scalars", "Fields"):
            getattr(reader, f"ReadAll{part}On")()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    # Of the points of a grid, which the header counts, the reader would make room for all.
    extent = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT())
    _check_count(np.prod(np.diff(np.reshape(extent, (3, 2)).astype(float)) + 1) if extent else 0)
    reader.Update()
    data, printed = reader.GetOutputDataObject(0), str(window.GetOutput())
    if printed or data is None or not data.IsA("vtkDataSet") or not data.GetNumberOfPoints():
        reason = re.search(r"\): (.{0,200})", printed)
        raise ValueError(f"is not a VTK file that can be read{': ' + reason[1] if reason else ''}")
    _check_count(data.GetNumberOfPoints())
    return data


def _convert(step: Any, data: Any) -> Any:
    """Return what a filter of VTK makes of a data set."""
    step.SetInputData(data)
    step.Update()
    return step.GetOutput()


def _find_vector(data: Any) -> Any:
    """Return the velocity in the data of VTK's points or cells, or ``None``."""
    arrays = [data.GetArray(name) for name in _NAMES["vectors"]]
    vectors = [array for array in arrays if array is not None and array.GetNumberOfComponents() == 3]
    if len(vectors) > 1:
        raise ValueError(f"has several velocities: {', '.join(array.GetName() for array in vectors)}; keep one of them")
    return vectors[0] if vectors else None


_READERS = {".nc": _read_netcdf, **dict.fromkeys((".vtk", ".vti", ".vtr", ".vts", ".vtu"), _read_vtk)}
"""Readers by the ending of the file's name."""


def fill_nodes(velocity: FloatArray, known: BoolArray) -> FloatArray:
    """Return velocities at all nodes: extrapolated linearly from known neighbours, and constant further away.

    Args:
        velocity: (nx, ny, nz, 3).
        known: whether the velocity of a node is known, (nx, ny, nz).
    """
    from scipy.ndimage import distance_transform_edt

    if not known.any():
        raise ValueError("has no node in the pipe: do their origins and units agree?")
    # With two layers of nodes around that stay unknown, for the second neighbours of the outermost.
    values = np.pad(np.where(known[..., None], velocity, 0.0), [*[(2, 2)] * 3, (0, 0)])
    known, inside = np.pad(known, 2), np.pad(np.ones_like(known), 2)
    for _ in range(LINEAR_LAYERS):
        total, count = np.zeros_like(values), np.zeros(known.shape)
        for axis, step in product(range(3), (1, -1)):
            near, far = (np.roll(values, k * step, axis) for k in (1, 2))
            both = np.roll(known, step, axis) & np.roll(known, 2 * step, axis)
            total += np.where(both[..., None], 2 * near - far, 0.0)
            count += both
        new = inside & ~known & (count > 0)
        values[new] = total[new] / count[new, None]
        known |= new
    values, known = values[2:-2, 2:-2, 2:-2], known[2:-2, 2:-2, 2:-2]
    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(nearest)])
