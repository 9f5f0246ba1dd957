"""Plugins with one mistake each, made of a sound one; here, because another process must be able to import them."""

import itertools
import shutil
from dataclasses import replace

import numpy as np

from driftform.builtin.fitness import ClosestApproach
from driftform.interfaces import Checker, Exporter, GenerationStrategy, Recorder, Simulator
from driftform.testing.letters import LetterGrammar
from driftform.types import Candidate, End, Finding, Morphology, State, Trajectory, WrittenFile
from driftform.util.files import write_text
from driftform.util.options import Table
from driftform.water import Fluid
from driftform.water.field import water_velocity
from driftform_frusta.builder import FrustaBuilder
from driftform_striptheory.coefficients import StripTheory

TICKS = itertools.count()


class Drifting(Simulator[Table]):
    """A point that drifts with the water, and rises or sinks at its terminal speed: sound."""

    name, duration, claimed, way = "drifting", 0.01, 1e-3, 1.0

    def simulate(self, agent, scenario):
        fluid, damping = scenario.fluid, agent.coefficients.quadratic_damping[2, 2] or np.inf
        net = fluid.gravity * (fluid.density * agent.mass.volume - agent.mass.mass)
        rise = np.array([0.0, 0.0, self.way * np.sign(net) * np.sqrt(abs(net) / damping)])
        times = np.linspace(0, scenario.flight.horizon, 1 + max(1, round(scenario.flight.horizon / self.duration)))
        path = [np.array(scenario.release.position)]
        for begin, end in itertools.pairwise(times):
            half = path[-1] + 0.5 * (end - begin) * (water_velocity([path[-1]], begin, scenario)[0] + rise)
            path.append(path[-1] + (end - begin) * (water_velocity([half], 0.5 * (begin + end), scenario)[0] + rise))
        position, level = np.array(path), np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
        velocity = np.hstack([np.gradient(position, times, axis=0), np.zeros_like(position)])
        return Trajectory(times, position, level, velocity, End.HORIZON, error=self.claimed)


class Climbing(GenerationStrategy[Table]):
    """Ten random genomes, then ten mutants of the best so far in each generation: sound."""

    name, sign, threshold = "climbing", 1, None

    def begin_generation(self):
        grammar, rng = self.space.grammar, self.generator()
        if not self.generation:
            self.best = (-np.inf, grammar.random(rng))
        made = [grammar.mutate(self.best[1], rng, 0.2) if self.generation else grammar.random(rng) for _ in range(10)]
        return [Candidate(genome, threshold=self.threshold) for genome in made]

    def end_generation(self, first, evaluations):
        for evaluation in evaluations:
            self.best = max(self.best, (self.judge(evaluation), evaluation.genome), key=lambda row: row[0])

    def generator(self):
        return self.space.rng

    def judge(self, evaluation):
        return self.sign * float(evaluation.fitness[0])


class Lines(Recorder[Table]):
    """A line for each sample: sound."""

    name, suffix, whole = "lines", ".txt", True

    def tell(self, flight):
        return "\n".join(str(flight.position[k].tolist() + flight.quaternion[k].tolist()) for k in range(len(flight.t)))

    def write(self, job, trajectory, path):
        part = path if self.whole else path.with_name(f"{path.name}.part")
        write_text(part, self.tell(trajectory))
        part.replace(path)
        return (WrittenFile(self.name, str(path)),)


class Outline(Exporter[Table]):
    """The outer contour as text, in a folder: sound."""

    name, suffix, replaces = "outline", "-outline", True

    def write(self, job, path):
        if self.replaces and path.is_dir():
            shutil.rmtree(path)
        path.mkdir(parents=True, exist_ok=True)
        write_text(path / "outer.txt", self.tell(job.agent.body.outer))
        return (WrittenFile(self.name, str(path / "outer.txt")),)

    def tell(self, contour):
        return "\n".join(f"{1000 * x:.6f} {1000 * r:.6f}" for x, r in contour)


