"""3MF packages: parts on a plate with their names and colours, and what else is worth keeping with them.

Specification: 3MF Consortium, "3D Manufacturing Format Core Specification" 1.3, and ISO/IEC 29500-2 (Open Packaging
Conventions) for the package: a zip archive of parts, with their content types and relationships.
"""

import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from driftform_frusta.triangles import Mesh

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_OURS = "https://driftform.invalid/2026/print"
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
class Item:
    """One part: its name, colour (``#rrggbb``), mesh in mm, and the place of its origin on the plate, mm."""

    name: str
    colour: str
    mesh: Mesh
    position: tuple[float, float]


def package_bytes(
    title: str,
    items: Sequence[Item],
    facts: Mapping[str, str],
    hints: Mapping[str, str],
    thumbnail: bytes,
    attachments: Mapping[str, str],
) -> bytes:
    """Return a 3MF file.

    Args:
        title: shown by slicers.
        items: the parts on the plate, whose corner is the origin.
        facts, hints: metadata by the names of the specification, such as ``Description``, and of our own, by names of
            letters.
        thumbnail: a PNG picture, empty for none.
        attachments: other files by their names; known endings are ``.json`` and ``.scad``.
    """
    entries: dict[str, bytes | str] = {"[Content_Types].xml": _content_types()}
    relations = [("/3D/3dmodel.model", _MODEL_RELATION)]
    if thumbnail:
        relations.append(("/Metadata/thumbnail.png", f"{_PACKAGE}/relationships/metadata/thumbnail"))
        entries["Metadata/thumbnail.png"] = thumbnail
    entries["_rels/.rels"] = _relations(relations)
    if attachments:
        attached = [(f"/Metadata/{name}", _ATTACHMENT_RELATION) for name in attachments]
        entries["3D/_rels/3dmodel.model.rels"] = _relations(attached)
    own = {f"driftform:{name}": value for name, value in hints.items()}
    entries["3D/3dmodel.model"] = _model(items, {"Title": title, "Application": "driftform", **facts, **own})
    entries |= {f"Metadata/{name}": text for name, text in attachments.items()}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in entries.items():
            entry = zipfile.ZipInfo(name, _DATE)
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".png") else zipfile.ZIP_DEFLATED
            # A higher level takes four times as long for a tenth of the size.
            archive.writestr(entry, data, compresslevel=1)
    return stream.getvalue()


def _content_types() -> str:
    types = "".join(f'<Default Extension="{ending}" ContentType="{kind}"/>' for ending, kind in _TYPES.items())
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<Types xmlns="{_PACKAGE}/content-types">{types}</Types>\n'


def _relations(targets: Sequence[tuple[str, str]]) -> str:
    rows = "".join(
        f'<Relationship Id="rel{i}" Target={quoteattr(target)} Type="{kind}"/>'
        for i, (target, kind) in enumerate(targets, 1)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<Relationships xmlns="{_PACKAGE}/relationships">{rows}</Relationships>\n'
    )


def _model(items: Sequence[Item], metadata: Mapping[str, str]) -> str:
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<model unit="millimeter" xml:lang="en" xmlns="{_CORE}" xmlns:driftform="{_OURS}">',
        *(f"<metadata name={quoteattr(name)}>{escape(value)}</metadata>" for name, value in metadata.items()),
        "<resources>",
        '<basematerials id="1">',
        *(f'<base name={quoteattr(item.name)} displaycolor="{item.colour.upper()}FF"/>' for item in items),
        "</basematerials>",
    ]
    for index, item in enumerate(items):
        lines += [
            f'<object id="{index + 2}" type="model" name={quoteattr(item.name)} pid="1" pindex="{index}"><mesh>',
            _vertices(item.mesh),
            _triangles(item.mesh),
            "</mesh></object>",
        ]
    lines += ["</resources>", "<build>"]
    lines += [
        f'<item objectid="{index + 2}" transform="1 0 0 0 1 0 0 0 1 {item.position[0]:.6g} {item.position[1]:.6g} 0"/>'
        for index, item in enumerate(items)
    ]
    return "\n".join([*lines, "</build>", "</model>", ""])


def _vertices(mesh: Mesh) -> str:
    # Nine digits bring back the same number in single precision.
    rows = '<vertex x="%.9g" y="%.9g" z="%.9g"/>' * len(mesh.vertices) % tuple(mesh.vertices.ravel().tolist())
    return f"<vertices>{rows}</vertices>"


def _triangles(mesh: Mesh) -> str:
    rows = '<triangle v1="%d" v2="%d" v3="%d"/>' * len(mesh.triangles) % tuple(mesh.triangles.ravel().tolist())
    return f"<triangles>{rows}</triangles>"
