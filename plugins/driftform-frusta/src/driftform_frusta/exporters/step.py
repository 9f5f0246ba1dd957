"""STEP: exact solids for CAD programs, AP242."""

import re
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from driftform.errors import WorkFailedError
from driftform.interfaces import ExportJob
from driftform_frusta.brep import require_opencascade, to_brep, volume_of
from driftform_frusta.colours import channels, colour_of
from driftform_frusta.csg import MM
from driftform_frusta.exporters.base import File, PartExporter, list_facts
from driftform_frusta.hull import MM3_PER_M3
from driftform_frusta.parts import Part

_TOLERANCE = 1e-3
"""Between the exact solid and its mesh, relative, if they have details: these are cut out of true circles here."""


class StepExporter(PartExporter):
    """The hull as a STEP file in mm, with true cones and circles, a named solid for each part; needs Open CASCADE.

    The sections and volumes are those of the simulation without any facets, so ``segments`` has no effect. Open CASCADE
    comes with the extra ``step``.
    """

    name = "step"
    suffix = ".step"

    def make_files(self, job: ExportJob, parts: Sequence[Part], path: Path) -> Iterator[File]:
        """Yield the solids; facts: those of parts, and the number of ``faces``."""
        require_opencascade()
        shapes = [to_brep(part.tree) for part in parts]
        for part, shape in zip(parts, shapes, strict=True):
            exact, meshed = volume_of(shape), part.solid.volume
            if abs(exact - meshed) > _TOLERANCE * meshed:
                raise WorkFailedError(
                    f"the exact solid of the {part.name} has {exact:.3f} mm3, its mesh {meshed:.3f} mm3"
                )
        volume, body = sum(volume_of(shape) for shape in shapes), job.agent.body
        facts = list_facts(parts, body) | {
            "volume_mm3": volume,
            "mass_kg": volume / MM3_PER_M3 * body.hull_density,
            "faces": sum(_count_faces(shape) for shape in shapes),
        }
        if parts[0].name == "hull":
            facts["size_mm"] = [MM * body.max_diameter, MM * body.max_diameter, MM * body.length]
        yield path, step_text(job.name, parts, shapes), facts


def step_text(title: str, parts: Sequence[Part], shapes: Sequence[Any]) -> str:
    """Return shapes, with the names and colours of their parts, as the text of a STEP file."""
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Interface import Interface_Static
    from OCP.Message import Message
    from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_AsIs
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_DocumentTool

    # It prints messages on standard output, which is ours.
    messenger = Message.DefaultMessenger_s()
    for printer in list(messenger.Printers()):
        messenger.RemovePrinter(printer)
    document = TDocStd_Document(TCollection_ExtendedString("driftform"))
    shape_tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colour_tool = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    for index, (part, shape) in enumerate(zip(parts, shapes, strict=True)):
        label = shape_tool.AddShape(shape, False)
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(part.name))
        colour = Quantity_Color(*channels(colour_of(index)), Quantity_TOC_sRGB)
        colour_tool.SetColor(label, colour, XCAFDoc_ColorSurf)
    # The writer's own start sets these, so it comes first.
    writer = STEPCAFControl_Writer()
    Interface_Static.SetCVal_s("write.step.schema", "AP242DIS")
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "agent.step"
        if not writer.Transfer(document, STEPControl_AsIs) or writer.Write(str(path)) != IFSelect_RetDone:
            raise WorkFailedError("Open CASCADE cannot write the STEP file")
        text = path.read_text(encoding="utf-8")
    # Its header has the path and the time: the same parts must give the same bytes.
    name = re.sub(r"[^A-Za-z0-9 ._-]", "_", title)
    return re.sub(r"FILE_NAME\('[^']*','[^']*'", f"FILE_NAME('{name}','1970-01-01T00:00:00'", text, count=1)


def _count_faces(shape: Any) -> int:
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer

    explorer, count = TopExp_Explorer(shape, TopAbs_FACE), 0
    while explorer.More():
        count += 1
        explorer.Next()
    return count
