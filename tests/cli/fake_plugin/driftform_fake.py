"""A plugin for tests alone: fast straight flights, and genomes that do harm on purpose."""

import hashlib
import multiprocessing
import os
import signal
import sys
import threading
import time
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from driftform import hookimpl
from driftform.errors import InputError, WorkFailedError
from driftform.interfaces import (
    Checker,
    Exporter,
    Fitness,
    Hydrodynamics,
    HydrodynamicsOptions,
    PhenotypeBuilder,
    Renderer,
    Simulator,
    Strategy,
    Table,
    option,
)
from driftform.testing.letters import LetterGrammar
from driftform.types import (
    Body,
    Candidate,
    Coefficients,
    Core,
    End,
    Finding,
    Genome,
    Module,
    Morphology,
    Trajectory,
    WrittenFile,
)
from driftform.util.files import write_text, write_whole
from driftform.util.preparation import preparing


def die_once(marker):
    """End the process, but only the first time."""
    if not marker.exists():
        marker.touch()
        os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
    return "alive"


def die_while_sending(marker):
    """Send the first half of a result that is larger than a pipe holds, and die, but only the first time."""
    if marker.exists():
        return "alive"
    marker.touch()

    def send_half(self, data, write=os.write):
        write(self.fileno(), bytes(data)[: max(4, len(data) // 2)])
        if len(data) > 4:
            os.kill(os.getpid(), signal.SIGKILL)

    Connection._send = send_half
    return bytes(10**6)


def end_process(deed):
    """End the process without a word, as native code does."""
    if deed == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    os._exit(3)


def refuse():
    raise InputError("no")


def write_slowly(path):
    write_whole(path, lambda part: (part.write_text("half"), time.sleep(60)))


class SilentError(Exception):
    """An error whose text cannot be read."""

    def __str__(self):
        raise ValueError("no comment")


def _raise(error):
    raise error


def _flight(t, end, first=0.0):
    count = len(t)
    return Trajectory(t, np.full((count, 3), first), np.tile([1.0, 0, 0, 0], (count, 1)), np.zeros((count, 6)), end)


def _print():
    print("mind the gap")
    os.write(1, b"mind the other gap\n")
    return _flight(np.linspace(0.0, 1.0, 11), End.HORIZON)


def _prepare():
    """Compile for five seconds, as far as anybody can tell."""
    with preparing():
        time.sleep(5)
    return _flight(np.linspace(0.0, 1.0, 11), End.HORIZON)


def _clone():
    """Leave a clone of the process behind, which flies elsewhere, and answers too."""
    is_clone = os.fork() == 0
    return _flight(np.linspace(0.0, 1.0, 11), End.OUTLET, 0.5 if is_clone else 0.0)


def _clone_and_wait():
    """Leave a clone of the process behind, which waits for ever."""
    if os.fork() == 0:
        time.sleep(1e6)
    return _flight(np.linspace(0.0, 1.0, 11), End.OUTLET)


def _move():
    os.chdir("/")
    return _flight(np.linspace(0.0, 1.0, 11), End.OUTLET)


DEEDS = {
    "prepare": _prepare,
    "clone": _clone,
    "clone and wait": _clone_and_wait,
    "move": _move,
    "interrupt": lambda: _raise(KeyboardInterrupt()),
    "generator": lambda: _raise(GeneratorExit()),
    "exit": lambda: sys.exit(0),
    "leave": lambda: os._exit(0),
    "thread": lambda: threading.Thread(target=time.sleep, args=(1e6,), name="idle").start() or [],
    "die": lambda: end_process("exit"),
    "segfault": lambda: end_process("segfault"),
    "none": lambda: None,
    "backward": lambda: _flight(np.linspace(1.0, 0.0, 11), End.OUTLET),
    "nan": lambda: _flight(np.linspace(0.0, 1.0, 11), End.OUTLET, np.nan),
    "words": lambda: replace(_flight(np.linspace(0.0, 1.0, 11), End.OUTLET), error="small"),
    "absent": lambda: [WrittenFile("never", "nowhere.never")],
    "silent": lambda: _raise(SilentError()),
    "surrogate": lambda: _raise(ValueError("half of a letter: \ud800")),
    "print": _print,
}
"""What plugins should not do, in place of what they should."""


class FakeOptions(Table):
    die: float = option(0.0, "share of the genomes that end their process", "", ge=0, le=1)
    signal: str = option("", "name of the signal that they end it by, in place of an exit")
    hang: float = option(0.0, "share of the genomes whose flight never ends", "", ge=0, le=1)
    deed: str = option("", "what it does in place of a flight: see DEEDS")
    stillborn: bool = option(False, "whether a worker process ends before it evaluates anything")
    die_once: str = option("", "directory of markers: with it a genome ends its process only the first time")
    fail: float = option(0.0, "share of the genomes that raise an exception", "", ge=0, le=1)
    pause: float = option(0.0, "duration of an evaluation", "s", ge=0)
    log: str = option("", "file that gets a line for each flight")


def number(genome):
    """A number of the genome, uniform from 0 to 1 over genomes."""
    return int(hashlib.sha256(" ".join(genome.symbols).encode()).hexdigest()[:8], 16) / 2**32


class FakeSimulator(Simulator[FakeOptions]):
    """A straight line, or what the options ask for."""

    name = "fake"
    Options = FakeOptions

    def __init__(self, options):
        super().__init__(options)
        if options.stillborn and multiprocessing.parent_process() is not None:
            os._exit(3)

    def simulate(self, agent, scenario):
        u = number(agent.genome)
        if u < self.options.die and self._marked(u):
            if self.options.signal:
                os.kill(os.getpid(), getattr(signal, self.options.signal))
            os._exit(1)
        if u < self.options.hang:
            time.sleep(1e6)
        if u > 1 - self.options.fail:
            raise RuntimeError(f"genome {u:.6f} is not to my taste")
        if self.options.deed:
            return DEEDS[self.options.deed]()
        time.sleep(self.options.pause)
        if self.options.log:
            with Path(self.options.log).open("a") as file:
                file.write(f"{u}\n")
        t = np.linspace(0.0, 9.0, 101)
        course = np.array([1.0, 0.0, 0.2 * (u - 0.5)])
        quaternion = np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1))
        velocity = np.tile([*course, 0.0, 0.0, 0.0], (len(t), 1))
        return Trajectory(t, t[:, None] * course, quaternion, velocity, End.OUTLET)

    def _marked(self, u):
        if not self.options.die_once:
            return True
        try:
            (Path(self.options.die_once) / str(u)).touch(exist_ok=False)
        except FileExistsError:
            return False
        return True


class SlipOptions(Table):
    slip: str = option("", "what it returns in place of what it should: see the table of its class")


GRAMMAR_SLIPS = {
    "list": ("random", lambda rng: ["a"] * 12),
    "crossover": ("crossover", lambda a, b, rng: a),
    "unread": ("parse", lambda text: refuse()),
    "express": ("express", lambda genome: None),
    "flat": ("express", lambda genome: Morphology(fore=(Module(float("nan"), 0.0),))),
}


class SlippingGrammar(LetterGrammar):
    """Letters, but one method returns something else."""

    name = "slipping"
    Options = SlipOptions

    def __init__(self, options):
        super().__init__(options)
        if options.slip in GRAMMAR_SLIPS:
            setattr(self, *GRAMMAR_SLIPS[options.slip])

    def random(self, rng):
        return Genome(self.name, (0.5,)) if self.options.slip == "floats" else super().random(rng)


BUILDER_SLIPS = {
    "none": lambda: None,
    "words": lambda: Body([["a", "b"]], np.zeros((0, 2)), [], Core(0.01, 0.05), 0.001, 1050.0),
}


class SlippingBuilder(PhenotypeBuilder[SlipOptions]):
    """Builds what is no body."""

    name = "slipping"
    Options = SlipOptions

    def build(self, morphology):
        return BUILDER_SLIPS[self.options.slip]()


class SlippingOptions(HydrodynamicsOptions, SlipOptions):
    pass


HYDRODYNAMICS_SLIPS = {"shape": lambda: Coefficients(np.eye(3)), "negative": lambda: Coefficients(-np.eye(6))}


class SlippingHydrodynamics(Hydrodynamics[SlippingOptions]):
    """Coefficients that no body has."""

    name = "slipping"
    Options = SlippingOptions

    def coefficients(self, body, fluid):
        return HYDRODYNAMICS_SLIPS[self.options.slip]()


SCORES = {
    "nan": lambda n: np.full(n, np.nan),
    "infinite": lambda n: np.full(n, np.inf),
    "negative": lambda n: np.full(n, -1.0),
    "too many": lambda n: np.full(n + 1, 50.0),
    "too few": lambda n: np.full(n - 1, 50.0),
    "ragged": lambda n: [[1.0], [2.0, 3.0]],
    "raising": lambda n: np.linalg.inv(np.zeros((2, 2))),
}

MEASURES = {"measure": lambda fitness: float("nan"), "raising words": lambda fitness: {}["lost"]}


class SlippingFitness(Fitness[SlipOptions]):
    """A score that no selection can work with, or words that nobody can read."""

    name = "slipping"
    Options = SlipOptions

    def __init__(self, options):
        super().__init__(options)
        if options.slip == "heading":
            self.heading = None

    def measure(self, fitness):
        return MEASURES.get(self.options.slip, float)(fitness)

    def score(self, trajectory, scenario, agent):
        return SCORES.get(self.options.slip, lambda n: np.full(n, 50.0))(len(scenario.targets))


CANDIDATES = {
    "exit": lambda genome: sys.exit(0),
    "generator": lambda genome: _raise(GeneratorExit()),
    "none": lambda genome: None,
    "target": lambda genome: [Candidate(genome, target="Mars")],
    "parents": lambda genome: [Candidate(genome, parents=(99,))],
    "threshold": lambda genome: [Candidate(genome, threshold=(1.0, 2.0))],
    "numpy": lambda genome: [Candidate(genome, parents=[], generation=np.int64(3))],
}


class SlippingStrategy(Strategy[SlipOptions]):
    """Candidates that do not fit into the run; or a strategy for another grammar."""

    name = "slipping"
    Options = SlipOptions

    def __init__(self, options, space):
        super().__init__(options, space)
        if options.slip == "picky":
            raise InputError(f"strategy 'slipping' searches grammar 'reals', not '{space.grammar.name}'")

    def ask(self, limit):
        return CANDIDATES[self.options.slip](self.space.grammar.random(self.space.rng))

    def tell(self, first, evaluations):
        pass


CHECKER_SLIPS = {"": lambda: [], "none": lambda: None, "state": lambda: [Finding("closed", "fine", "all is well")]}


class SlippingChecker(Checker[SlipOptions]):
    """Findings that nobody can read; without a slip none of its own."""

    name = "slipping"
    Options = SlipOptions

    def check(self, job):
        return CHECKER_SLIPS[self.options.slip]()


class DeedOptions(Table):
    deed: str = option("", "what it does: see DEEDS")


class DeedExporter(Exporter[DeedOptions]):
    """A format that is never written."""

    name = "deed"
    suffix = ".never"
    Options = DeedOptions

    def write(self, agent, path):
        return DEEDS[self.options.deed]()


class RefusingExporter(Exporter[Table]):
    """A format that holds no agent."""

    name = "refusing"
    suffix = ".never"

    def write(self, agent, path):
        raise WorkFailedError("this agent is too pretty")


class FlipBookOptions(Table):
    pages: int = option(20, "how many pages it has", "", gt=0)
    torn: bool = option(False, "whether it fails at its last page")
    lost: bool = option(False, "whether it says nothing of what it wrote")


class FlipBook(Renderer[FlipBookOptions]):
    """A film of words."""

    name = "flip-book"
    suffixes = (".txt",)
    Options = FlipBookOptions

    def film(self, agent, flight, scenario, path, progress):
        self.check(path)
        for page in range(1, self.options.pages + 1):
            progress(page, self.options.pages)
        if self.options.torn:
            raise WorkFailedError("the last page is torn")
        write_text(path, f"{self.options.pages} pages of {flight.t[-1]:g} s\n")
        return None if self.options.lost else WrittenFile(self.name, str(path))


BROUGHT = {
    "grammar": [LetterGrammar, SlippingGrammar],
    "builder": SlippingBuilder,
    "hydrodynamics": SlippingHydrodynamics,
    "checker": SlippingChecker,
    "simulator": FakeSimulator,
    "fitness": SlippingFitness,
    "exporter": [RefusingExporter, DeedExporter],
    "renderer": FlipBook,
    "strategy": SlippingStrategy,
}


def make_hook(classes):
    return hookimpl(lambda: classes)


globals().update({f"driftform_{seam}": make_hook(classes) for seam, classes in BROUGHT.items()})
