"""Results as GeoJSON, for QGIS and other programs that show maps."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from driftform.errors import InputError
from driftform.util import files
from driftform_networks.hydraulics.network import Network


def check_crs(crs: str | None) -> None:
    """Refuse what names no coordinate reference system. Raises InputError if it is not ``EPSG:`` with a number."""
    if crs is not None and not re.fullmatch(r"EPSG:\d{4,6}", crs):
        raise InputError(f"--crs {crs}: expected the number of a coordinate reference system, such as EPSG:25832")


def write_geojson(
    folder: Path, network: Network, tables: Mapping[str, Mapping[str, Sequence[Any]]], crs: str | None
) -> list[Path]:
    """Write the tables of nodes and links, each as the layer of its name, and return the files.

    Points and lines have the coordinates of the network's file. A ``crs`` is named as GeoJSON of 2008 does, which GDAL
    and QGIS read; in RFC 7946 coordinates are longitude and latitude, and nothing is named.
    The first column of a table, ``node`` or ``link``, has the names of what each row is about.

    Raises InputError if the network has no coordinates.
    """
    if not np.isfinite(network.places).any():
        raise InputError(f"{network.name}: the file gives its nodes no coordinates: leave out --gis")
    named = {"name": f"urn:ogc:def:crs:{(crs or '').replace(':', '::')}"}
    system = {} if crs in (None, "EPSG:4326") else {"crs": {"type": "name", "properties": named}}
    written = []
    for name, columns in tables.items():
        kind = next(iter(columns))
        if kind not in ("node", "link"):
            continue
        known = {key: row for row, key in enumerate(network.nodes if kind == "node" else network.links)}
        features = []
        for row in zip(*columns.values(), strict=True):
            index = known[row[0]]
            line = network.places[[index]] if kind == "node" else network.polyline(index)
            # JSON has no NaN.
            values = [None if isinstance(value, float) and not np.isfinite(value) else value for value in row]
            place = line.tolist() if kind == "link" else line[0].tolist()
            shape = {"type": "LineString" if kind == "link" else "Point", "coordinates": place}
            features.append(
                {"type": "Feature", "properties": dict(zip(columns, values, strict=True))}
                | {"geometry": shape if np.isfinite(line).all() else None}
            )
        document = {"type": "FeatureCollection", "name": name, **system, "features": features}
        written.append(folder / f"{name}.geojson")
        files.write_text(written[-1], json.dumps(document, ensure_ascii=False) + "\n")
    return written
