"""The seams: what a plugin implements. Each docstring is the tutorial of its seam.

Every class has a ``name``, under which a study file selects it (``[simulator] use = "exudyn"``), and an
``Options`` model, which checks the rest of that table. Instances are made with their options alone and hold no
other state, so that they can be rebuilt in any worker process; a strategy is the one that remembers.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Generic, Literal, TypeVar

import numpy as np

from driftform.errors import InputError
from driftform.options import Table, option
from driftform.scenario import Fluid, Scenario, Vector
from driftform.types import (
    Agent,
    Body,
    Candidate,
    Coefficients,
    Evaluation,
    Finding,
    FloatArray,
    Genome,
    Morphology,
    Trajectory,
    WrittenFile,
)

OptionsT_co = TypeVar("OptionsT_co", bound=Table, covariant=True)


class Plugin(ABC, Generic[OptionsT_co]):
    """What all seams share: a ``name``, a model of options, and the ``options`` of this instance."""

    name: ClassVar[str]
    Options: ClassVar[type[Table]] = Table
    """The model; :class:`Table` itself for none."""

    def __init__(self, options: OptionsT_co) -> None:
        self.options = options


class Grammar(Plugin[OptionsT_co]):
    """Genome -> morphology, and the operators of variation.

    A genome is a flat tuple of symbols. A grammar is free to give it structure, and is the only one to know it.
    Every genome that :meth:`random`, :meth:`flip` and :meth:`crossover` make must be one that :meth:`express`
    takes, and ``parse(to_text(g)) == g``.
    """

    @abstractmethod
    def random(self, rng: np.random.Generator) -> Genome:
        """Return a genome drawn uniformly from all there are."""

    @abstractmethod
    def flip(self, genome: Genome, index: int, rng: np.random.Generator) -> Genome:
        """Return the genome with the symbol at ``index`` changed to another that may stand there."""

    @abstractmethod
    def crossover(self, a: Genome, b: Genome, rng: np.random.Generator) -> tuple[Genome, Genome]:
        """Return two offspring of two parents."""

    @abstractmethod
    def express(self, genome: Genome) -> Morphology:
        """Return the phenotype's modules.

        Raises
        ------
        ValueError
            where the genome is not one of this grammar; the message names the symbol and its position.
        """

    @abstractmethod
    def to_text(self, genome: Genome) -> str:
        """Return the genome in one line that a person can read."""

    @abstractmethod
    def parse(self, text: str) -> Genome:
        """Read what :meth:`to_text` wrote.

        Raises
        ------
        InputError
            where the text is not a genome; the message names the symbol and its position.
        """

    def mutate(self, genome: Genome, rng: np.random.Generator, rate: float) -> Genome:
        """Return the genome with each symbol flipped with probability ``rate``."""
        for index in np.flatnonzero(rng.random(len(genome.symbols)) < rate):
            genome = self.flip(genome, int(index), rng)
        return genome


class PhenotypeBuilder(Plugin[OptionsT_co]):
    """Morphology -> body: gives the modules a wall, ends, and the core its place."""

    @abstractmethod
    def build(self, morphology: Morphology) -> Body:
        """Return the meridian section of the morphology.

        Any morphology gives a valid body: contours start and end on the axis, do not cross themselves, and the
        cavity lies inside the outer contour.
        """


class HydrodynamicsOptions(Table):
    """What every model of hydrodynamics offers; its own options inherit from these."""

    drag: Literal["none", "strips"] = option(
        "none", "none, as in the paper, or strips across the axis with friction and blunt ends along it"
    )


HydrodynamicsOptionsT_co = TypeVar("HydrodynamicsOptionsT_co", bound=HydrodynamicsOptions, covariant=True)


class Hydrodynamics(Plugin[HydrodynamicsOptionsT_co]):
    """Body -> hydrodynamic coefficients."""

    Options: ClassVar[type[Table]] = HydrodynamicsOptions

    @abstractmethod
    def coefficients(self, body: Body, fluid: Fluid) -> Coefficients:
        """Return added mass and damping; the added mass is symmetric and positive semi-definite.

        Drag by strips is not part of a model: the pipeline adds it where ``options.drag`` asks for it.
        """


class Simulator(Plugin[OptionsT_co]):
    """Agent in a scenario -> trajectory.

    Implement :meth:`simulate`; override :meth:`simulate_batch` where many flights at once are faster. A flight
    that goes wrong is no exception: its trajectory holds what is finite of it, and says so by its ``end``. One that
    a simulator cannot compute to the accuracy it promises ends as "not converged", and is never passed off as a
    result.
    """

    @abstractmethod
    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        """Return the flight of one agent from its release to the outlet, or to the horizon."""

    def simulate_batch(self, agents: Sequence[Agent], scenarios: Sequence[Scenario]) -> list[Trajectory]:
        """Return the flights of many agents, each in its own scenario; each is the same as if it flew alone."""
        return [self.simulate(agent, scenario) for agent, scenario in zip(agents, scenarios, strict=True)]


class Fitness(Plugin[OptionsT_co]):
    """Trajectory -> one fitness for each target of the scenario, in percent: 100 is best, 0 is worst."""

    @abstractmethod
    def score(self, trajectory: Trajectory, scenario: Scenario) -> FloatArray:
        """Return the fitness for each target, in the scenario's order, (targets,)."""


