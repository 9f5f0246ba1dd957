"""A design: an agent that a person opened, with its study, and all that can be done with it."""

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from driftform.agent import hull_mass
from driftform.design.flight import DisturbedFlights, Flight
from driftform.design.inspection import compare_added_mass, inspect_agent, list_departures, list_doubts
from driftform.design.live import LiveFlight
from driftform.errors import InputError, WorkFailedError
from driftform.figures.section import section_svg
from driftform.interfaces import ExportJob, Renderer
from driftform.motion.path.interpolation import resample
from driftform.motion.path.targets import find_offsets, name_outlet
from driftform.motion.path.thinning import check_rate
from driftform.pipeline import Pipeline, require_success
from driftform.plugins.faults import describe_fault
from driftform.plugins.genome_text import write_genome
from driftform.plugins.registry import registry
from driftform.plugins.seams import require_file, require_files
from driftform.runs.agent_file import StoredAgent
from driftform.study import Document, Study, load_study
from driftform.study.sources import say_in_python
from driftform.types import Agent, ByContent, Coefficients, FloatArray, MassProperties, Trajectory, WrittenFile
from driftform.util.files import is_directory, make_directory, safe_stem
from driftform.util.notebook import show_picture
from driftform.water import Scenario
from driftform.water.disturbances import draw_conditions, know_gusts

Progress = Callable[[int, int], None]
"""Takes the number of steps that are done, and of all."""


def ignore(_: object, __: object = None) -> None:
    """Ignore a step of progress."""


