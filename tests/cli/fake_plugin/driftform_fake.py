"""A plugin for tests alone: fast straight flights, and genomes that do harm on purpose."""

import hashlib
import os
import time
from pathlib import Path

import numpy as np

from driftform import hookimpl
from driftform.errors import WorkFailedError
from driftform.interfaces import Exporter, Fitness, Renderer, Simulator
from driftform.options import Table, option
from driftform.types import End, Trajectory, WrittenFile
from driftform.util.files import write_text


class FakeOptions(Table):
    die: float = option(0.0, "share of the genomes that end their process", "", ge=0, le=1)
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

    def simulate(self, agent, scenario):
        u = number(agent.genome)
        if u < self.options.die and self._marked(u):
            os._exit(1)
        if u > 1 - self.options.fail:
            raise RuntimeError(f"genome {u:.6f} is not to my taste")
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


class NonsenseOptions(Table):
    value: str = option("nan", "what float() reads the fitness from")
    extra: int = option(0, "how many numbers too many there are")


class NonsenseFitness(Fitness[NonsenseOptions]):
    """What no selection can work with."""

    name = "nonsense"
    Options = NonsenseOptions

    def score(self, trajectory, scenario, agent):
        return np.full(len(scenario.targets) + self.options.extra, float(self.options.value))


class RefusingExporter(Exporter[Table]):
    """A format that holds no agent."""

    name = "refusing"
    suffix = ".never"

    def write(self, agent, path):
        raise WorkFailedError("this agent is too pretty")


class FlipBookOptions(Table):
    pages: int = option(20, "how many pages it has", "", gt=0)
    torn: bool = option(False, "whether it fails at its last page")


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
        return WrittenFile(self.name, str(path))


@hookimpl
def driftform_simulator():
    return FakeSimulator


@hookimpl
def driftform_fitness():
    return NonsenseFitness


@hookimpl
def driftform_exporter():
    return RefusingExporter


@hookimpl
def driftform_renderer():
    return FlipBook
