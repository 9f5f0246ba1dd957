"""The interfaces that plugins implement, one for each seam. Each docstring is the tutorial of its seam.

Every class has a ``name``, by which a study file selects it (``[simulator] use = "exudyn"``), and an ``Options``
model, which validates the other keys of that table. An instance is created from its options alone and holds no other
state, so that any worker process can recreate it. Only a strategy keeps state.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, Generic, Literal, TypeVar

import numpy as np

from driftform.errors import InputError, WorkFailedError, did_you_mean
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
    Verdict,
    WrittenFile,
    freeze,
)
from driftform.util.options import Table, option
from driftform.water import Fluid, Scenario
from driftform.water.pipe import Vector

__all__ = [
    "AccuracyOptions", "Checker", "ExportJob", "Exporter", "Fitness", "Fitting", "Flown", "GenerationStrategy", "Grammar",
    "Hydrodynamics",
    "HydrodynamicsOptions", "Measure", "PhenotypeBuilder", "PrintJob", "Printer", "Recorder",
    "Renderer", "ReportJob", "Result", "SearchSpace", "Simulator", "Strategy", "Table", "option",
]  # fmt: skip

T = TypeVar("T")

OptionsT_co = TypeVar("OptionsT_co", bound=Table, covariant=True)

Begin = Callable[..., Callable[[], Any]]
"""Begins a call of a function with arguments, and returns what waits for its result."""


class Plugin(ABC, Generic[OptionsT_co]):
    """Base class of all plugins: a ``name``, a model of options, and the ``options`` of this instance."""

    name: ClassVar[str]
    Options: ClassVar[type[Table]] = Table
    """The model of the options; :class:`Table` itself if there are no options."""

    def __init__(self, options: OptionsT_co) -> None:
        self.options = options


class Grammar(Plugin[OptionsT_co]):
    """Genome -> morphology, and the operators that create and vary genomes.

    A genome is a flat tuple of symbols. Only the grammar knows its structure. :meth:`express` must accept every genome
    that :meth:`random`, :meth:`flip` and :meth:`crossover` return, and ``parse(to_text(g)) == g`` must hold. A grammar of
    genomes of one length needs :meth:`list_genes` and :meth:`express` alone: the other methods follow from the genes.
    """

    def random(self, rng: np.random.Generator) -> Genome:
        """Return a genome drawn uniformly from all genomes of this grammar."""
        return self.make_genome(rng.random(len(self.list_genes())))

    def flip(self, genome: Genome, index: int, rng: np.random.Generator) -> Genome:
        """Return the genome with the symbol at ``index`` replaced by another symbol that is valid there."""
        symbols = list(genome.symbols)
        others = [text for text in self.list_genes()[index] if isinstance(text, str) and text != symbols[index]]
        symbols[index] = others[rng.integers(len(others))] if others else self.random(rng).symbols[index]
        return Genome(self.name, tuple(symbols))

    def crossover(self, a: Genome, b: Genome, rng: np.random.Generator) -> tuple[Genome, Genome]:
        """Return two offspring of the parents ``a`` and ``b``: by default each symbol is that of either."""
        swapped = rng.random(len(a.symbols)) < 0.5
        pairs = zip(a.symbols, b.symbols, strict=True)
        one, other = zip(
            *((y, x) if swap else (x, y) for swap, (x, y) in zip(swapped, pairs, strict=True)), strict=True
        )
        return Genome(self.name, one), Genome(self.name, other)

    @abstractmethod
    def express(self, genome: Genome) -> Morphology:
        """Return the modules that the genome describes.

        Raises ValueError if the genome does not belong to this grammar; the message names the symbol and its position.
        """

    def to_text(self, genome: Genome) -> str:
        """Return the genome as one line of readable text: by default its symbols with commas between them."""
        return ",".join(genome.symbols)

    def parse(self, text: str) -> Genome:
        """Return the genome that :meth:`to_text` wrote.

        Raises InputError if the text is not a genome of this grammar; the message names the symbol and its position.
        """
        try:
            values = self.read_symbols(Genome(self.name, tuple(map(str.strip, text.split(",")))))
        except ValueError as error:
            raise InputError(str(error)) from None
        return Genome(self.name, tuple(one if isinstance(one, str) else f"{one:.6g}" for one in values))

    def read_symbols(self, genome: Genome) -> list[Any]:
        """Return the value of each symbol, a number or a text, for :meth:`express`.

        Raises ValueError if the genome is one of another grammar, or a symbol is not one of its gene.
        """
        genes, values = self.list_genes(), list[Any]()
        if genome.grammar != self.name or len(genome.symbols) != len(genes):
            found = f"{len(genome.symbols)} of grammar {genome.grammar!r}"
            raise ValueError(f"the number of symbols is {found}, expected {len(genes)} of {self.name!r}")
        for place, (symbol, gene) in enumerate(zip(genome.symbols, genes, strict=True), start=1):
            if isinstance(gene[0], str):
                if symbol not in gene:
                    raise ValueError(f"symbol {place} is {symbol!r}{did_you_mean(symbol, map(str, gene))}")
                values.append(symbol)
                continue
            try:
                values.append(float(symbol))
            except ValueError:
                values.append(np.nan)
            # Bounds are rounded as symbols are.
            if not float(f"{gene[0]:.6g}") <= values[-1] <= float(f"{gene[1]:.6g}"):
                raise ValueError(f"symbol {place} is {symbol!r}, expected {gene[0]:g} to {gene[1]:g}")
        return values

    def plain(self) -> Genome | None:
        """Return the genome without modules, of which a builder may make a plain body; ``None``, the default, without one."""
        return None

    def list_genes(self) -> Sequence[tuple[float, float] | tuple[str, ...]]:
        """Return bounds of the number, or all texts, that the symbol at each position of a random genome can be.

        Optimisers of vectors or of choices need it. The symbol of a number has six digits, ``f"{value:.6g}"``. Raises
        InputError, as by default, if lengths vary.
        """
        raise InputError(f"grammar '{self.name}' lists no genes: use 'bspline', or another strategy that needs none")

    def make_genome(self, vector: Sequence[float] | FloatArray) -> Genome:
        """Return the genome of a point of the unit cube, which has one coordinate for each of :meth:`list_genes`."""
        symbols = []
        for gene, share in zip(self.list_genes(), np.clip(vector, 0, 1).tolist(), strict=True):
            if isinstance(gene[0], str):
                symbols.append(str(gene[min(int(share * len(gene)), len(gene) - 1)]))
            else:
                symbols.append(f"{gene[0] + share * (float(gene[1]) - gene[0]):.6g}")
        return Genome(self.name, tuple(symbols))

    def mutate(self, genome: Genome, rng: np.random.Generator, rate: float) -> Genome:
        """Return the genome with each symbol replaced with probability ``rate``."""
        for index in np.flatnonzero(rng.random(len(genome.symbols)) < rate):
            genome = self.flip(genome, int(index), rng)
        return genome


class PhenotypeBuilder(Plugin[OptionsT_co]):
    """Morphology -> body: adds the wall and the ends to the modules, and places the core."""

    @abstractmethod
    def build(self, morphology: Morphology) -> Body:
        """Return the meridian section of the morphology.

        The body must be valid for any morphology: both contours start and end on the axis and do not cross themselves,
        and the cavity lies inside the outer contour. ``morphology.tuning`` lies within :meth:`find_tunings`.
        """

    def find_tunings(self, morphology: Morphology) -> tuple[float, float] | None:
        """Return the least and the greatest tuning that the body of a morphology can have; ``None`` for a body without.

        The tuning is one continuous setting that a maker can choose after the shape, such as the mass of ballast. It must
        change the weight of the body, and not its outer contour. By default no mass is left free.
        """
        return None

    def describe_strength(self, body: Body, fluid: Fluid) -> Mapping[str, Any] | None:
        """Return, as JSON, what the hull of a body withstands from outside, with a ``summary``; ``None``, the default, if unknown."""
        return None


class Fitting(Plugin[OptionsT_co]):
    """Body -> what is fitted to its hull, such as an eyelet, a window, a fin, or a pocket for a sensor.

    A builder selects fittings by an option, as ``frusta`` does by ``builder.fittings``. What they weigh and displace follows
    from their solids. Those of revolution about the axis become part of the body's contours, and so of the flow; the flow model leaves
    others out.
    """

    @abstractmethod
    def draw(self, body: Body) -> tuple[Any, Any]:
        """Return what is added to the hull and what is then cut out of it: trees of ``driftform_frusta.csg``, or ``None``.

        Lengths are mm. z runs along the axis towards fore, from the origin of the body frame, whose y and z are x and y here.
        What is added reaches into the wall, to merge with it. Leave the core its room, and a wall between water and cavity.
        """


class HydrodynamicsOptions(Table):
    """The options that every hydrodynamic model has; a model with more options derives from this class."""

    drag: Literal["none", "strips"] = option(
        "none",
        "none, as in the paper, or strips: drag of strips across the axis, with friction and blunt ends along it",
    )
    drag_without: tuple[Literal["sphere", "ends", "wake", "roll", "lift", "bore"], ...] = option(
        (),
        "terms that drag = 'strips' leaves out: sphere (drag of a sphere, for bodies that are nearly spheres), ends (less "
        "drag across the axis of short bodies), wake (lift of the tail), roll (friction of a spin about the axis), lift (lift "
        "in a shear flow), bore (what a narrow pipe does to drag and carrying speed)",
    )


HydrodynamicsOptionsT_co = TypeVar("HydrodynamicsOptionsT_co", bound=HydrodynamicsOptions, covariant=True)


class Hydrodynamics(Plugin[HydrodynamicsOptionsT_co]):
    """Body -> hydrodynamic coefficients."""

    Options: ClassVar[type[Table]] = HydrodynamicsOptions

    @abstractmethod
    def coefficients(self, body: Body, fluid: Fluid) -> Coefficients:
        """Return added mass and damping; the added mass must be symmetric and positive semi-definite.

        A model does not compute the drag of strips: the pipeline adds it if ``options.drag`` is ``"strips"``.
        """


class AccuracyOptions(Table):
    """Options of a simulator that flies again until the estimated error of a flight is small enough."""

    accuracy: float = option(
        1e-3,
        "largest estimated error of the position, in gusts ten times as much up to 10 mm; the tolerance is reduced until "
        "this is met, in gusts only as long as that helps",
        "m",
        ge=1e-12,
        le=1e6,
    )
    tolerance: float = option(
        1e-6,
        "initial tolerance of a step at the release in every coordinate, ten times as much in gusts; it grows along the flight",
        "SI",
        ge=1e-15,
        le=1e-2,
    )
    tightest: float = option(1e-12, "tolerance below which it is not reduced", "SI", ge=1e-15, le=1e-2)
    max_step: float = option(0.05, "longest time step and time between samples", "s", ge=1e-5, le=10)
    step_limit: int = option(200_000, "steps after which a flight counts as failed", "", gt=0, le=100_000_000)


class Simulator(Plugin[OptionsT_co]):
    """Agent in a scenario -> trajectory.

    Implement :meth:`simulate`; override :meth:`simulate_batch` if many flights at once are faster. A flight that fails
    does not raise an exception: its trajectory holds the finite samples, and its ``end`` gives the reason. A flight
    that the simulator cannot compute to its promised accuracy must end as :attr:`driftform.types.End.NOT_CONVERGED`.
    """

    @abstractmethod
    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        """Return the trajectory of one agent from its release to the outlet or the horizon."""

    def simulate_batch(self, agents: Sequence[Agent], scenarios: Sequence[Scenario]) -> list[Trajectory]:
        """Return the trajectories of many agents, each in its own scenario.

        Each trajectory must equal that of :meth:`simulate`, whatever the rest of the batch.
        """
        return [self.simulate(agent, scenario) for agent, scenario in zip(agents, scenarios, strict=True)]

    def step(self, agent: Agent, scenario: Scenario, flown: Trajectory, duration: float) -> Trajectory:
        """Return the next ``duration`` (s) of a flight, which begins with the last sample of ``flown``; times are since the release.

        By default :meth:`simulate` flies an agent that is released as it is there. Override this if the simulator knows more of
        a flight than its trajectory. What bends bristles of friction is forgotten between steps. Flights with gusts have no steps.
        """
        found, begun = self.simulate(agent, scenario.resume(flown, duration)), float(flown.t[-1])
        contact = None if found.contact is None else begun + found.contact
        return replace(found, t=begun + found.t, contact=contact)

    def screen_batch(
        self, agents: Sequence[Agent], scenarios: Sequence[Scenario], matters: Callable[[int, Trajectory], bool]
    ) -> list[Trajectory]:
        """Return the trajectories of many agents; flights that do not matter to a search may be unchecked.

        An unchecked flight costs less: nothing estimates its error, and its ``error`` is ``None``. Override this method
        if the check of a flight takes much of its time. Make an unchecked flight of each agent, and call
        ``matters(index, trajectory)`` with its index in the batch. If that is true, return what :meth:`simulate`
        returns, to the last bit; otherwise return the unchecked trajectory. Each must be independent of the rest of the batch. The
        base class checks every flight.
        """
        return self.simulate_batch(agents, scenarios)


@dataclass(frozen=True)
class Measure:
    """A number that is measured of each flight besides its fitness: ``meaning``, ``unit``, and bounds ``low`` and ``high``.

    With ``is_violation`` it is by how much a constraint is missed, from 0: a flight that misses one is not feasible.
    """

    meaning: str
    unit: str = ""
    low: float = float("-inf")
    high: float = float("inf")
    is_violation: bool = False


class Fitness(Plugin[OptionsT_co]):
    """Trajectory -> one fitness for each target of the scenario, in percent: 100 is ``best``, 0 is ``worst``.

    The search knows only this number. People read what :meth:`measure` makes of it, and what :meth:`judge` says of the
    target. Unless a subclass has better words, that is the fitness itself, and 99 % or more is reached.
    """

    worst: ClassVar[float] = 0.0
    best: ClassVar[float] = 100.0
    """The bounds of what :meth:`score` returns, any numbers; ``best`` is the lesser one where less is better."""
    heading: ClassVar[str] = "fitness %"
    """What :meth:`measure` returns, with its unit: the heading of a column."""
    unit: ClassVar[str] = "%"
    """The unit of a single value."""
    goal: ClassVar[str] = "a fitness of at least 99 %"
    """What a target that is reached has, in words."""
    share: ClassVar[str] = ""
    """Heading of the column with the share of the disturbed flights that reach the target; empty for none."""
    measures: ClassVar[Mapping[str, Measure]] = {}
    """What :meth:`find_measures` returns, by name."""
    judges_passing: ClassVar[bool] = False
    """Whether only how near a flight passes the target counts, so that a disturbed flight may end after it."""

    @abstractmethod
    def score(self, trajectory: Trajectory, scenario: Scenario, agent: Agent) -> FloatArray:
        """Return a number from ``worst`` to ``best`` for each target, in the order of the scenario, (targets,).

        ``agent`` is what flew, for a fitness that also depends on mass or size.
        """

    def find_measures(self, trajectory: Trajectory, scenario: Scenario, agent: Agent) -> Mapping[str, float]:
        """Return the ``measures`` of an undisturbed flight, by name: objectives and descriptors for a strategy."""
        return {}

    def measure(self, fitness: float) -> float:
        """Return what people read of a fitness (%), in ``unit``: by default what was scored."""
        return self.worst + fitness * ((self.best - self.worst) / 100)

    def judge(self, fitness: float) -> Verdict:
        """Return whether the target of a fitness (%) is reached; a larger fitness never has a worse verdict."""
        if fitness >= 99:
            return Verdict.REACHED
        return Verdict.NEAR if fitness >= 95 else Verdict.MISSED

    def is_hit(self, fitness: float, miss: float, within: float) -> bool:
        """Return whether a disturbed flight hits its target, from its fitness (%) and its miss, both of a target.

        ``within`` is how near the study calls near enough, m. By default it is the fitness that decides.
        """
        return self.judge(fitness) is Verdict.REACHED

    def describe(self, fitness: float) -> str:
        """Return what people read of a fitness (%), as text with its unit."""
        return f"{self.measure(fitness):.2f} {self.unit}"


@dataclass(frozen=True, eq=False)
class SearchSpace:
    """The space that a strategy searches.

    Attributes:
        grammar: creates and varies genomes.
        targets: names of the targets, in the order of every fitness vector.
        rng: the only source of randomness that a strategy may use.
        scenario: the environment of the flights; open water by default.
        builder: makes bodies, for a strategy that compares or tunes them; ``None`` where only genomes are known.
        begin_elsewhere: begins a call in a worker, as :meth:`begin` asks for it; ``None`` without workers.
    """

    grammar: Grammar[Any]
    targets: tuple[str, ...]
    rng: np.random.Generator
    scenario: Scenario = field(default_factory=Scenario)
    builder: PhenotypeBuilder[Any] | None = None
    begin_elsewhere: Begin | None = None

    def begin(self, function: Callable[..., T], *args: Any) -> Callable[[], T]:
        """Begin ``function(grammar, builder, *args)`` in a worker of the run; return a function that waits for its result.

        What costs more than a millisecond belongs there: a run has one strategy, and many workers. The function must be
        importable, its arguments and its result picklable, and the result must follow from the arguments: randomness
        arrives as a seed. Without workers it is called at once.
        """
        if self.begin_elsewhere is not None:
            return self.begin_elsewhere(function, *args)
        result = function(self.grammar, self.builder, *args)
        return lambda: result


@dataclass(frozen=True, eq=False)
class Result:
    """A table that a strategy found, such as an archive or a front. The run keeps it, and the report draws it.

    Attributes:
        meaning: what it is, in one sentence.
        columns: finite numbers by the names of their columns, (rows,) each; ``evaluation`` is the index in the run.
        axes: names of the two columns along which the report draws it; empty for a table that is not drawn.
        grid: least value, greatest value and number of cells along each axis, for a map of cells; empty for points.
        colour: name of the column whose greatest value in a cell colours the cell.
    """

    meaning: str
    columns: Mapping[str, FloatArray]
    axes: Sequence[str] = ()
    grid: Sequence[tuple[float, float, int]] = ()
    colour: str = ""

    def __post_init__(self) -> None:
        found = {str(name): freeze(values, (None,), f"column '{name}'") for name, values in self.columns.items()}
        object.__setattr__(self, "columns", found)
        if len({len(values) for values in found.values()}) != 1 or not np.isfinite([*found.values()]).all():
            raise ValueError("the columns of a result are finite numbers, as many in each")
        named = {*self.axes, *([self.colour] if self.grid else [])}
        if len(self.axes) not in (0, 2) or not named <= set(found) or len(self.grid) not in (0, len(self.axes)):
            raise ValueError(f"a result has two axes, a grid of both and a colour, or none, of {', '.join(found)}")
        if not all(0 < count <= 1000 and -np.inf < low < high < np.inf for low, high, count in self.grid):
            raise ValueError("the grid of a result has 1 to 1000 cells between two finite bounds along each axis")


class Strategy(Plugin[OptionsT_co]):
    """Decides which genomes to evaluate next.

    Calls to :meth:`ask` and :meth:`tell` alternate, unless :meth:`can_ask_ahead` allows more. A resumed run repeats these calls with the stored evaluations.
    Therefore a strategy must draw all its randomness from ``space.rng``, and must not depend on time or on the number
    of workers.
    """

    evaluations_per_target: ClassVar[int] = 50
    """Default budget of a run, evaluations for each target."""

    def __init__(self, options: OptionsT_co, space: SearchSpace) -> None:
        super().__init__(options)
        self.space = space

    @abstractmethod
    def ask(self, limit: int) -> list[Candidate]:
        """Return the next candidates, at least one and at most ``limit``, the remaining evaluations of the budget.

        The limit may only truncate the candidates that a larger limit would give: a run with a larger budget must
        begin with the same candidates.

        A strategy that ignores low fitness should set ``Candidate.threshold``. Then flights that certainly matter
        neither to the strategy nor to the results of the run are not checked, which saves most of their time.
        """

    @abstractmethod
    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Receive the evaluations of the candidates that the earliest untold :meth:`ask` returned, in their order.

        ``first`` is the index of the first one in the run; ``Candidate.parents`` refers to such indices.
        """

    def can_ask_ahead(self) -> bool:
        """Return whether :meth:`ask` may be called again before :meth:`tell` has received the last batch.

        The workers of a run then evaluate one batch while the strategy learns from the other. It is asked after each
        :meth:`ask` and :meth:`tell`, and the answer must follow from these calls. The default is False.
        """
        return False

    def collect_results(self) -> Mapping[str, Result]:
        """Return what was found besides the best agents, by names of files; called once, after the last :meth:`tell`.

        The run writes it as CSV and JSON into its folder ``strategy``.
        """
        return {}


