"""driftform in notebooks and scripts: from a scenario to an evolved agent to its mesh.

``import driftform as df`` offers :func:`load_study`, :func:`evolve`, :func:`open_run` and :func:`agent`. What they
return shows itself in a notebook: a run as its overview and a table of targets, an agent as a drawing of its section,
a flight as its path. Quantities are in SI units, fitness is in percent, frames are those of :mod:`driftform.types`.
"""

import os
import warnings
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from driftform.agents.inspection import body_facts
from driftform.agents.opening import Opened, build_stored, open_agent
from driftform.errors import InputError, WorkFailedError, did_you_mean
from driftform.execution import Executor, InProcess, LocalProcesses
from driftform.figures.flight import flight_svg
from driftform.figures.section import section_svg
from driftform.reproduction.repeats import carry_out
from driftform.runs.directory import DATABASE, check_new, check_run, find_best_agent, lock_run
from driftform.runs.finalists import fly_finalists
from driftform.runs.results import write_best, write_reach
from driftform.runs.store import Record, Store
from driftform.runs.tables import evaluation_batches
from driftform.scenario import Scenario
from driftform.study import Document, Study, load_study
from driftform.tables.columns import FLIGHT_COLUMNS
from driftform.trajectory.approach import closest_approach
from driftform.types import Agent, Coefficients, End, FloatArray, MassProperties, Trajectory
from driftform.util.files import make_directory
from driftform.util.notebook import show_picture, show_table
from driftform.util.progress import count_progress

__all__ = ["Design", "Flight", "NoTargetError", "Run", "agent", "evolve", "load_study", "open_run"]


class NoTargetError(InputError, KeyError):
    """A run was asked for a target that it does not have."""


@dataclass(frozen=True, eq=False)
class Flight:
    """One flight of an agent through its scenario.

    Attributes
    ----------
    name
        of the agent.
    trajectory
        time (s), position (m), attitude and velocity, sample by sample.
    scenario
        what it flew through.
    agent
        what flew.
    fitness
        for each target, %; 100 is a hit.
    """

    name: str
    trajectory: Trajectory
    scenario: Scenario
    agent: Agent
    fitness: Mapping[str, float]

    @property
    def end(self) -> End:
        """Why the flight ended."""
        return self.trajectory.end

    @cached_property
    def closest(self) -> dict[str, float]:
        """Distance of the closest approach to each target, m."""
        distance, _ = closest_approach(self.trajectory, self.scenario.target_array())
        return dict(zip(self.scenario.target_names, distance.tolist(), strict=True))

    def columns(self) -> dict[str, FloatArray]:
        """The flight as columns, for ``pandas.DataFrame(flight.columns())``: those of ``trajectory.csv``."""
        t = self.trajectory
        parts = (t.t, *t.position.T, *t.quaternion.T, *t.velocity.T)
        return dict(zip(FLIGHT_COLUMNS, parts, strict=True))

    def __repr__(self) -> str:
        return f"<Flight of {self.name}: {self.trajectory.t[-1]:.2f} s to the {self.end}>"

    def _repr_svg_(self) -> str:
        return flight_svg(self.trajectory, self.scenario, self.name, self.agent.body)

    def _repr_html_(self) -> str:
        rows = ((t, f"{self.fitness[t]:.2f}", f"{1000 * self.closest[t]:.1f}") for t in self.fitness)
        return show_picture(self._repr_svg_(), repr(self)) + show_table(
            ("target", "fitness %", "closest mm"), rows
        )


