"""Plugins with one mistake each that a run would not notice; here, because another process must be able to import them."""

import itertools
from dataclasses import replace

import numpy as np

from driftform.builtin.fitness import ClosestApproach
from driftform.interfaces import Simulator
from driftform.testing.letters import LetterGrammar
from driftform.types import End, Trajectory
from driftform.util.options import Table
from driftform.water.field import water_velocity
from driftform_striptheory.coefficients import StripTheory

TICKS = itertools.count()


class Drifting(Simulator[Table]):
    """A point that drifts with the water, and rises or sinks at its terminal speed: sound."""

    name, duration, claimed, way = "drifting", 0.01, 1e-3, 1.0

    def simulate(self, agent, scenario):
        fluid, damping = scenario.fluid, agent.coefficients.quadratic_damping[2, 2]
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


def enlarge_turning(found):
    return replace(found, added_mass=found.added_mass + np.diag([0, 0, 0, 0, *1e6 * np.diag(found.added_mass)[4:]]))


ANSWER, BODY = "test_an_answer_depends_on_nothing_but_the_question", {"kind": "cone off the origin"}

MISTAKES = {
    ("score", "Remembering"): (lambda p, f, *_: np.clip(f - remember(p), 0, 100), ANSWER, {}),
    ("score", "Noisy"): (lambda p, f, *_: np.clip(f - np.random.default_rng().random(), 0, 100), ANSWER, {}),
    ("score", "Hashing"): (lambda p, f, t, s, a: f * (0.9 + hash(s.target_names) % 997 / 9970), ANSWER, {}),
    ("score", "Reversed"): (lambda p, f, *_: f[::-1], "test_values_follow_the_order_of_the_targets", {}),
    ("score", "InTheBodyFrame"): (
        score_surge_as_speed_in_the_world,
        "test_the_body_frame_is_not_taken_for_the_world",
        {},
    ),
    ("score", "AlongX"): (
        lambda p, f, t, s, a: f * np.clip(t.position[:, 0].max() / s.target_array()[:, 0], 0, 1),
        "test_a_world_that_is_turned_about_the_vertical_is_the_same",
        {},
    ),
    ("express", "Counting"): (lambda p, f, *_: lengthen(f, 1e-4 * remember(p)), ANSWER, {}),
    ("flip", "Unseeded"): (lambda p, f, *_: LetterGrammar.random(p, np.random.default_rng()), ANSWER, {}),
    ("coefficients", "ElsewhereThanItSays"): (
        lambda p, f, *_: replace(f, origin=np.zeros(3)),
        "test_a_body_elsewhere_on_the_axis_has_the_same_added_mass",
        BODY,
    ),
    ("coefficients", "Enormous"): (
        lambda p, f, *_: enlarge_turning(f),
        "test_no_motion_moves_more_water_than_that_of_a_spheroid_around_the_body",
        BODY,
    ),
    ("coefficients", "Swapped"): (
        lambda p, f, *_: swap_axes(f),
        "test_an_axisymmetric_body_has_axisymmetric_coefficients",
        BODY,
    ),
    ("coefficients", "Feeding"): (
        lambda p, f, *_: replace(f, linear_damping=-1e-3 * np.eye(6)),
        "test_damping_takes_energy_and_never_gives_any",
        BODY,
    ),
    ("coefficients", "Trembling"): (
        lambda p, f, *_: replace(f, added_mass=f.added_mass * (1 + 1e-9 * next(TICKS))),
        ANSWER,
        {},
    ),
    ("way", "Sinking"): (-1.0, "test_a_buoyant_body_rises_and_a_heavy_one_sinks", {"density": 0.8, "way": 1}),
    ("duration", "Overconfident"): (0.2, "test_the_estimated_error_covers_what_short_steps_change", {"density": 1.25}),
}
"""By what is wrong, and a name: what takes its place, or is made of what the sound method found; the test, and its arguments."""

SOUND = (ClosestApproach, LetterGrammar, StripTheory, Drifting)


def spoil(member, name, change):
    """Return the sound class that has a member, with another value of it, or with a change to what the method returns."""
    base = next(base for base in SOUND if hasattr(base, member))
    sound = getattr(base, member)

    def spoilt(self, *arguments):
        return change(self, sound(self, *arguments), *arguments)

    members = {member: spoilt} if callable(change) else {member: change, "claimed": 0.0}
    return type(name, (base,), {**members, "__module__": __name__})


globals().update({name: spoil(member, name, change) for (member, name), (change, *_) in MISTAKES.items()})
