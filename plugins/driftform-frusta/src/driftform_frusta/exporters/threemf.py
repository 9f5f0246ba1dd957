"""3MF: a plate for slicers, with the parts' names and colours, a picture, and the agent itself.

Specification: 3MF Consortium, "3D Manufacturing Format Core Specification" 1.3, and ISO/IEC 29500-2 (Open Packaging
Conventions) for the package: a zip archive of parts, with their content types and relationships.
"""

import io
import json
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from driftform.figures import files as picture_files
from driftform.interfaces import ExportJob
from driftform_frusta.colours import colour_of
from driftform_frusta.csg import MM
from driftform_frusta.exporters.base import File, PartExporter, list_facts
from driftform_frusta.exporters.scad import write_source
from driftform_frusta.parts import KIT_FILE, Part
from driftform_frusta.picture import plate_svg
from driftform_frusta.plate import arrange
from driftform_frusta.solid import make_mesh
from driftform_frusta.triangles import Mesh

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_MODEL_RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_ATTACHMENT_RELATION = "https://driftform.invalid/2026/attachment"

_TYPES = {
    "rels": "application/vnd.openxmlformats-package.relationships+xml",
    "model": "application/vnd.ms-package.3dmanufacturing-3dmodel+xml",
    "png": "image/png",
    "json": "application/json",
    "scad": "application/x-openscad",
}

_DATE = (1980, 1, 1, 0, 0, 0)
"""Of every entry of the archive: the same parts give the same bytes."""


@dataclass(frozen=True, eq=False)
class _Placed:
    """A part, its mesh as printed, and the mesh's place, mm from the middle of its plate."""

    part: Part
    mesh: Mesh
    colour: str
    plate: int
    x: float
    y: float


class ThreeMfExporter(PartExporter):
    """The parts as they are printed, upright on a plate, with names, colours, a picture and the agent's own files.

    Parts that do not fit on one plate are spread over several files. A part larger than the bed is reported and written all the same: beds differ.
    """

    name = "3mf"
    suffix = ".3mf"

    def make_files(self, job: ExportJob, parts: Sequence[Part], path: Path) -> Iterator[File]:
        """Yield the plates; facts: those of parts, the number of ``triangles``, and whether all parts of a plate ``fits_bed``."""
        placed = self.place_parts(parts)
        plates = 1 + max(p.plate for p in placed)
        attachments = {"agent.scad": write_source(job, parts, self.options)}
        if self.options.coupon:
            attachments = {}
        elif job.document:
            attachments["agent.json"] = json.dumps(dict(job.document), indent=1) + "\n"
        if self.options.kit and not self.options.coupon:
            # 'driftform check' makes the same kit again, to compare it.
            attachments[KIT_FILE] = self.options.model_dump_json(indent=1) + "\n"
        for number in range(plates):
            here = [p for p in placed if p.plate == number]
            title = job.name if plates == 1 else f"{job.name}, plate {number + 1} of {plates}"
            target = path if plates == 1 else path.with_name(f"{path.stem}-plate-{number + 1}{path.suffix}")
            sizes = np.array([np.ptp(p.mesh.bounds, axis=0) for p in here])
            facts = list_facts([p.part for p in here], job.agent.body) | {
                "triangles": sum(len(p.mesh.triangles) for p in here),
                "fits_bed": bool((sizes <= np.array(self._bed) + 1e-6).all()),
            }
            yield target, self._pack(title, job, here, attachments), facts

    def place_parts(self, parts: Sequence[Part]) -> list[_Placed]:
        """Return parts with their meshes as printed and their places on plates."""
        meshes = [make_mesh(part.on_bed(), part.name) for part in parts]
        boxes = [mesh.bounds[:, :2] for mesh in meshes]
        sizes = [(float(width), float(depth)) for width, depth in np.ptp(boxes, axis=1)]
        placed: list[_Placed] = []
        for part, mesh, box, spot in zip(parts, meshes, boxes, arrange(sizes, self._bed[:2]), strict=True):
            x, y = (box.sum(axis=0) / 2).tolist()
            colour = colour_of(len(placed))
            placed.append(_Placed(part, mesh, colour, spot.plate, spot.x - x, spot.y - y))
        return placed

    @property
    def _bed(self) -> tuple[float, float, float]:
        """Width, depth and height, mm."""
        x, y, z = (MM * side for side in self.options.bed)
        return x, y, z

    def _pack(self, title: str, job: ExportJob, placed: Sequence[_Placed], attachments: dict[str, str]) -> bytes:
        body, mass = job.agent.body, job.agent.mass
        grams = {p.part.name: 1e-6 * p.part.solid.volume * body.hull_density for p in placed}
        weights = ", ".join(f"{name} {weight:.2f} g" for name, weight in grams.items())
        description = (
            f"Hull of a passive underwater agent, evolved by driftform. Printed mass: {weights}. As simulated, with its "
            f"core, the agent weighs {1e3 * mass.mass:.2f} g and displaces {1e6 * mass.volume:.2f} cm3."
        )
        picture = self.draw_plate(placed)
        metadata = {"Title": title, "Application": "driftform", "Description": description}
        return _package(_write_model(placed, self._bed, metadata), picture, attachments)

    def draw_plate(self, placed: Sequence[_Placed], width: float = 160.0, height: float = 120.0) -> bytes:
        """Return a picture of parts on a plate, as a PNG file of some size in px."""
        shapes = [(p.mesh.translate((p.x, p.y, 0.0)), p.colour) for p in placed]
        return picture_files.rasterise(plate_svg(shapes, self._bed[0], width, height)) or b""


