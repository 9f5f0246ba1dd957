"""The matrices of Fossen's model in one file, for your own programs and for MATLAB."""

from pathlib import Path
from typing import ClassVar

import numpy as np

from driftform.interfaces import Exporter, ExportJob, Table
from driftform.types import WrittenFile
from driftform_frusta.exporters.base import save
from driftform_robotics.models.exporter import WaterOptions
from driftform_robotics.models.link import describe_link, make_link
from driftform_robotics.models.text import render
from driftform_robotics.models.uuv import TO_NED


class FossenExporter(Exporter[WaterOptions]):
    """Mass, inertia, added mass, damping and buoyancy about the centre of gravity, as Fossen's equations have them (TOML).

    The axes are Fossen's: x forward, y to starboard, z down. Comments say whether added mass that lags is stable.
    """

    name = "fossen"
    suffix = ".fossen.toml"
    Options: ClassVar[type[Table]] = WaterOptions

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the file."""
        save(path, self.describe_water(job))
        return (WrittenFile(self.name, str(path), {}),)

    def describe_water(self, job: ExportJob) -> str:
        """Return the text of the file."""
        link = make_link(job, self.options.drag_speed)
        notes = describe_link(job.name, link, "y to starboard, z down")
        turned = np.outer(TO_NED, TO_NED)
        signs = {"signs": turned, "turning": turned[3:, 3:], "ahead": TO_NED[:3]}
        return render("fossen.toml", link=link, fluid=job.scenario.fluid, notes=notes, **signs)
