"""Shared by the exporters of models: options, the model, and how its folder is written."""

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from driftform.errors import WorkFailedError
from driftform.interfaces import Exporter, ExportJob, Table, option
from driftform.types import FloatArray, WrittenFile
from driftform.util import files as writing
from driftform_frusta.triangles import Mesh
from driftform_robotics.models.link import Link, describe_link, make_link
from driftform_robotics.models.meshes import Piece, convex_pieces, folds_back, obj_text, revolve_contour
from driftform_robotics.models.pipe import Bore, list_bores, make_wall
from driftform_robotics.models.text import make_identifier, render

HULL = "meshes/hull.obj"
"""File of the outer surface of the hull, about the centre of gravity."""

PIPE = "meshes/pipe.obj"
"""File of the pipe's wall, in the world frame."""


OptionsT_co = TypeVar("OptionsT_co", bound=Table, covariant=True)


class WaterOptions(Table):
    """Options of every format with quadratic damping."""

    drag_speed: float | None = option(
        None,
        "speed through the water at which drag by strips is converted to quadratic damping; "
        "by default the speed at which the agent rises or sinks",
        "m/s",
        ge=1e-6,
        le=100,
        strict=True,
    )


class ModelOptions(Table):
    """Options of every format that a simulator with water reads."""

    step: float | None = option(
        None,
        "time step of the simulation; by default the longest up to 0.002 whose error is small; for MuJoCo 0.001",
        "s",
        ge=1e-6,
        le=1,
        strict=True,
    )


@dataclass(frozen=True, eq=False)
class Model:
    """An agent as all formats write it.

    Attributes:
        job: the agent and the scenario that it is meant for.
        title: the agent's name, valid in every format.
        link: the rigid body in water, at its release.
    """

    job: ExportJob
    title: str
    link: Link
    pieces: list[Piece]

    @cached_property
    def bores(self) -> list[Bore]:
        """The bores of the pipe."""
        return list_bores(self.job.scenario.pipe)

    @cached_property
    def wall(self) -> Mesh | None:
        """The wall of the pipe, ``None`` in open water."""
        return make_wall(self.job.scenario.pipe)

    @property
    def folds_back(self) -> bool:
        """True if the outline cannot be cut into convex pieces."""
        return folds_back(self.job.agent.body.outer)

    @property
    def friction(self) -> float:
        """Coefficient of friction."""
        return self.job.scenario.calibrated_contact().friction

    @property
    def files(self) -> dict[str, Any]:
        """Paths of the meshes: of the hull, of the pipe, and of the pieces."""
        return {"hull": HULL, "pipe": PIPE, "pieces": [piece_path(i) for i in range(len(self.pieces))]}

    def axis_point(self, x: float) -> FloatArray:
        """Return the point of the body's axis at ``x`` (m, body frame), relative to the centre of gravity, m, (3,)."""
        return np.array([x, 0.0, 0.0]) - self.job.agent.mass.cog


class ModelExporter(Exporter[OptionsT_co]):
    """A format that is a folder with a model of the agent and the meshes of its hull.

    ``block`` is the template of the part that describes the water, if the format has one.
    """

    block: ClassVar[str] = ""

    @abstractmethod
    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return the texts of the files by their paths, starting with the file to open, and the warnings."""

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the files of the format and the meshes of the hull.

        Facts: ``mass_kg``, ``cog_mm`` and ``cob_mm`` along the axis from the core's centre, ``volume_mm3``,
        ``added_over_own_mass``, and ``warnings``, if any.

        Raises WorkFailedError if the hull is not a solid, or if the files cannot be written.
        """
        model = self._make_model(job)
        texts, warnings = self.make_files(model)
        texts[HULL] = obj_text(revolve_contour(job.agent.body.outer).translate(-job.agent.mass.cog))
        texts |= {piece_path(i): obj_text(piece.mesh) for i, piece in enumerate(model.pieces)}
        try:
            with writing.write_folder(path) as part:
                for name, text in texts.items():
                    (part / name).parent.mkdir(parents=True, exist_ok=True)
                    (part / name).write_text(text, encoding="utf-8")
                    if text.startswith("#!"):
                        (part / name).chmod(0o755)
        except OSError as error:
            raise WorkFailedError(f"cannot write {path}: {error.strerror or error}") from error
        first, link = next(iter(texts)), model.link
        facts: dict[str, Any] = {
            "mass_kg": link.mass,
            "cog_mm": -1e3 * float(link.core[0]),
            "cob_mm": 1e3 * float(link.buoyancy[0] - link.core[0]),
            "volume_mm3": 1e9 * link.volume,
            "added_over_own_mass": link.added_mass_ratio,
        }
        facts |= {"warnings": " ".join(warnings)} if warnings else {}
        return tuple(WrittenFile(self.name, str(path / name), facts if name == first else {}) for name in texts)

    def describe_water(self, job: ExportJob) -> str:
        """Return the elements of the water, as the files have them, with a comment on their frame and stability."""
        if not self.block:
            return super().describe_water(job)
        model = self._make_model(job)
        return render(self.block, **self.list_values(model)).partition("\n")[2]

    def list_values(self, model: Model) -> dict[str, Any]:
        """Return the values of the format's templates: the model as its files have it, and notes about its water."""
        return {"model": model, "notes": describe_link(model.job.name, model.link)}

    def _make_model(self, job: ExportJob) -> Model:
        speed = self.options.drag_speed if isinstance(self.options, WaterOptions) else None
        contour = job.agent.body.outer
        if len(contour) < 3 or contour[0, 1] or contour[-1, 1] or not (contour[1:-1, 1] > 0).any():
            raise WorkFailedError("the hull is not a solid: its outer contour does not start and end on the axis")
        return Model(job, make_identifier(job.name), make_link(job, speed), convex_pieces(contour))


def piece_path(index: int) -> str:
    """Return the path of one convex piece, whose mesh is about its own centroid."""
    return f"meshes/piece_{index:02d}.obj"