class Facets(Checker[Table]):
    """Whether a file has facets: sound."""

    name = "facets"

    def count(self, path):
        return path.read_bytes().count(b"endfacet")

    def check(self, job):
        for path in job.files:
            found = self.count(path)
            yield Finding("facets", State.PASS if found else State.FAIL, f"{found} facets", path.stem)


SOUND = {
    "grammar": LetterGrammar,
    "builder": FrustaBuilder,
    "hydrodynamics": StripTheory,
    "simulator": Drifting,
    "fitness": ClosestApproach,
    "strategy": Climbing,
    "exporter": Outline,
    "recorder": Lines,
    "checker": Facets,
}


def score_surge_as_speed_in_the_world(fitness, found, flight, scenario, agent):
    steps = np.diff(flight.t)[:, None] * flight.velocity[1:, :3]
    path = flight.position[0] + np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
    return ClosestApproach.score(fitness, replace(flight, position=path), scenario, agent)


def remember(plugin):
    """Return how often this instance was asked."""
    plugin.asked = getattr(plugin, "asked", 0) + 1
    return plugin.asked


def lengthen(found, by):
    return replace(found, aft=(*found.aft[:-1], replace(found.aft[-1], length=0.005 + by)))


def swap_axes(found):
    order = [2, 1, 0, 5, 4, 3]
    return replace(found, added_mass=found.added_mass[np.ix_(order, order)])


def add_turning(found, times):
    return replace(found, added_mass=found.added_mass + np.diag([0, 0, 0, 0, *times * np.diag(found.added_mass)[4:]]))


def move(found, x):
    outer, cavity = (contour + np.array([x, 0.0]) for contour in (found.outer, found.cavity))
    return replace(found, outer=outer, cavity=cavity, joints=found.joints + x)


def write_beside(path, name):
    write_text(path.with_name(name), "notes")


def need(true):
    assert true