class Design:
    """An agent: its genome, the body that the genome makes, and the scenario that it flies in."""

    def __init__(self, opened: Opened) -> None:
        self._opened = opened

    @property
    def name(self) -> str:
        """What its files are called."""
        return self._opened.name

    @property
    def genome(self) -> str:
        """The genome as text; :func:`agent` reads it."""
        return self._opened.pipeline.grammar.to_text(self._opened.stored.genome)

    @property
    def agent(self) -> Agent:
        """Body, masses and coefficients, as simulators and exporters receive them."""
        return self._opened.agent

    @property
    def scenario(self) -> Scenario:
        """What it flies in."""
        return self._opened.study.scenario

    @property
    def result(self) -> Mapping[str, Any]:
        """What its run found out: target, fitness (%), evaluation; empty for an agent of no run."""
        return self._opened.stored.result

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
        fluid = self.scenario.fluid
        return (fluid.density * self.mass.volume - self.mass.mass) * fluid.gravity

    def inspect(self) -> dict[str, Any]:
        """All that ``driftform inspect`` tells, as its JSON document names it; some of it takes flights."""
        return body_facts(self._opened)

    def under(
        self, *settings: str, scenario: str | None = None, use: Mapping[str, str | None] | None = None
    ) -> "Design":
        """Return the same genome in other surroundings, such as ``under("flow.speed=0.8")``.

        Parameters
        ----------
        settings
            ``key=value`` as ``--set`` takes them.
        scenario
            path of a study file or the name of a built-in scenario.
        use
            plugin by seam, such as ``{"simulator": "native"}``.

        Raises
        ------
        InputError
            where a setting is not sound.
        """
        # What was found out elsewhere does not hold there.
        stored = replace(self._opened.stored, environment=self._opened.study.environment(), result={})
        opened = build_stored(stored, self.name, scenario, settings, use)
        return Design(replace(opened, stored=replace(stored, environment=opened.study.environment())))

    def simulate(self) -> Flight:
        """Fly it through its scenario.

        Raises
        ------
        WorkFailedError
            where the flight fails.
        """
        flight = self._opened.fly()
        if flight.end.failed:
            raise WorkFailedError(f"{self.name}: the flight ended after {flight.t[-1]:.3g} s: {flight.end}")
        scores = self._opened.pipeline.fitness.score(flight, self.scenario)
        fitness = dict(zip(self.scenario.target_names, scores.tolist(), strict=True))
        return Flight(self.name, flight, self.scenario, self.agent, fitness)

    def export(self, format: str, path: str | os.PathLike[str] | None = None) -> list[Path]:
        """Write it as a file for printers and other programs, and return the paths of what was written.

        Parameters
        ----------
        format
            name of an exporter, such as ``"stl"`` or ``"3mf"``.
        path
            of the file; ``None`` for the agent's name in the working directory. An older file is replaced.

        Raises
        ------
        InputError
            where there is no such format, or nothing can be written there.
        """
        exporter = self._opened.study.make_exporter(format)
        file = Path(f"{self.name}{exporter.suffix}" if path is None else path)
        make_directory(file.parent, "path")
        return [Path(written.path) for written in exporter.write(self._opened.export_job(), file)]

    def __repr__(self) -> str:
        modules = self.agent.morphology.modules if self.agent.morphology else ()
        return f"<Design {self.name}: {len(modules)} modules, {self.length:.3f} m, {self.mass.mass:.4f} kg>"

    def _repr_svg_(self) -> str:
        return section_svg(self.agent, self.name, self.scenario)

    def _repr_html_(self) -> str:
        return show_picture(self._repr_svg_(), repr(self))


