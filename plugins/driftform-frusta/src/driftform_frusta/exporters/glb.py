"""GLB: the binary form of glTF 2.0, for viewers, browsers and phones; metres, y up.

Specification: Khronos Group, "glTF 2.0 Specification" (ISO/IEC 12113:2022), sections 3 and 4.
"""

import json
import struct
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from driftform.types import FloatArray
from driftform_frusta.colours import colour_of, decode_srgb
from driftform_frusta.exporters.base import JoinedFile
from driftform_frusta.triangles import Mesh

FRAME = 1e-3 * np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""From the printed frame, mm with z up, to that of glTF, m with y up: a turn by -90 degrees about x."""

_FLOAT, _UNSIGNED_INT = 5126, 5125
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942


class GlbExporter(JoinedFile):
    """The hull as GLB (glTF 2.0) in metres with y up, a named node for each part at its place in the hull."""

    name = "glb"
    suffix = ".glb"
    frame: ClassVar[FloatArray | None] = FRAME

    def encode(self, title: str, meshes: Mapping[str, Mesh]) -> bytes:
        """Return the scene.

        Normals are left out: a viewer then shades each triangle flat, as the printed facets are.
        """
        views: list[dict[str, Any]] = []
        accessors: list[dict[str, Any]] = []
        binary = b""

        def accessor(data: bytes, target: int, **fields: Any) -> int:
            nonlocal binary
            views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "target": target})
            # Every number here takes four bytes, so each view begins where it must.
            binary += data
            accessors.append({"bufferView": len(views) - 1, **fields})
            return len(accessors) - 1

        primitives = []
        for index, mesh in enumerate(meshes.values()):
            positions = accessor(
                mesh.vertices.astype("<f4").tobytes(),
                _ARRAY_BUFFER,
                componentType=_FLOAT,
                count=len(mesh.vertices),
                type="VEC3",
                min=mesh.vertices.min(axis=0).tolist(),
                max=mesh.vertices.max(axis=0).tolist(),
            )
            indices = accessor(
                mesh.triangles.astype("<u4").tobytes(),
                _ELEMENT_ARRAY_BUFFER,
                componentType=_UNSIGNED_INT,
                count=mesh.triangles.size,
                type="SCALAR",
            )
            primitives.append({"attributes": {"POSITION": positions}, "indices": indices, "material": index})
        document = {
            "asset": {"version": "2.0", "generator": "driftform"},
            "scene": 0,
            "scenes": [{"name": title, "nodes": list(range(len(meshes)))}],
            "nodes": [{"name": name, "mesh": index} for index, name in enumerate(meshes)],
            "meshes": [
                {"name": name, "primitives": [primitive]} for name, primitive in zip(meshes, primitives, strict=True)
            ],
            "materials": [
                {
                    "name": name,
                    "pbrMetallicRoughness": {
                        "baseColorFactor": [*decode_srgb(colour_of(index)), 1.0],
                        "metallicFactor": 0.0,
                        "roughnessFactor": 0.8,
                    },
                }
                for index, name in enumerate(meshes)
            ],
            "accessors": accessors,
            "bufferViews": views,
            "buffers": [{"byteLength": len(binary)}],
        }
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(binary)
        head = struct.pack("<4sIIII", b"glTF", 2, length, len(text), _JSON_CHUNK)
        return head + text + struct.pack("<II", len(binary), _BINARY_CHUNK) + binary
