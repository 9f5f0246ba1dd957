"""What the exporters of models share: options, the model that they write, and how its folder is written."""

from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from driftform.interfaces import Exporter, ExportJob, Table, option
from driftform.types import FloatArray, WrittenFile
from driftform_robotics.models.folder import cut_hull, hull_files, model_facts, save_folder
from driftform_robotics.models.link import Link, make_link, warn_of_damping, warn_of_flow, warn_of_folding
from driftform_robotics.models.meshes import Piece
from driftform_robotics.models.xml import make_identifier

OptionsT_co = TypeVar("OptionsT_co", bound=Table, covariant=True)


class ModelOptions(Table):
    """Options of every format that describes the water."""

    drag_speed: float | None = option(
        None,
        "speed through the water at which drag by strips is converted to quadratic damping; "
        "by default the speed at which the agent rises or sinks",
        "m/s",
        ge=1e-6,
        le=100,
        strict=True,
    )
    step: float = option(0.001, "time step of the simulation", "s", ge=1e-6, le=1)


@dataclass(frozen=True, eq=False)
class Model:
    """An agent as all formats write it.

    Attributes
    ----------
    job
        the agent and the scenario that it is meant for.
    title
        the agent's name, valid in every format.
    link
        the rigid body in water, at its release.
    pieces
        the convex pieces of the hull.
    """

    job: ExportJob
    title: str
    link: Link
    pieces: list[Piece]

    def axis_point(self, x: float) -> FloatArray:
        """Return the point of the body's axis at ``x`` (m, body frame), relative to the centre of gravity, m, (3,)."""
        return np.array([x, 0.0, 0.0]) - self.job.agent.mass.cog

    def list_warnings(self) -> list[str]:
        """Return what no format can represent exactly: a folded outline, a varying flow, drag by strips."""
        scenario = self.job.scenario
        return [
            *warn_of_folding(self.job.agent.body),
            *warn_of_flow(scenario),
            *warn_of_damping(self.link),
        ]


class ModelExporter(Exporter[OptionsT_co]):
    """A format that is a folder with a model of the agent and the meshes of its hull."""

    @abstractmethod
    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return the texts of the files by their paths, starting with the file to open, and the warnings."""

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the files of the format and the meshes of the hull.

        Facts: ``mass_kg``, ``cog_mm`` and ``cob_mm`` along the axis from the core's centre, ``volume_mm3``,
        ``added_over_own_mass``, and ``warnings``, if any.

        Raises
        ------
        WorkFailedError
            if the hull is not a solid, or if the files cannot be written.
        """
        options, agent = self.options, job.agent
        speed = options.drag_speed if isinstance(options, ModelOptions) else None
        pieces = cut_hull(agent.body)
        model = Model(job, make_identifier(job.name), make_link(job, speed), pieces)
        files, warnings = self.make_files(model)
        files |= hull_files(agent.body, agent.mass.cog, pieces)
        return save_folder(self.name, path, files, model_facts(model.link, warnings))
