"""Reading 3MF files: the parts on the plate, placed and in mm (3MF Core Specification 1.3)."""

import zipfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray
from driftform.util import foreign
from driftform_frusta.triangles import Mesh

_UNITS = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}

_RELATIONSHIP = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"

_MAX_BYTES = 1 << 27
"""Bytes of all files that are read from the archive, unpacked."""

_MAX_DEPTH = 32
"""Components within components."""


MAX_PIECES = 10_000
"""Largest number of meshes in a file, each counted as often as it is placed."""

MAX_ELEMENTS = 5_000_000
"""Largest number of triangles, and of vertices, in a file, with those of all placed copies."""


def check_counts(pieces: int, elements: int) -> None:
    """Refuse a file that a few bytes could make larger than any memory, by placing copies of copies.

    Raises ValueError if it has more than :data:`MAX_PIECES` meshes or :data:`MAX_ELEMENTS` triangles or vertices.
    """
    if pieces > MAX_PIECES:
        raise ValueError(f"places more than {MAX_PIECES} meshes")
    if elements > MAX_ELEMENTS:
        raise ValueError(f"has more than {MAX_ELEMENTS} triangles or vertices")


def read_3mf(path: Path) -> tuple[Mesh, ...]:
    """Return the parts that the build section places.

    Raises ValueError if it is not a 3MF file; the message has the reason.
    """
    return tuple(Mesh(*values) for values in foreign.call_apart(_read_values, path))


def _read_values(path: str) -> list[tuple[FloatArray, npt.NDArray[np.int64], str]]:
    """Return vertices, triangles and name of each part, in a process with limits."""
    try:
        with zipfile.ZipFile(path) as archive:
            return [(part.vertices, part.triangles, part.name) for part in _Package(archive).parts()]
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError) as error:
        # The directory of an archive is at its end.
        if not zipfile.is_zipfile(path) and Path(path).read_bytes().startswith(b"PK\3\4"):
            raise ValueError("is truncated: the end of its archive is missing; export it again") from None
        raise ValueError(f"is not a 3MF archive: {error}") from None
    except ElementTree.ParseError as error:
        raise ValueError(f"its model is not XML: {error}") from None
    except KeyError as error:
        raise ValueError(f"lacks {error}") from None


class _Package:
    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        # Each is read once, however often it is placed.
        self._model = cache(lambda path: ElementTree.fromstring(self._read(path)))
        self._objects = cache(self._list_objects)
        self._meshes = cache(self._read_meshes)
        self._unpacked = self._visited = self._vertices = self._triangles = 0

    def parts(self) -> tuple[Mesh, ...]:
        from trimesh.util import append_faces

        root = self._root()
        model = self._model(root)
        found, unit = [], model.get("unit", "millimeter")
        if unit not in _UNITS:
            raise ValueError(f"is in the unit '{unit}', which 3MF does not have")
        for item in model.iterfind("{*}build/{*}item"):
            identifier = item.attrib["objectid"]
            path = _path_of(item, root)
            pieces = list(self._pieces(path, identifier, _transform(item), 0))
            if not pieces:
                continue
            named = item.get("partnumber") or self._object(path, identifier).get("name")
            name = named or f"object {identifier}"
            vertices, triangles = append_faces([p.vertices for p in pieces], [p.triangles for p in pieces])
            whole = Mesh(vertices * _UNITS[unit], triangles.astype(np.int64), name)
            found.append(whole.merge_vertices())
        return tuple(found)

    def _pieces(self, path: str, identifier: str, transform: FloatArray, depth: int) -> Iterator[Mesh]:
        """Meshes of an object and of its components, placed, in the unit of the model."""
        if depth > _MAX_DEPTH:
            raise ValueError(f"has components within components, more than {_MAX_DEPTH} deep")
        self._visited += 1
        check_counts(self._visited, 0)
        item = self._object(path, identifier)
        if item.get("type", "model") in ("support", "solidsupport"):
            return
        for mesh in self._meshes(path, identifier):
            self._vertices += len(mesh.vertices)
            self._triangles += len(mesh.triangles)
            check_counts(self._visited, max(self._vertices, self._triangles))
            # A mirror turns a mesh inside out: undone, as in the specification (3.4.1).
            triangles = mesh.triangles[:, ::-1] if np.linalg.det(transform[:3]) < 0 else mesh.triangles
            yield Mesh(mesh.vertices @ transform[:3] + transform[3], triangles)
        for component in item.iterfind("{*}components/{*}component"):
            inner = _transform(component)
            placed = np.vstack((inner[:3] @ transform[:3], inner[3] @ transform[:3] + transform[3]))
            yield from self._pieces(_path_of(component, path), component.attrib["objectid"], placed, depth + 1)

    def _read_meshes(self, path: str, identifier: str) -> list[Mesh]:
        """Meshes of an object alone, without those of its components."""
        return [_read_mesh(mesh, identifier) for mesh in self._object(path, identifier).iterfind("{*}mesh")]

    def _object(self, path: str, identifier: str) -> ElementTree.Element:
        if identifier not in self._objects(path):
            raise ValueError(f"places object {identifier}, which is missing")
        return self._objects(path)[identifier]

    def _list_objects(self, path: str) -> dict[str | None, ElementTree.Element]:
        items = list(self._model(path).iterfind("{*}resources/{*}object"))
        # Of several with one id, the first.
        return {item.get("id"): item for item in reversed(items)}

    def _root(self) -> str:
        for relationship in ElementTree.fromstring(self._read("_rels/.rels")):
            if relationship.get("Type") == _RELATIONSHIP:
                return relationship.attrib["Target"].lstrip("/")
        raise ValueError("names no model in _rels/.rels")

    def _read(self, name: str) -> bytes:
        self._unpacked += self._archive.getinfo(name).file_size
        if self._unpacked > _MAX_BYTES:
            raise ValueError(f"unpacks to more than {_MAX_BYTES >> 20} MB")
        content = self._archive.read(name)
        # A tree of elements takes a hundred times the memory of the shortest text of one.
        check_counts(0, content.count(b"<") // 2)
        return content


def _read_mesh(mesh: ElementTree.Element, identifier: str) -> Mesh:
    vertices = [[float(v.attrib[axis]) for axis in "xyz"] for v in mesh.iterfind("{*}vertices/{*}vertex")]
    corners = [
        [int(t.attrib[corner]) for corner in ("v1", "v2", "v3")] for t in mesh.iterfind("{*}triangles/{*}triangle")
    ]
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    triangles = np.array(corners, dtype=np.int64).reshape(-1, 3)
    if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(points):
        raise ValueError(f"object {identifier} has triangles on missing vertices")
    return Mesh(points, triangles)


def _transform(element: ElementTree.Element) -> FloatArray:
    """Of row vectors: three rows that turn and scale, and one that moves, (4, 3)."""
    text = element.get("transform")
    if text is None:
        return np.vstack((np.eye(3), np.zeros(3)))
    values = [float(word) for word in text.split()]
    if len(values) != 12:
        raise ValueError(f"has a transform of {len(values)} numbers in place of 12")
    return np.array(values).reshape(4, 3)


def _path_of(element: ElementTree.Element, here: str) -> str:
    """The model that an element refers to: its own, or another by the production extension."""
    other = next((value for key, value in element.attrib.items() if key.endswith("}path")), here)
    return str(PurePosixPath(other)).lstrip("/")