@dataclass(frozen=True, eq=False)
class SearchSpace:
    """What a strategy searches: genomes of ``grammar``, scored for ``targets``, with randomness from ``rng``.

    ``scenario`` is what the flights go through, for a strategy that wants to know; open water where nothing is told.
    """

    grammar: Grammar[Any]
    targets: tuple[str, ...]
    rng: np.random.Generator
    scenario: Scenario = field(default_factory=Scenario)


class Strategy(Plugin[OptionsT_co]):
    """Which genomes to evaluate next.

    :meth:`ask` and :meth:`tell` alternate. A run that is resumed replays them from the stored evaluations, so a
    strategy draws all its randomness from ``space.rng``, and neither time nor the number of workers may matter.
    """

    evaluations_per_target: ClassVar[int] = 50
    """The budget of a run that names none."""

    def __init__(self, options: OptionsT_co, space: SearchSpace) -> None:
        super().__init__(options)
        self.space = space

    @abstractmethod
    def ask(self, limit: int) -> list[Candidate]:
        """Return the next candidates, at least one and at most ``limit`` (the flights left in the budget).

        The limit cuts what would be asked for without it, and decides nothing else: a run that is given a larger
        budget later begins with the same candidates.
        """

    @abstractmethod
    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Take the outcomes of the candidates last asked for, in their order.

        ``first`` is the index in the run of the first of them: what ``Candidate.parents`` refers to.
        """


@dataclass(frozen=True, eq=False)
class ExportJob:
    """An agent with all that is known of it: what an exporter receives.

    Attributes
    ----------
    name
        what people call it; safe for the name of a file.
    agent
        the agent, built.
    scenario
        the surroundings that it is meant for.
    document
        what its ``agent.json`` holds, to travel with its files; empty where no grammar made the agent.
    """

    name: str
    agent: Agent
    scenario: Scenario
    document: Mapping[str, Any] = field(default_factory=dict)


class Exporter(Plugin[OptionsT_co]):
    """Agent -> files. ``name`` is what ``--format`` says; ``suffix`` ends the name of the file.

    A format that is a folder of files has a suffix without a dot, such as ``-uuv``, and ``path`` is then that
    folder. Where a file cannot hold everything, such as the parts of a kit in a format for one solid, there may be
    several: their names begin with that of ``path`` without its suffix.
    """

    suffix: ClassVar[str]

    @abstractmethod
    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the file at ``path``, or several, and tell what each holds.

        Raises
        ------
        WorkFailedError
            where the agent cannot be exported this way; the message gives the reason.
        """


