"""Exudyn's own linearisation finds the eigenvalues that ``inspect`` prints."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from driftform.motion.forces.model import flight_model
from driftform.motion.path.stability import stable_rest
from driftform.study import load_study
from driftform.water import Pipe
from driftform_exudyn.system import exudyn_system


def exudyn_frequencies(agent, scenario, height, pitch):
    """Angular frequencies (1/s) of small motions about rest; Exudyn differences the forces itself."""
    release = scenario.release.model_copy(
        update={"frame": "world", "position": (0.0, 0.0, height), "pitch_deg": math.degrees(pitch), "velocity": "rest"}
    )
    mbs = exudyn_system(agent, scenario.model_copy(update={"release": release, "pipe": Pipe()})).mbs
    mbs.Assemble()
    mass, stiffness, _ = (np.array(matrix) for matrix in mbs.ComputeLinearizedSystem())
    # Exudyn leaves the loads out. The weight's moment about the core changes as the body turns.
    weight, cog = agent.mass.mass * scenario.fluid.gravity, agent.mass.cog
    turned = Rotation.from_rotvec([0.0, pitch, 0.0])
    for column, step in enumerate(1e-6 * np.eye(3)):
        up, down = ((turned * Rotation.from_rotvec(s)).as_matrix()[2] for s in (step, -step))
        stiffness[3:, 3 + column] += weight * np.cross(cog, up - down) / 2e-6
    squares = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real
    return np.sqrt(np.maximum(squares, 0.0))


def test_a_floating_body_bobs_and_swings_as_exudyn_says():
    pipeline = load_study("paper", ["flow.speed=0.0", "fluid.water_level=0.0"]).make_pipeline()
    rng = np.random.default_rng(2)
    compared = 0
    while compared < 3:
        agent = pipeline.make_agent(pipeline.grammar.random(rng))
        model = flight_model(agent, pipeline.scenario)
        rest = stable_rest(model)
        if rest.height is None:
            continue
        expected = exudyn_frequencies(agent, pipeline.scenario, rest.height, rest.pitch)
        ours = np.sort(np.abs(rest.eigenvalues.imag))[::2]
        swinging = ours > 0.1
        assert swinging.sum() >= 2
        assert ours[swinging] == pytest.approx(np.sort(expected)[swinging], rel=2e-3)
        compared += 1


def test_a_body_that_sinks_swings_with_its_righting_moment_over_the_inertia_that_it_swings_with():
    pipeline = load_study("paper").make_pipeline()
    rng = np.random.default_rng(2)
    for _ in range(5):
        agent = pipeline.make_agent(pipeline.grammar.random(rng))
        model = flight_model(agent, pipeline.scenario)
        n = model.numbers[0]
        weight, buoyancy = agent.mass.mass * 9.81, 1024.0 * agent.mass.volume * 9.81
        righting = buoyancy * n["cob"][0] - weight * n["cog"][0]
        # Pitch accelerates by the inverse mass times the moment and the part of the net force that comes to lie
        # across the axis.
        square = n["inverse"][4, 4] * righting - n["inverse"][4, 2] * (buoyancy - weight)
        rest = stable_rest(model)
        assert rest.slowest_period == pytest.approx(2 * math.pi / math.sqrt(abs(square)), rel=1e-5)
        assert math.copysign(1, square) == -math.copysign(1, rest.pitch)
        assert rest.eigenvalues.real.max() < 0.01
