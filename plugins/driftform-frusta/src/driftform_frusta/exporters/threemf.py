"""3MF: a plate for slicers, with names, colours, a picture, and the agent itself."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from driftform.figures import files as picture_files
from driftform.interfaces import ExportJob
from driftform_frusta.colours import colour_of
from driftform_frusta.csg import MM
from driftform_frusta.exporters.base import File, PartExporter, list_facts
from driftform_frusta.picture import plate_svg
from driftform_frusta.plate import arrange, fits
from driftform_frusta.solid import make_mesh
from driftform_frusta.triangles import Mesh

if TYPE_CHECKING:
    from driftform_frusta.parts import Part


@dataclass(frozen=True, eq=False)
class _Placed:
    """A part, its mesh as printed, and the mesh's place, mm from the middle of its plate."""

    part: "Part"
    mesh: Mesh
    colour: str
    plate: int
    x: float
    y: float


class ThreeMfExporter(PartExporter):
    """The parts as they are printed, upright on a plate, with names, colours, a picture and the agent's own files.

    Parts that do not fit on one plate are spread over several files. The recommended print settings are
    metadata that slicers ignore. A part larger than the bed is reported and written all the same: beds differ.
    """

    name = "3mf"
    suffix = ".3mf"

    def make_files(self, job: ExportJob, parts: "Sequence[Part]", path: Path) -> Iterator[File]:
        """Yield the plates; facts: those of parts, the number of ``triangles``, and whether all parts of a plate ``fits_bed``."""
        from driftform_frusta.parts import KIT_FILE
        from driftform_frusta.source import write_source

        placed = self._placed(parts)
        plates = 1 + max(p.plate for p in placed)
        attachments = {"agent.scad": write_source(job, parts, self.options.segments, self.options.ballast)}
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
            sizes = [tuple(np.ptp(p.mesh.bounds, axis=0).tolist()) for p in here]
            facts = list_facts([p.part for p in here], job.agent.body) | {
                "triangles": sum(len(p.mesh.triangles) for p in here),
                "fits_bed": all(fits(size, self._bed) for size in sizes),
            }
            yield target, self._pack(title, job, here, attachments), facts

    def plate_picture(self, job: ExportJob) -> bytes:
        """Return a larger picture of the first plate than the file has, a PNG file."""
        from driftform_frusta.parts import make_parts, settle_ballast

        body = job.agent.body
        placed = self._placed(make_parts(body, settle_ballast(body, self.options)))
        return self._picture([p for p in placed if p.plate == 0], 200.0, 150.0)

    def _placed(self, parts: "Sequence[Part]") -> list[_Placed]:
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
        x, y, z = self.options.bed
        return MM * x, MM * y, MM * z

    def _pack(self, title: str, job: ExportJob, placed: Sequence[_Placed], attachments: dict[str, str]) -> bytes:
        from driftform_frusta.threemf import Item, package_bytes

        o, body, mass = self.options, job.agent.body, job.agent.mass
        width, depth, _ = self._bed
        grams = {p.part.name: 1e-6 * p.part.solid.volume * body.hull_density for p in placed}
        weights = ", ".join(f"{name} {weight:.2f} g" for name, weight in grams.items())
        description = (
            f"Hull of a passive underwater agent, evolved by driftform. Printed mass: {weights}. As simulated, with its "
            f"core, the agent weighs {1e3 * mass.mass:.2f} g and displaces {1e6 * mass.volume:.2f} cm3."
        )
        items = [Item(p.part.name, p.colour, p.mesh, (width / 2 + p.x, depth / 2 + p.y)) for p in placed]
        hints = {
            "layer_height_mm": f"{MM * o.layer_height:g}",
            "perimeters": str(o.perimeters),
            "infill_percent": f"{100 * o.infill:g}",
            "material_density_kg_per_m3": f"{body.hull_density:g}",
            "printed_mass_g": f"{sum(grams.values()):.3f}",
        }
        picture = self._picture(placed)
        return package_bytes(title, items, {"Description": description}, hints, picture, attachments)

    def _picture(self, placed: Sequence[_Placed], width: float = 160.0, height: float = 120.0) -> bytes:
        shapes = [(p.mesh.translate((p.x, p.y, 0.0)), p.colour) for p in placed]
        return picture_files.rasterise(plate_svg(shapes, self._bed[:2], width, height)) or b""