class Run(Mapping[str, Design]):
    """A run on disk: the best agent of each target, by the target's name.

    It tells what was stored at the time of asking; ask again while another process goes on with the run.

    Attributes
    ----------
    path
        of its directory.
    study
        what was asked for: scenario, plugins and their options, seed and budget.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with Store.open(check_run(path), read_only=True) as store:
            self.study: Study = load_study(Document(str(path / DATABASE), store.read_study()))

    def __getitem__(self, target: str) -> Design:
        names = self.study.scenario.target_names
        if target not in names:
            raise NoTargetError(f"{self.path} has no target '{target}'{did_you_mean(str(target), names)}")
        return Design(open_agent(f"{self.path}:{target}"))

    def __iter__(self) -> Iterator[str]:
        return iter(self.study.scenario.target_names)

    def __len__(self) -> int:
        return len(self.study.scenario.target_names)

    def best(self) -> dict[str, dict[str, Any]]:
        """What the best agent of each target came to: fitness (%), error (% of d_max), evaluation."""
        with Store.open(self.path / DATABASE, read_only=True) as store:
            found = {target: find_best_agent(self.study, store, target) for target in self}
        return {target: dict(stored.result) for target, stored in found.items() if stored is not None}

    def evaluations(self) -> dict[str, list[Any]]:
        """All evaluations as columns, for ``pandas.DataFrame(run.evaluations())``: those of ``export-data``."""
        found: dict[str, list[Any]] = {}
        with Store.open(self.path / DATABASE, read_only=True) as store:
            for batch in evaluation_batches(self.study, store.read_records(self.study.scenario.target_names)):
                for name, values in batch.items():
                    found.setdefault(name, []).extend(values)
        return found

    def __repr__(self) -> str:
        return f"<Run {self.path}: {len(self)} targets>"

    def _repr_html_(self) -> str:
        places, best = self.study.scenario.targets, self.best()
        rows = (
            (
                target,
                ", ".join(f"{c:g}" for c in places[target]),
                f"{row['fitness']:.3f}",
                f"{row['error_percent']:.3f}",
                str(row["evaluation"]),
            )
            for target, row in best.items()
        )
        header = ("target", "x, y, z m", "fitness %", "error % of d_max", "evaluation")
        overview = self.path / "figures" / "overview.svg"
        shown = show_picture(overview.read_text(encoding="utf-8"), repr(self)) if overview.is_file() else ""
        return shown + show_table(header, rows, str(self.path))


def evolve(
    study: Study, directory: str | os.PathLike[str], *, workers: int = 1, progress: bool = True
) -> Run:
    """Evolve agents for every target of a study, as ``driftform evolve`` does, and return the run.

    A directory that holds a run of the same study is gone on with: to run a cell again costs nothing, and what was
    interrupted continues where it stopped.

    Parameters
    ----------
    study
        from :func:`load_study`; name a seed, or each time is another run.
    directory
        where the run is written; see ``docs/dataflow.md`` for its files.
    workers
        processes; the result does not depend on it.
    progress
        tell on stderr how far it is.

    Raises
    ------
    InputError
        where the study has no targets, or the directory holds something else.
    WorkFailedError
        where not one evaluation succeeded.
    """
    path = Path(directory)
    if workers < 1:
        raise InputError(f"workers = {workers}: should be at least 1")
    if not study.scenario.targets:
        raise InputError(
            "the study has no [targets]; add at least one, such as targets.leak=[4.0, 0.0, -0.9]"
        )
    if not (path / DATABASE).is_file():
        check_new(path)
    with closing(_executor(study, workers)) as executor:
        _fly(path, study, executor, progress)
        with lock_run(path), Store.open(path / DATABASE) as store:
            fly_finalists(study, store, executor)
            results, _ = write_best(path, study, store)
            write_reach(path, study, store)
    for problem in (problem for best in results for problem in best.problems):
        warnings.warn(problem, stacklevel=2)
    return Run(path)


def open_run(directory: str | os.PathLike[str]) -> Run:
    """Open a run directory, also of a run that is still going on.

    Raises
    ------
    InputError
        where it is none.
    """
    return Run(Path(directory))


def agent(
    text: str | os.PathLike[str],
    *settings: str,
    scenario: str | None = None,
    use: Mapping[str, str | None] | None = None,
) -> Design:
    """Build an agent.

    Parameters
    ----------
    text
        path of an ``agent.json``, ``RUN:TARGET``, or the text of a genome, as the commands take it.
    settings, scenario, use
        other surroundings than its own, as for :meth:`Design.under`.

    Raises
    ------
    InputError
        where there is none.
    """
    return Design(open_agent(os.fspath(text), scenario, settings, use))


def _executor(study: Study, workers: int) -> InProcess | LocalProcesses:
    return InProcess(study.make_pipeline()) if workers == 1 else LocalProcesses(study.document, workers)


def _fly(path: Path, study: Study, executor: Executor, progress: bool) -> None:
    if not progress:
        carry_out(path, study, executor, lambda _: None)
        return
    done = 0
    with count_progress("evaluations") as tell:

        def count(_: Record) -> None:
            nonlocal done
            done += 1
            tell(done, study.evaluations)

        carry_out(path, study, executor, count)