class GenerationStrategy(Strategy[OptionsT_co]):
    """A strategy that makes a generation, and learns from all of it: what an optimiser of a library needs.

    It hands out a generation in parts if ``ask`` may not return all of it, so that a budget cuts none of them. ``generation``
    is how many have ended.
    """

    def __init__(self, options: OptionsT_co, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._left: list[Candidate] = []
        self._told: list[Evaluation] = []
        self.generation = 0

    @abstractmethod
    def begin_generation(self) -> list[Candidate]:
        """Return the candidates of the next generation, at least one."""

    @abstractmethod
    def end_generation(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Learn from the evaluations of a generation; ``first`` is the index of the first one in the run."""

    def ask(self, limit: int) -> list[Candidate]:
        """Return what is left of a generation, or the next one, cut at ``limit``."""
        self._left = self._left or self.begin_generation()
        found, self._left = self._left[:limit], self._left[limit:]
        return found

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Keep the evaluations until their generation is complete."""
        self._told += evaluations
        if not self._left:
            told, self._told = self._told, []
            self.end_generation(first + len(evaluations) - len(told), told)
            self.generation += 1

    def read_values(self, evaluation: Evaluation, names: Sequence[str], option: str) -> list[float]:
        """Return values of an evaluation: its mean ``fitness`` (%), that for a target, or one of its measures.

        Raises InputError if it has no value of that name; ``option`` is the one with the names.
        """
        targets = dict(zip(self.space.targets, evaluation.fitness.tolist(), strict=True))
        values = {**evaluation.measures, **targets, "fitness": float(np.mean(evaluation.fitness))}
        if lacking := [name for name in names if name not in values]:
            known = ", ".join(values)
            raise InputError(f"strategy.{option} has '{lacking[0]}', which no evaluation has; these have {known}")
        return [values[name] for name in names]


@dataclass(frozen=True, eq=False)
class ExportJob:
    """An agent to export: what exporters and recorders receive.

    Attributes:
        name: name of the agent, valid as a file name.
        agent: the agent.
        scenario: the environment that the agent is designed for.
        document: content of its ``agent.json``, to be stored in the files; empty if no grammar made the agent.
        opened_as: what opens the agent on a command line, such as ``run:TP3``, with its settings, for the commands
            that a file recommends.
    """

    name: str
    agent: Agent
    scenario: Scenario
    document: Mapping[str, Any] = field(default_factory=dict)
    opened_as: str = "AGENT"


class Exporter(Plugin[OptionsT_co]):
    """Agent -> files. ``--format`` selects the exporter by its ``name``; file names end in ``suffix``.

    If a format is a folder of files, its suffix has no dot, as in ``-uuv``, and ``path`` is that folder. If one file
    cannot hold everything, such as the parts of a kit in a format for one solid, an exporter may write several files,
    whose names begin with that of ``path`` without its suffix. A file that accompanies them, such as a drawing, has
    another suffix: it is not a part to be checked.
    """

    suffix: ClassVar[str]

    @abstractmethod
    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the file at ``path``, or several files, and return a description of each; create missing parent folders.

        Raises WorkFailedError if the agent cannot be exported in this format; the message gives the reason.
        """

    def describe_water(self, job: ExportJob) -> str:
        """Return the part of the format that describes the forces of water, for the option ``--block`` of ``driftform inspect``.

        Raises WorkFailedError if the format has none.
        """
        raise WorkFailedError(f"the format '{self.name}' has no part for the forces of water")


class Renderer(Plugin[OptionsT_co]):
    """Agent and trajectory -> a film, or a still (one picture).

    The suffix of a file name selects its format: ``suffixes`` lists those of films, ``stills`` those of stills, in
    lower case. A renderer without stills leaves ``stills`` empty. A file must be written completely or not at all,
    and the same trajectory must give the same frames.
    """

    suffixes: ClassVar[tuple[str, ...]]
    stills: ClassVar[tuple[str, ...]] = ()

    def check(self, path: Path) -> None:
        """Check that a film can be made, before the simulation starts.

        Extend this method if a film needs something that may not be installed.

        Raises:
            InputError: if the suffix is not one of ``suffixes``.
            WorkFailedError: if something is missing; the message explains how to install it.
        """
        if path.suffix.lower() not in self.suffixes:
            raise InputError(f"{path}: a film by '{self.name}' ends in {' or '.join(self.suffixes)}")

    @abstractmethod
    def film(
        self, agent: Agent, trajectory: Trajectory, scenario: Scenario, path: Path, progress: Callable[[int, int], None]
    ) -> WrittenFile:
        """Write a film of the flight, from its first sample to its last, and return a description of the file.

        Call ``progress(done, total)`` with the number of finished frames and the number of all frames.

        Raises InputError or WorkFailedError like :meth:`check`, and if the film cannot be made or written.
        """

    def check_still(self, path: Path) -> None:
        """Check that a still can be made, before the simulation starts.

        Raises:
            InputError: if the suffix is not one of ``stills``.
            WorkFailedError: if something is missing; the message explains how to install it.
        """
        if not self.stills:
            raise InputError(f"{path}: '{self.name}' makes films, but not stills")
        if path.suffix.lower() not in self.stills:
            raise InputError(f"{path}: a still by '{self.name}' ends in {' or '.join(self.stills)}")

    def still(self, agent: Agent, trajectory: Trajectory, scenario: Scenario, path: Path, at: float) -> WrittenFile:
        """Write a picture of the agent at the time ``at``, s since the release, and return a description of the file.

        Override this method if ``stills`` is not empty.

        Raises InputError or WorkFailedError like :meth:`check_still`, and if the still cannot be made or written.
        """
        self.check_still(path)
        raise NotImplementedError(f"{type(self).__name__} lists stills, but does not implement still()")


class Recorder(Plugin[OptionsT_co]):
    """Agent and trajectory -> files of samples for other programs.

    ``--format`` selects the recorder by its ``name``; file names end in ``suffix``, which has no dot if the format is a
    folder of files, as for an exporter. The same trajectory must give the same content.
    """

    suffix: ClassVar[str]

    @abstractmethod
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        """Write the samples of a flight in the job's scenario, and return a description of each file; create missing folders.

        The trajectory may have a single sample, or be that of a failed flight: write all its samples. A file must be
        written completely or not at all.

        Raises WorkFailedError if the flight cannot be written in this format; the message gives the reason.
        """


@dataclass(frozen=True)
class Printer:
    """The printer that the parts are made for.

    Attributes:
        nozzle: diameter of the nozzle, m: the width of the narrowest line.
        bed: size of the largest part, m: width, depth and height.
    """

    nozzle: float = 0.0004
    bed: Vector = (0.25, 0.21, 0.21)


@dataclass(frozen=True, eq=False)
class PrintJob:
    """Printable files to check: what a checker receives.

    Attributes:
        files: the files, each with one or more parts; together they form one agent.
        printer: the printer that they are made for.
        export: the agent that the files should represent, ``None`` if unknown.
        volume: volume of material by the agent's closed-form geometry, m3, ``None`` if unknown.
        source: OpenSCAD source of the same solid, ``None`` if there is no such file.
    """

    files: tuple[Path, ...]
    printer: Printer = Printer()
    export: ExportJob | None = None
    volume: float | None = None
    source: Path | None = None


class Checker(Plugin[OptionsT_co]):
    """Printable files -> findings: whether the printed agent will match the simulated one.

    The contract checks STL files in text form; driftform writes binary ones. A checker that reads STL must read both, as
    ``read_meshes`` of driftform-kit does, or skip what it does not read.

    ``program`` is the name of the program on PATH that the checker runs, ``""`` if it runs no other program.
    """

    program: ClassVar[str] = ""

    @abstractmethod
    def check(self, job: PrintJob) -> Iterable[Finding]:
        """Check the files, and return one finding for each check.

        A fault of a part is a finding. So is a check that could not be made, for example because a program is not
        installed. Report each fault once: checks that it makes impossible are ``skipped``.

        Raises InputError if a file cannot be read at all.
        """


@dataclass(frozen=True, eq=False)
class Flown:
    """The best agent of a run for one target: the ``agent``, its ``trajectory``, its ``fitness`` (%), and its ``name``."""

    name: str
    agent: Agent
    trajectory: Trajectory
    fitness: float


@dataclass(frozen=True, eq=False)
class ReportJob:
    """A run to report: what the hook ``driftform_report`` receives.

    Attributes:
        name: of the run.
        scenario: the environment of all flights.
        best: the best agent of each target, by the name of the target.
    """

    name: str
    scenario: Scenario
    best: Mapping[str, Flown]


SEAMS: dict[str, type[Plugin[Any]]] = {
    "grammar": Grammar,
    "builder": PhenotypeBuilder,
    "fitting": Fitting,
    "hydrodynamics": Hydrodynamics,
    "simulator": Simulator,
    "fitness": Fitness,
    "strategy": Strategy,
    "exporter": Exporter,
    "recorder": Recorder,
    "renderer": Renderer,
    "checker": Checker,
}
"""The interfaces by the name of their seam, which hooks (``driftform_<seam>``) and tables of a study file use."""

NAMED = ("exporter", "recorder", "renderer", "checker")
"""The seams whose plugins a command selects by name: a study contains only their options."""

WITHIN = ("fitting",)
"""The seams whose plugins an option of another plugin selects, with their options."""