@dataclass(frozen=True, eq=False, repr=False)
class Design(ByContent):
    """An agent: its genome, the body that the genome makes, and the scenario that it flies in.

    Attributes:
        name: what its files are called; safe for the name of a file.
        stored: genome, environment and result, as an ``agent.json`` holds them.
        study: the scenario, and the plugins with their options.
        pipeline: the steps from genome to fitness.
        agent: body, masses and coefficients, as simulators and exporters receive them.
        opened_as: what opens it on a command line, such as ``run:TP3``, with the settings; ``AGENT`` if that is
            unknown.
    """

    name: str
    stored: StoredAgent
    study: Study
    pipeline: Pipeline
    agent: Agent
    opened_as: str = "AGENT"

    @classmethod
    def build(
        cls,
        stored: StoredAgent,
        label: str,
        scenario: str | None = None,
        settings: Sequence[str] = (),
        use: Mapping[str, str | None] | None = None,
    ) -> Self:
        """Build a stored agent in its environment, or in another; ``label`` names it in errors.

        Raises:
            InputError: if the environment is not sound, or the genome does not belong to it.
            WorkFailedError: if no body can be built.
        """
        source: str | Document = Document(label, stored.environment)
        if scenario is not None:
            # The agent stays the same; only its surroundings change.
            other = load_study(scenario).document
            made = {seam: stored.environment[seam] for seam in ("grammar", "builder") if seam in stored.environment}
            source = Document(scenario, {**other, **made})
        study = load_study(source, settings, use=use, run={"seed": 0})
        pipeline = study.make_pipeline()
        if stored.genome.grammar != pipeline.grammar.name:
            raise InputError(
                f"{label}: is a genome of grammar '{stored.genome.grammar}', its study uses '{pipeline.grammar.name}'"
            )
        try:
            agent = pipeline.make_agent(stored.genome)
        except ValueError as error:
            raise InputError(f"{label}: {error}") from None
        except (ArithmeticError, RuntimeError) as error:
            # Options that are sound one by one can still ask together for what cannot be computed.
            raise WorkFailedError(f"{label}: cannot be built: {describe_fault(error)}") from None
        return cls(safe_stem(stored.name), stored, study, pipeline, agent)

    @property
    def genome(self) -> str:
        """The genome as text; :func:`driftform.open_agent` reads it."""
        return write_genome(self.pipeline.grammar, self.stored.genome)

    @property
    def scenario(self) -> Scenario:
        """What it flies in."""
        return self.study.scenario

    @property
    def result(self) -> Mapping[str, Any]:
        """What its run found out: target, fitness (%), evaluation; empty for an agent of no run."""
        return self.stored.result

    @property
    def length(self) -> float:
        """Overall, along the axis, m."""
        return self.agent.body.length

    @property
    def max_diameter(self) -> float:
        """Largest outer diameter, m."""
        return self.agent.body.max_diameter

    @property
    def mass(self) -> MassProperties:
        """Mass, volume, centres of gravity and buoyancy, inertia."""
        return self.agent.mass

    @property
    def coefficients(self) -> Coefficients:
        """Added mass, damping and drag."""
        return self.agent.coefficients

    @property
    def net_buoyancy(self) -> float:
        """Buoyancy of the submerged body less its weight, N, upward positive."""
        return self.mass.net_buoyancy(self.scenario.fluid)

    def export_job(self) -> ExportJob:
        """Return the agent as exporters and recorders receive it."""
        return ExportJob(self.name, self.agent, self.scenario, self.stored.document(), self.opened_as)

    def list_limits(self) -> list[str]:
        """Return in what agent and flow are outside of the ranges of the formulas that fly it, one line each."""
        return list_doubts(self.agent, self.scenario)

    def list_departures(self) -> list[str]:
        """Return in what water, pipe, wall and weight depart from those that a run evolved it for, one line each."""
        if not self.result or self.study.environment() == self.stored.environment:
            return []
        design = load_study(Document(self.name, self.stored.environment), run={"seed": 0}).make_pipeline()
        return list_departures(self.agent, self.pipeline, design.make_agent(self.stored.genome), design)

    def inspect(self) -> dict[str, Any]:
        """Return what ``driftform inspect --json`` prints; some of it takes flights."""
        found = inspect_agent(self.pipeline, self.agent, self.name, self.result.get("target"))
        return found | {"warnings": [*found["warnings"], *self.list_departures()]}

    def compare_added_mass(self) -> dict[str, Any]:
        """Return the added mass, (6, 6), about the centre of buoyancy by each hydrodynamics model that needs no options."""
        return compare_added_mass(self.pipeline, self.agent, self.name)

    @say_in_python
    def under(
        self, *settings: str, scenario: str | None = None, use: Mapping[str, str | None] | None = None
    ) -> "Design":
        """Return the same genome in other surroundings, such as ``under("flow.speed=0.8")``.

        Args:
            settings: ``key=value`` as ``--set`` takes them.
            scenario: path of a study file or the name of a built-in scenario.
            use: plugin by seam, such as ``{"simulator": "native"}``.

        Raises InputError if a setting is not sound.
        """
        # What was found out elsewhere does not hold there.
        stored = replace(self.stored, environment=self.study.environment(), result={})
        design = Design.build(stored, self.name, scenario, settings, use)
        stored = replace(stored, environment=design.study.environment())
        return replace(design, name=self.name, stored=stored, opened_as=self.opened_as)

    def fly(self) -> LiveFlight:
        """Release it, and return its flight, which other programs take on step by step: ``fly().step(0.05, current=(1, 0, 0))``.

        Raises:
            InputError: if the water has gusts, which outlast a step.
            WorkFailedError: if it does not fit into the pipe.
        """
        return LiveFlight(self.name, self.agent, self.scenario, self.pipeline.simulator)

    def trace(self) -> Trajectory:
        """Return the agent's trajectory through its scenario; it may have ended by a failure.

        Raises WorkFailedError if the simulator cannot fly it.
        """
        [trajectory] = self.pipeline.fly_named([self.agent], self.name)
        return trajectory

    def simulate(self) -> Flight:
        """Fly it through its scenario. Raises WorkFailedError if the flight fails."""
        [found] = self.pipeline.simulate([self.agent], self.name)
        fitness = dict(zip(self.scenario.target_names, found.fitness.tolist(), strict=True))
        return Flight(self.name, found.trajectory, self.scenario, self.agent, fitness)

    def disturb(self, flights: int, seed: int = 0, progress: Progress = ignore) -> DisturbedFlights:
        """Fly it under disturbed conditions, drawn from ``seed``, and return how far it misses each target and where it leaves.

        ``[robustness]`` of its scenario says what varies. If the gusts are in doubt, each flight is flown once more in the same
        gusts, but as ``[gusts]`` describes them.
        """
        conditions = draw_conditions(self.scenario.robustness, flights, (seed, flights), self.scenario.calibration)
        known = know_gusts(conditions, self.scenario)
        offsets: list[FloatArray] = []
        outlets: list[str | None] = []
        failures: list[str | None] = []
        for condition in (*conditions, *known):
            [evaluation] = self.pipeline.evaluate([self.stored.genome], conditions=[condition])
            offsets.append(find_offsets(evaluation, self.scenario))
            failures.append(evaluation.failure)
            flight = evaluation.trajectory if evaluation.failure is None else None
            outlets.append(None if flight is None else name_outlet(flight, self.scenario))
            progress(len(offsets), flights + len(known))
        vectors = np.array(offsets).reshape(-1, len(self.scenario.targets), 3)
        beside = vectors[flights:] if known else None
        return DisturbedFlights(conditions, vectors[:flights], beside, outlets[:flights], failures[:flights])

    def export(self, format: str, path: str | os.PathLike[str] | None = None) -> list[Path]:
        """Write it as a file for printers and other programs, and return the paths of what was written.

        Warns if the agent was simulated as a kit, and the file holds its sealed hull; ``under("exporter.stl.kit=true")``
        writes the kit.

        Args:
            format: name of an exporter, such as ``"stl"`` or ``"3mf"``.
            path: of the file; ``None`` for the agent's name in the working directory. An older file is replaced.

        Raises InputError if there is no such format, or nothing can be written there.
        """
        files = self.export_files(format, path)
        if note := self.describe_missing_kit(files):
            advice = f"export design.under('exporter.{format}.kit=true') instead"
            warnings.warn(f"{note}; {advice}", stacklevel=2)
        return [Path(file.path) for file in files]

    def describe_missing_kit(self, files: Sequence[WrittenFile]) -> str:
        """Return what the parts of its kit weigh, if it was simulated as one and ``files`` hold its sealed hull; else ``""``."""

        def lacks_kit(file: WrittenFile) -> bool:
            options = registry().find("exporter", file.format).Options.model_fields
            return "mass_kg" in file.facts and "kit" not in file.facts and "kit" in options

        body = self.agent.body
        if not body.fittings.material.volume or not any(map(lacks_kit, files)):
            return ""
        return f"{self.name} was simulated as a kit, whose parts weigh {1000 * hull_mass(body):.2f} g"

    def export_files(self, format: str, path: str | os.PathLike[str] | None = None) -> tuple[WrittenFile, ...]:
        """Write it as :meth:`export` does, and return the files with their facts."""
        exporter = self.study.make_exporter(format)
        file = Path(f"{self.name}{exporter.suffix}" if path is None else path)
        make_directory(file.parent, "path")
        return require_files(exporter.write(self.export_job(), file), exporter)

    def describe_water(self, format: str) -> str:
        """Return the part of a format, such as ``"sdf"``, that describes the forces of water, to paste into another model.

        Raises:
            InputError: if there is no such format.
            WorkFailedError: if it has no such part.
        """
        return self.study.make_exporter(format).describe_water(self.export_job())

    def record(
        self, format: str = "csv", path: str | os.PathLike[str] | None = None, *, rate_hz: float = 100.0
    ) -> list[Path]:
        """Fly it, write the samples for other programs, such as Foxglove or pandas, and return the paths.

        Args:
            format: name of a recorder, such as ``"csv"`` or ``"mcap"``.
            path: of the file; ``None`` for the agent's name in the working directory. An older file is replaced.
            rate_hz: samples per second of flight, 1/s, from 0 to 10 000; 0 for the samples of the simulator.

        Raises:
            InputError: if there is no such format, or the rate is out of range.
            WorkFailedError: if it cannot be written, or the flight fails: the files then hold the flight until that
                moment.
        """
        check_rate(rate_hz)
        trajectory = self.trace()
        written = self.record_files(format, path, rate_hz=rate_hz, trajectory=trajectory)
        require_success(trajectory, self.name)
        return [Path(file.path) for file in written]

    def record_files(
        self, format: str, path: str | os.PathLike[str] | None, *, rate_hz: float, trajectory: Trajectory
    ) -> tuple[WrittenFile, ...]:
        """Write the samples of a trajectory as :meth:`record` does, and return the files with their facts."""
        recorder = self.study.make_recorder(format)
        file = Path(f"{self.name}{recorder.suffix}" if path is None else path)
        make_directory(file.parent, "path")
        samples = resample(trajectory, rate_hz) if rate_hz else trajectory
        return require_files(recorder.write(self.export_job(), samples, file), recorder)

    def check_picture(self, path: Path, renderer: str = "exudyn", *, film: bool) -> None:
        """Refuse a film, or else a still, that cannot be made, before anything is flown for it.

        Raises InputError or WorkFailedError if there is no such renderer, or it cannot make such a picture.
        """
        camera: Renderer[Any] = self.study.make_renderer(renderer)
        (camera.check if film else camera.check_still)(path)
        if is_directory(path):
            raise InputError(f"{path}: is a directory")

    def film(
        self,
        path: str | os.PathLike[str],
        *,
        renderer: str = "exudyn",
        flight: Flight | None = None,
        progress: Progress = ignore,
    ) -> Path:
        """Make a film of a flight, and return its path.

        Args:
            path: of the file; its suffix, such as ``.mp4``, decides the format. An older file is replaced.
            renderer: name of a renderer.
            flight: the flight; ``None`` to fly it now.
            progress: called with the number of frames that are done, and of all.

        Raises InputError or WorkFailedError as :meth:`check_picture`, or if the flight fails.
        """
        return self._take(Path(path), renderer, flight, "film", lambda _: progress)

    def still(
        self,
        path: str | os.PathLike[str],
        *,
        at: float | None = None,
        renderer: str = "exudyn",
        flight: Flight | None = None,
    ) -> Path:
        """Make a picture of a moment of a flight, and return its path.

        Args:
            path: of the file; its suffix, such as ``.png``, decides the format. An older file is replaced.
            at: the moment, s from the release; ``None`` for the closest approach to any target.
            renderer: name of a renderer.
            flight: the flight; ``None`` to fly it now.

        Raises InputError or WorkFailedError as :meth:`check_picture`, if the flight fails, or if it does not last until
        ``at``.
        """

        def choose_moment(flown: Flight) -> float:
            check_moment(flown, at)
            return flown.closest_time if at is None else at

        return self._take(Path(path), renderer, flight, "still", choose_moment)

    def _take(
        self, file: Path, renderer: str, flight: Flight | None, what: str, how: Callable[[Flight], object]
    ) -> Path:
        """Make a film or a still by the method ``what`` of a renderer; ``how`` gives its last argument."""
        self.check_picture(file, renderer, film=what == "film")
        flight, camera = flight or self.simulate(), self.study.make_renderer(renderer)
        last = how(flight)
        make_directory(file.parent, "path")
        require_file(getattr(camera, what)(self.agent, flight.trajectory, self.scenario, file, last), camera, what)
        return file

    def __repr__(self) -> str:
        modules = self.agent.morphology.modules if self.agent.morphology else ()
        return f"<Design {self.name}: {len(modules)} modules, {self.length:.3f} m, {self.mass.mass:.4f} kg>"

    def _repr_svg_(self) -> str:
        return section_svg(self.agent, self.name, self.scenario)

    def _repr_html_(self) -> str:
        return show_picture(self._repr_svg_(), repr(self))


def check_moment(flight: Flight, at: float | None) -> None:
    """Refuse a moment outside a flight. Raises InputError with how long the flight lasts."""
    if at is not None and not 0 <= at <= flight.duration:
        raise InputError(f"--still-at {at:g}: the flight goes from 0 to {flight.duration:.3f} s")
