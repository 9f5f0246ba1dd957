"""Exudyn's own linearisation finds the eigenvalues that ``inspect`` prints."""

import math

import numpy as np
import pytest

from driftform.motion.coordinates import Motion
from driftform.motion.model import flight_model
from driftform.motion.stability import stable_rest
from driftform.study import load_study
from driftform.util.rotations import matrix_from_quaternion
from driftform_exudyn.headless import exudyn, items


def exudyn_frequencies(model, height, pitch):
    """Angular frequencies (1/s) of small motions about rest; Exudyn differences the force function itself.

    Its mass matrix is that of world axes for the position and body axes for the rotation, so that stiffness is
    symmetric about a floating equilibrium, as Exudyn's solver expects.
    """
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    quaternion = np.array([math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0])
    motion = Motion.of(model, np.array([0.0, 0.0, height, *quaternion, *np.zeros(6)]))
    node = mbs.AddNode(
        items.NodeRigidBodyRotVecLG(
            referenceCoordinates=[0.0] * 6,
            initialCoordinates=motion.coordinates.tolist(),
            initialVelocities=motion.rates.tolist(),
        )
    )

    axes = np.eye(6)
    axes[:3, :3] = matrix_from_quaternion(quaternion)
    mass = axes @ model.numbers[0]["mass"] @ axes.T

    def force(_, t, __, pose, speed):
        return mass @ motion.accelerations(t, np.array(pose), np.array(speed), motion.values)

    mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=mass, forceUserFunction=force))
    mbs.Assemble()
    squares, _ = mbs.ComputeODE2Eigenvalues(useAbsoluteValues=False)
    return np.sqrt(np.maximum(squares, 0.0))


def test_a_floating_body_bobs_and_swings_as_exudyn_says():
    pipeline = load_study("paper", ["flow.speed=0.0", "fluid.water_level=0.0"]).make_pipeline()
    rng = np.random.default_rng(2)
    compared = 0
    while compared < 3:
        model = flight_model(pipeline.make_agent(pipeline.grammar.random(rng)), pipeline.scenario)
        rest = stable_rest(model)
        if rest.height is None:
            continue
        open_water = model._replace(pipe=np.empty((0, 8)))
        expected = exudyn_frequencies(open_water, rest.height, rest.pitch)
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