CHANGES = {
    "grammar": {
        "counts": ("express", lambda p, f, *_: lengthen(f, 1e-4 * remember(p))),
        "own random flips": ("flip", lambda p, f, *_: LetterGrammar.random(p, np.random.default_rng())),
        "lost letter": ("crossover", lambda p, f, *_: (replace(f[0], symbols=f[0].symbols[1:]), f[1])),
        "unread text": ("to_text", lambda p, f, *_: f[::-1]),
        "steep": ("express", lambda p, f, *_: replace(f, fore=tuple(replace(m, tilt=8 * m.tilt) for m in f.fore))),
        "ends exchanged": ("express", lambda p, f, *_: Morphology(f.aft, f.fore)),
        "no aft": ("express", lambda p, f, *_: replace(f, aft=())),
    },
    "builder": {
        "counts": ("build", lambda p, f, *_: replace(f, hull_density=1000.0 + remember(p))),
        "one side": ("build", lambda p, f, m: FrustaBuilder.build(p, Morphology(fore=m.fore + m.aft))),
        "ends exchanged": ("build", lambda p, f, m: FrustaBuilder.build(p, Morphology(m.aft, m.fore))),
        "no wall": ("build", lambda p, f, *_: replace(f, cavity=f.outer)),
        "core outside": ("build", lambda p, f, *_: move(f, 0.5)),
        "doubled": ("build", lambda p, f, *_: replace(f, outer=2 * f.outer, cavity=2 * f.cavity, joints=2 * f.joints)),
    },
    "hydrodynamics": {
        "other point": ("coefficients", lambda p, f, *_: replace(f, origin=np.zeros(3))),
        "enormous": ("coefficients", lambda p, f, *_: add_turning(f, 1e6)),
        "axes exchanged": ("coefficients", lambda p, f, *_: swap_axes(f)),
        "feeds": ("coefficients", lambda p, f, *_: replace(f, linear_damping=-1e-3 * np.eye(6))),
        "trembles": ("coefficients", lambda p, f, *_: replace(f, added_mass=f.added_mass * (1 + 1e-9 * next(TICKS)))),
        "one fluid": ("coefficients", lambda p, f, body, _: StripTheory.coefficients(p, body, Fluid(density=998.0))),
        "half more": ("coefficients", lambda p, f, *_: replace(f, added_mass=1.5 * f.added_mass)),
    },
    "simulator": {
        "sinks": ("way", -1.0),
        "overconfident": ("duration", 0.2),
        "from the origin": ("simulate", lambda p, f, *_: replace(f, position=f.position - f.position[0])),
        "late": ("simulate", lambda p, f, *_: replace(f, t=f.t + 0.01)),
    },
    "fitness": {
        "counts": ("score", lambda p, f, *_: np.clip(f - remember(p), 0, 100)),
        "noisy": ("score", lambda p, f, *_: np.clip(f - np.random.default_rng().random(), 0, 100)),
        "hash": ("score", lambda p, f, t, s, a: f * (0.9 + hash(s.target_names) % 997 / 9970)),
        "reversed": ("score", lambda p, f, *_: f[::-1]),
        "body frame": ("score", score_surge_as_speed_in_the_world),
        "along x": ("score", lambda p, f, t, s, a: f * np.clip(t.position[:, 0].max() / s.target_array()[:, 0], 0, 1)),
        "masked": ("score", lambda p, f, *_: np.ma.masked_array(f, mask=[True, *[False] * (len(f) - 1)])),
        "first target": ("score", lambda p, f, *_: f[:1]),
        "above its best": ("score", lambda p, f, *_: 1.2 * f),
        "two directions": ("measure", lambda p, f, fitness: abs(fitness - 50.0)),
    },
    "strategy": {
        "own random numbers": ("generator", lambda p, f: np.random.default_rng()),
        "clock": ("judge", lambda p, f, evaluation: f - evaluation.seconds),
        "threshold": ("threshold", (np.inf, np.inf)),
        "limit": ("ask", lambda p, f, limit: (f * (1 + limit))[: 1 + limit]),
        "seeks the worst": ("sign", -1),
    },
    "exporter": {"stamped": ("tell", lambda p, f, *_: f"{next(TICKS)}\n{f}"), "old files": ("replaces", False)},
    "recorder": {
        "stamped": ("tell", lambda p, f, *_: f"{next(TICKS)}\n{f}"),
        "name alone": ("tell", lambda *_: "a flight"),
        "slope": ("tell", lambda p, f, flight: f"{flight.t[1] - flight.t[0]}\n{f}"),
        "sound alone": ("tell", lambda p, f, flight: (need(not flight.end.failed), f)[1]),
        "pipes alone": ("write", lambda p, f, job, *_: (need(job.scenario.pipe.straight), f)[1]),
        "litter": ("write", lambda p, f, job, t, path: (write_beside(path, "agent-notes.txt"), f)[1]),
        "torn": ("whole", False),
    },
    "checker": {
        "lenient": ("count", lambda *_: 1),
        "strict": ("count", lambda *_: 0),
        "doubling": ("check", lambda p, f, *_: [*f] * 2),
        "silent": ("check", lambda *_: ()),
        "trembles": ("count", lambda p, f, path: f + next(TICKS)),
        "scribbles": ("count", lambda p, f, path: (write_beside(path, "box.log"), f)[1]),
        "mends": ("count", lambda p, f, path: (path.write_bytes(path.read_bytes() + b"\n"), f)[1]),
        "no program": ("program", "a-program-that-is-nowhere"),
    },
}
"""By seam and name: the member that is wrong, and its value, or what it makes of the sound answer and the arguments."""


def name_of(seam, name):
    """Return the name of a plugin, by which its class is found here, too."""
    return f"{seam}-{name.replace(' ', '-')}"


def spoil(seam, name):
    """Return the sound class of a seam with one mistake."""
    base, (member, change) = SOUND[seam], CHANGES[seam][name]
    sound = getattr(base, member)

    def spoilt(self, *arguments):
        return change(self, sound(self, *arguments), *arguments)

    values = {"name": name_of(seam, name), "__doc__": f"Wrong: {name}.", "__module__": __name__, "claimed": 0.0}
    return type(name_of(seam, name), (base,), values | {member: spoilt if callable(change) else change})


globals().update({name_of(seam, name): spoil(seam, name) for seam, changes in CHANGES.items() for name in changes})