def _package(model: str, thumbnail: bytes, attachments: Mapping[str, str]) -> bytes:
    """Return a 3MF file of a model with a PNG picture, empty for none, and other files by their names."""
    types = "".join(f'<Default Extension="{ending}" ContentType="{kind}"/>' for ending, kind in _TYPES.items())
    listed = f'<?xml version="1.0" encoding="UTF-8"?>\n<Types xmlns="{_PACKAGE}/content-types">{types}</Types>\n'
    entries: dict[str, bytes | str] = {"[Content_Types].xml": listed}
    relations = [("/3D/3dmodel.model", _MODEL_RELATION)]
    if thumbnail:
        relations.append(("/Metadata/thumbnail.png", f"{_PACKAGE}/relationships/metadata/thumbnail"))
        entries["Metadata/thumbnail.png"] = thumbnail
    entries["_rels/.rels"] = _relations(relations)
    if attachments:
        attached = [(f"/Metadata/{name}", _ATTACHMENT_RELATION) for name in attachments]
        entries["3D/_rels/3dmodel.model.rels"] = _relations(attached)
    entries["3D/3dmodel.model"] = model
    entries |= {f"Metadata/{name}": text for name, text in attachments.items()}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in entries.items():
            entry = zipfile.ZipInfo(name, _DATE)
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".png") else zipfile.ZIP_DEFLATED
            # A higher level takes four times as long for a tenth of the size.
            archive.writestr(entry, data, compresslevel=1)
    return stream.getvalue()


def _relations(targets: Sequence[tuple[str, str]]) -> str:
    rows = "".join(
        f'<Relationship Id="rel{i}" Target={quoteattr(target)} Type="{kind}"/>'
        for i, (target, kind) in enumerate(targets, 1)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<Relationships xmlns="{_PACKAGE}/relationships">{rows}</Relationships>\n'
    )


def _write_model(items: Sequence[_Placed], bed: tuple[float, float, float], metadata: Mapping[str, str]) -> str:
    """Return the model; parts lie on a plate whose corner is the origin, and whose middle is that of the bed (mm)."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<model unit="millimeter" xml:lang="en" xmlns="{_CORE}">',
        *(f"<metadata name={quoteattr(name)}>{escape(value)}</metadata>" for name, value in metadata.items()),
        "<resources>",
        '<basematerials id="1">',
        *(f'<base name={quoteattr(item.part.name)} displaycolor="{item.colour.upper()}FF"/>' for item in items),
        "</basematerials>",
    ]
    for index, item in enumerate(items):
        vertices, triangles = item.mesh.vertices, item.mesh.triangles
        # Nine digits bring back the same number in single precision.
        points = '<vertex x="%.9g" y="%.9g" z="%.9g"/>' * len(vertices) % tuple(vertices.ravel().tolist())
        faces = '<triangle v1="%d" v2="%d" v3="%d"/>' * len(triangles) % tuple(triangles.ravel().tolist())
        lines += [
            f'<object id="{index + 2}" type="model" name={quoteattr(item.part.name)} pid="1" pindex="{index}"><mesh>',
            f"<vertices>{points}</vertices>",
            f"<triangles>{faces}</triangles>",
            "</mesh></object>",
        ]
    lines += ["</resources>", "<build>"]
    lines += [
        f'<item objectid="{index + 2}" transform="1 0 0 0 1 0 0 0 1 {bed[0] / 2 + item.x:.6g} {bed[1] / 2 + item.y:.6g} 0"/>'
        for index, item in enumerate(items)
    ]
    return "\n".join([*lines, "</build>", "</model>", ""])