class Renderer(Plugin[OptionsT_co]):
    """Agent and its flight -> a film. ``suffixes`` are the ends that a film's file name may have, in small letters.

    The suffix decides the format. A film appears whole or not at all, and the same flight gives the same frames.
    A renderer that can make a still too, one picture of a flight, says so by its ``stills``, the ends of their names.
    """

    suffixes: ClassVar[tuple[str, ...]]
    stills: ClassVar[tuple[str, ...]] = ()

    def check(self, path: Path) -> None:
        """Refuse a film that cannot be made, before anything is flown for it.

        Extend it where films need what may not be installed.

        Raises
        ------
        InputError
            where the suffix is none of ``suffixes``.
        WorkFailedError
            where something is missing; the message says how to get it.
        """
        if path.suffix.lower() not in self.suffixes:
            raise InputError(f"{path}: a film by '{self.name}' ends in {' or '.join(self.suffixes)}")

    @abstractmethod
    def film(
        self,
        agent: Agent,
        trajectory: Trajectory,
        scenario: Scenario,
        path: Path,
        progress: Callable[[int, int], None],
    ) -> WrittenFile:
        """Make the film of a flight from its first sample to its last, and tell what it holds.

        ``progress`` is called with the number of frames that are done, and that of all.

        Raises
        ------
        InputError, WorkFailedError
            as :meth:`check`; and where the film cannot be made or written.
        """

    def check_still(self, path: Path) -> None:
        """Refuse a still that cannot be made, before anything is flown for it.

        Raises
        ------
        InputError
            where the suffix is none of ``stills``.
        WorkFailedError
            where something is missing; the message says how to get it.
        """
        if not self.stills:
            raise InputError(f"{path}: '{self.name}' makes films, and no stills")
        if path.suffix.lower() not in self.stills:
            raise InputError(f"{path}: a still by '{self.name}' ends in {' or '.join(self.stills)}")

    def still(
        self, agent: Agent, trajectory: Trajectory, scenario: Scenario, path: Path, at: float
    ) -> WrittenFile:
        """Make a picture of the agent ``at`` a time of its flight, s from its beginning, and tell what it holds.

        Where there are ``stills``, override it. A still appears whole or not at all.

        Raises
        ------
        InputError, WorkFailedError
            as :meth:`check_still`; and where the still cannot be made or written.
        """
        self.check_still(path)
        raise NotImplementedError(f"{type(self).__name__} has stills, and does not say how one is made")


class Recorder(Plugin[OptionsT_co]):
    """Agent and its flight -> samples for other programs. ``name`` is what ``--format`` says.

    ``suffix`` ends the name of the file; as with an exporter, one without a dot is that of a folder of files. The
    same flight gives the same content.
    """

    suffix: ClassVar[str]

    @abstractmethod
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        """Write the samples of a flight through the job's scenario, and tell what each file holds.

        A flight may have a single sample, and may have ended by a failure: what there is of it is written. Files
        appear whole or not at all.

        Raises
        ------
        WorkFailedError
            where it cannot be written this way; the message gives the reason.
        """


@dataclass(frozen=True)
class Printer:
    """What a part is to be printed with.

    Attributes
    ----------
    nozzle
        diameter of the nozzle, m: the narrowest line that it lays.
    bed
        largest part, m: width, depth and height.
    """

    nozzle: float = 0.0004
    bed: Vector = (0.25, 0.21, 0.21)


@dataclass(frozen=True, eq=False)
class PrintJob:
    """Files that are to be printed: what a checker receives.

    Attributes
    ----------
    files
        the files, each with one part or several; together they are one agent.
    printer
        what they are to be printed with.
    export
        the agent that they are to be of, ``None`` where nobody knows.
    volume
        material that the closed forms of the agent say they hold, m3, ``None`` where none does.
    source
        OpenSCAD source of the same solid, ``None`` where there is none.
    """

    files: tuple[Path, ...]
    printer: Printer = Printer()
    export: ExportJob | None = None
    volume: float | None = None
    source: Path | None = None


class Checker(Plugin[OptionsT_co]):
    """Printable files -> findings: whether what comes off the printer will be what was simulated.

    ``program`` names the program on PATH that does the work, ``""`` where none is needed.
    """

    program: ClassVar[str] = ""

    @abstractmethod
    def check(self, job: PrintJob) -> Iterable[Finding]:
        """Look at the files, and tell what was found, one line for each thing that was looked at.

        What is wrong with a part is a finding, and so is that something could not be looked at, such as a program
        that is not installed. Each fault is told once: what cannot be judged because of it is ``skipped``.

        Raises
        ------
        InputError
            where a file cannot be read at all.
        """


SEAMS: dict[str, type[Plugin[Any]]] = {
    "grammar": Grammar,
    "builder": PhenotypeBuilder,
    "hydrodynamics": Hydrodynamics,
    "simulator": Simulator,
    "fitness": Fitness,
    "strategy": Strategy,
    "exporter": Exporter,
    "recorder": Recorder,
    "renderer": Renderer,
    "checker": Checker,
}
"""The seams by the name that hooks (``driftform_<seam>``) and tables of a study file use."""
