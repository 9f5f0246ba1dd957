"""Buoyancy at the surface, against segments of circles, and as the gradient of its energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from driftform.agent import mass_properties
from driftform.motion.forces.buoyancy import buoyancy, buoyant_energy, half_height, submerged_share
from driftform.motion.forces.model import flight_model
from driftform.testing.agents import Spheroid
from driftform.testing.bodies import cylinder_body, dome_body, spheroid_body
from driftform.types import Agent, Coefficients
from driftform.water import Fluid, Scenario

WEIGHT = 1024.0 * 9.81
"""Of a cubic metre of water, N."""

BODIES = {
    "spheroid": spheroid_body(0.06, 0.02),
    "cylinder": cylinder_body(0.1, 0.02),
    "disc": cylinder_body(0.01, 0.05),
    "half sphere": dome_body(0.03),
}

turns = st.tuples(*[st.floats(-3, 3)] * 3)
heights = st.floats(-0.08, 0.08)


def model_of(body, cob=None):
    mass = mass_properties(body)
    if cob is not None:
        mass = replace(mass, cob=np.array(cob))
    agent = Agent(body, replace(mass, mass=0.5 * 1024 * mass.volume), Coefficients(np.zeros((6, 6))))
    return agent, flight_model(agent, Scenario(fluid=Fluid(density=1024.0, gravity=9.81, water_level=0.0)))


MODELS = {name: model_of(body) for name, body in BODIES.items()}
bodies = st.sampled_from(list(BODIES))


def rotation(R):
    return tuple(tuple(row) for row in R.tolist())


def wrench_of(slices, height, R, centre=(0.0, 0.0, 0.0), level=0.0):
    """Force and torque in body axes, volume under water and the x of its centre."""
    (force, torque), volume, x = buoyancy(float(height), rotation(R), tuple(centre), level, WEIGHT, slices)
    return np.array(force), np.array(torque), volume, x


def discs(radius, length, count, width=None):
    """A cylinder of discs that are as thin as one likes, each with the volume of its share of the length."""
    x = length * ((np.arange(count) + 0.5) / count - 0.5)
    share = length / count
    columns = (radius, np.pi * radius**2 * share, share if width is None else width)
    return np.column_stack([x, *(np.full(count, c) for c in columns)])


def segment(radius, depth):
    """Area of a circle below a line ``depth`` above its centre, and its moment about the parallel diameter."""
    d = np.clip(depth, -radius, radius)
    area = radius**2 * (np.pi - np.arccos(d / radius)) + d * np.sqrt(radius**2 - d**2)
    return area, 2 / 3 * (radius**2 - d**2) ** 1.5


@given(bodies, turns, st.floats(0.2, 50))
def test_a_body_far_below_the_surface_is_carried_by_all_its_volume_at_its_centre(name, turn, depth):
    agent, model = MODELS[name]
    R = Rotation.from_rotvec(turn).as_matrix()
    force, torque, volume, x = wrench_of(model.slices, -depth, R, agent.mass.cob)
    assert volume == pytest.approx(agent.mass.volume, rel=1e-12)
    assert x == pytest.approx(agent.mass.cob[0], abs=1e-15)
    lift = R.T @ [0, 0, WEIGHT * agent.mass.volume]
    assert force == pytest.approx(lift, rel=1e-12, abs=1e-13)
    assert torque == pytest.approx(np.cross(agent.mass.cob, lift), rel=1e-12, abs=1e-14)


def test_a_centre_of_buoyancy_off_the_axis_is_where_the_force_acts():
    agent, model = model_of(BODIES["spheroid"], cob=(0.003, 0.001, -0.002))
    R = Rotation.from_rotvec([0.4, -0.3, 0.8]).as_matrix()
    force, torque, _, x = wrench_of(model.slices, -1.0, R, agent.mass.cob)
    assert x == pytest.approx(0.003, abs=1e-15)
    assert torque == pytest.approx(np.cross([0.003, 0.001, -0.002], force), rel=1e-9)


@given(bodies, turns)
def test_a_body_in_the_air_feels_nothing(name, turn):
    agent, model = MODELS[name]
    R = Rotation.from_rotvec(turn).as_matrix()
    force, torque, volume, x = wrench_of(model.slices, 0.2, R, agent.mass.cob)
    assert (volume, x) == (0.0, 0.0)
    assert np.concatenate([force, torque]) == pytest.approx(np.zeros(6), abs=0)
    assert buoyant_energy(0.2, rotation(R), tuple(agent.mass.cob), 0.0, WEIGHT, model.slices) == 0.0


@given(st.floats(-1.5, 1.5), st.floats(-0.06, 0.06), st.floats(-0.05, 0.05))
def test_a_thin_disc_has_the_waterline_of_its_circle(pitch, height, x):
    # The surface cuts the disc's plane in a line, q from its centre; the part below has its centroid on the
    # steepest line. The force there, seen from the body's origin: x cross F, and F times the segment's moment.
    radius, width = 0.03, 1e-9
    R = Rotation.from_rotvec([0.0, pitch, 0.0]).as_matrix()
    up = R[2]
    steep = math.hypot(up[1], up[2])
    depth = -(height + x * up[0])
    area, moment = segment(radius, depth / steep)
    slices = np.array([[x, radius, np.pi * radius**2 * width, width]])
    force, torque, volume, _ = wrench_of(slices, height, R)
    in_plane = np.array([0.0, up[1], up[2]]) / steep
    lift = WEIGHT * width * area * up
    expected = np.cross([x, 0, 0], lift) + np.cross(-in_plane, up) * WEIGHT * width * moment
    size = WEIGHT * width * np.pi * radius**2
    # Where the disc just dips in, q / r is rounded by 1e-16, and the area with the root of that to the third power.
    assert volume == pytest.approx(width * area, abs=1e-12 * size / WEIGHT)
    assert force == pytest.approx(lift, abs=1e-12 * size)
    assert torque == pytest.approx(expected, abs=1e-12 * size * 0.06)


def test_a_thin_disc_that_stands_upright_is_under_water_or_not():
    slices, R = np.array([[0.0, 0.03, 1e-9, 1e-12]]), Rotation.from_rotvec([0, -np.pi / 2, 0]).as_matrix()
    for height, volume in ((1e-6, 0.0), (-1e-6, 1e-9)):
        force, torque, under, _ = wrench_of(slices, height, R)
        assert under == volume
        assert np.isfinite([*force, *torque]).all()


def semicircle(xi):
    xi = np.clip(xi, -1, 1)
    return (xi * np.sqrt(1 - xi**2) + np.arcsin(xi)) / np.pi + 0.5


@pytest.mark.parametrize("count", [1, 2, 10, 40])
def test_an_upright_cylinder_sinks_in_proportion_to_its_load(count):
    # A slice's height is spread evenly over its width w; the semicircle law of the same variance reaches out to
    # w / sqrt 3 instead of w / 2. Summed over the slices of a long cylinder the two differ by a periodic function of
    # the depth: at most 1.7 % of one slice's volume, and 2.9 % at the ends of the body.
    depth = np.linspace(-1.5, 1.5, 3001)
    law = sum(semicircle((depth - k) * math.sqrt(3)) for k in range(-3, 4))
    even = sum(np.clip(depth - k + 0.5, 0, 1) for k in range(-3, 4))
    assert np.abs(law - even)[1000:2001].max() < 0.017
    end = np.abs(semicircle(depth * math.sqrt(3)) - np.clip(depth + 0.5, 0, 1)).max()
    assert end < 0.029
    radius, length = 0.02, 0.1
    slices = discs(radius, length, count)
    R = Rotation.from_rotvec([0.0, -np.pi / 2, 0.0]).as_matrix()
    one = np.pi * radius**2 * length / count
    for height in np.linspace(-0.07, 0.07, 57):
        under = np.pi * radius**2 * np.clip(length / 2 - height, 0, length)
        force, torque, volume, _ = wrench_of(slices, height, R)
        inner = abs(height) < length / 2 - length / count
        assert volume == pytest.approx(under, abs=(0.017 if inner else 0.029) * one)
        assert R @ force == pytest.approx([0, 0, WEIGHT * volume], rel=1e-9, abs=1e-12)
        assert torque == pytest.approx([0, 0, 0], abs=1e-12)


@given(st.floats(0.001, 0.05), st.floats(0.001, 0.05), st.floats(-1, 1), st.floats(-0.1, 0.1))
def test_the_share_under_water_has_the_mean_and_the_variance_of_a_cylinders_heights(r, w, e, middle):
    # Heights of the points of a cylinder about its centre: r^2 (1 - e^2) / 4 from the disc, w^2 e^2 / 12 from the
    # width. Those of the law: the integral of h^2 dF(h).
    a = half_height(r, w, e)
    assert a**2 / 4 == pytest.approx(r**2 * (1 - e**2) / 4 + w**2 * e**2 / 12, rel=1e-9)
    xi = np.cos(np.linspace(np.pi, 0, 2001))
    share = np.array([submerged_share(a * s, a) for s in xi.tolist()])
    heights = 0.5 * (xi[1:] + xi[:-1]) * a
    assert np.diff(share) @ heights**2 == pytest.approx(a**2 / 4, rel=1e-5)
    assert np.diff(share) @ heights == pytest.approx(0, abs=1e-9)
    assert submerged_share(middle, a) + submerged_share(-middle, a) == pytest.approx(1.0, abs=1e-15)


@given(bodies, turns, heights, st.sampled_from([(0.0, 0.0), (0.001, -0.002)]))
def test_force_and_torque_are_the_gradient_of_the_energy(name, turn, height, off):
    agent, model = MODELS[name]
    centre = (float(agent.mass.cob[0]), *off)
    R = Rotation.from_rotvec(turn).as_matrix()

    def energy(height, R):
        return buoyant_energy(height, rotation(R), centre, 0.0, WEIGHT, model.slices)

    force, torque, _, _ = wrench_of(model.slices, height, R, centre)
    h, scale = 1e-6, WEIGHT * agent.mass.volume
    lift = -(energy(height + h, R) - energy(height - h, R)) / (2 * h)
    assert R @ force == pytest.approx([0, 0, lift], abs=1e-5 * scale)
    found = []
    for i in range(3):
        ahead, back = (R @ Rotation.from_rotvec(s * h * np.eye(3)[i]).as_matrix() for s in (1, -1))
        found.append(-(energy(height, ahead) - energy(height, back)) / (2 * h))
    # A slice's second derivative is of the order of 1 / a, and of (1 - xi^2)^(-1/2) / a where it just dips in; a of an
    # upright disc is small.
    assert torque == pytest.approx(found, abs=1e-5 * scale * 0.1)


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("pitch", [0.0, 0.3, -1.2])
def test_nothing_jumps_as_the_surface_is_crossed(name, pitch):
    agent, model = MODELS[name]
    R = Rotation.from_rotvec([0.0, pitch, 0.0]).as_matrix()
    path = np.linspace(-0.09, 0.09, 4001)
    wrench = np.array([np.concatenate(wrench_of(model.slices, z, R, agent.mass.cob)[:2]) for z in path])
    # dF / d(depth) <= 2 / (pi a): a slice takes at least its diameter's share of the way to go under.
    e = R[2, 0]
    thinnest = min(half_height(r, w, e) for r, w in model.slices[:, [1, 3]].tolist())
    most = WEIGHT * agent.mass.volume * 2 / (math.pi * thinnest) * (path[1] - path[0])
    assert np.abs(np.diff(wrench[:, :3], axis=0)).max() <= most
    assert np.abs(np.diff(wrench[:, 3:], axis=0)).max() <= 0.1 * most
    assert wrench[0] == pytest.approx([*R.T @ [0, 0, WEIGHT * agent.mass.volume], *wrench[0, 3:]], rel=1e-9)
    assert wrench[-1] == pytest.approx(np.zeros(6), abs=0)


def test_slices_of_a_model_keep_the_volume_and_the_centre_that_the_agent_is_given():
    agent = Spheroid(0.06, 0.02).agent()
    agent = replace(agent, mass=replace(agent.mass, volume=1.1 * agent.mass.volume, cob=np.array([0.004, 0, 0])))
    x, r, volume, width = flight_model(agent, Scenario(fluid=Fluid(water_level=0.0))).slices.T
    assert volume.sum() == pytest.approx(agent.mass.volume, rel=1e-12)
    assert volume @ x / volume.sum() == pytest.approx(0.004, abs=1e-15)
    assert np.pi * r**2 * width == pytest.approx(volume, rel=1e-12)


def test_a_full_pipe_needs_no_slices():
    assert flight_model(Spheroid(0.06, 0.02).agent(), Scenario()).slices.shape == (0, 4)
