"""The flow on a grid is exact where splines are, and a grid that does not fit its pipe is refused."""

import numpy as np
import pytest

from driftform.design.inspection import list_doubts
from driftform.testing.agents import sphere_agent
from driftform.types import End
from driftform.water import Pipe, Scenario
from driftform.water.fittings import fitting_array
from driftform.water.parts.grid_files import VelocityGrid
from driftform.water.parts.grid_flow import grid_motion, grid_velocities, inlet_speed, make_grid, wall_leakage
from driftform.water.scenario import Release
from driftform_native.simulator import NativeOptions, NativeSimulator
from driftform_tees.currents import write_current

RADIUS, LENGTH, SPACING = 0.1, 1.0, 0.02
OPEN = Pipe()


def sample(velocity, low=(-0.1, -0.2, -0.2), high=(1.1, 0.2, 0.2), spacing=SPACING):
    """Return a grid of velocities between two corners; ``velocity`` takes positions (..., 3)."""
    low = np.array(low)
    shape = np.rint((np.array(high) - low) / spacing).astype(int) + 1
    grid = VelocityGrid(low, np.full(3, spacing), np.zeros((*shape, 3)))
    return VelocityGrid(grid.origin, grid.spacing, np.broadcast_to(velocity(grid.nodes()), (*shape, 3)).copy())


def along(nodes):
    return np.array([1.0, 0.0, 0.0])


def in_pipe(tmp_path, grid, **flow):
    """Return the scenario of a straight pipe with this grid."""
    path = tmp_path / "current.csv"
    write_current(path, grid)
    return Scenario.model_validate(
        {
            "pipe": {"radius": RADIUS, "parts": [{"length": LENGTH}]},
            "flow": {"kind": "grid", "file": str(path), "speed": 1.0, **flow},
            "release": {"position": (0.1, 0.0, 0.0)},
        }
    )


def test_a_linear_current_and_its_gradient_are_exact_between_the_nodes():
    rng = np.random.default_rng(0)
    constant, gradient = rng.normal(size=3), rng.normal(size=(3, 3))
    grid = sample(lambda x: constant + x @ gradient.T)
    array = make_grid(grid, OPEN.layout, np.zeros(1))
    inner = grid.origin + 6 * grid.spacing, grid.end - 6 * grid.spacing
    for point in rng.uniform(*inner, (50, 3)):
        velocity, slope = grid_motion(tuple(point.tolist()), array)
        np.testing.assert_allclose(velocity, constant + gradient @ point, atol=2e-4)
        np.testing.assert_allclose(slope, gradient, atol=2e-2)


def test_a_smooth_current_is_interpolated_to_the_fourth_order():
    def wave(x):
        return np.stack([np.sin(5 * x[..., 1]), np.cos(4 * x[..., 2]), np.sin(6 * x[..., 0])], axis=-1)

    rng, errors = np.random.default_rng(1), []
    points = rng.uniform((0.3, -0.05, -0.05), (0.7, 0.05, 0.05), (400, 3))
    for spacing in (0.02, 0.01):
        array = make_grid(sample(wave, spacing=spacing), OPEN.layout, np.zeros(1))
        errors.append(np.abs(grid_velocities(points, array) - wave(points)).max())
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] > 12


def test_a_current_along_the_pipe_does_not_leak(tmp_path):
    grid = sample(along)
    array = fitting_array(in_pipe(tmp_path, grid))
    leakage, worst, _ = wall_leakage(grid, array)
    assert leakage < 1e-12
    assert worst < 1e-12


@pytest.mark.parametrize("angle_deg", [2.0, 5.0])
def test_the_leakage_of_an_oblique_current_is_its_velocity_across_the_wall(tmp_path, angle_deg):
    """The root mean square of sin(a) cos(t) around the pipe is sin(a) / sqrt(2)."""
    across = np.sin(np.radians(angle_deg))
    grid = sample(lambda x: np.array([np.sqrt(1 - across**2), across, 0.0]))
    array = fitting_array(in_pipe(tmp_path, grid))
    leakage, worst, _ = wall_leakage(grid, array)
    assert leakage == pytest.approx(across / np.sqrt(2), rel=0.03)
    assert worst == pytest.approx(across, rel=1e-3)


def test_the_mean_speed_at_the_inlet_is_that_of_the_profile(tmp_path):
    """Poiseuille's profile has half of the speed in the middle."""
    grid = sample(lambda x: (1 - (x[..., 1:2] ** 2 + x[..., 2:] ** 2) / RADIUS**2) * along(x))
    array = fitting_array(in_pipe(tmp_path, grid, reference=0.5))
    pipe = in_pipe(tmp_path, grid).pipe
    assert inlet_speed(array, pipe.layout) == pytest.approx(0.5, rel=5e-3)


def plugged(nodes):
    return np.where(np.linalg.norm(nodes - [0.5, 0, 0], axis=-1, keepdims=True) < 0.06, np.nan, along(nodes))


@pytest.mark.parametrize(
    ("grid", "flow", "words"),
    [
        (sample(lambda x: np.array([0.97, 0.24, 0.0])), {}, "leaks: the velocity through the wall is"),
        (sample(along), {"reference": 2.0}, "has a mean speed of 1 m/s at the inlet, but flow.reference = 2"),
        (sample(along, high=(0.8, 0.2, 0.2)), {}, "and the pipe beyond, for example to"),
        (
            sample(along, low=(-100, -200, -200), high=(1100, 200, 200), spacing=20),
            {},
            "are its coordinates in metres?",
        ),
        (sample(lambda x: 1e3 * along(x)), {}, "has a speed of 1000 m/s: are its velocities in m/s"),
        (sample(along, spacing=0.06), {}, "nodes 0.06 m apart, too far for a bore of 0.2 m"),
        (sample(plugged), {}, "nodes in the pipe, for example"),
        (
            sample(along, low=(-0.1, -0.2, -0.2), high=(1.1, 0.2, 0.0)),
            {},
            "covers only a part of the section: it reaches from (-0.1, -0.2, -0.2) to (1.1, 0.2, 0) m, and the bore to (",
        ),
        (sample(along, low=(-0.1, 0.0, -0.2), high=(1.1, 0.2, 0.2)), {}, "covers only a part of the section"),
    ],
)
def test_a_grid_that_does_not_fit_the_pipe_is_refused(tmp_path, grid, flow, words):
    with pytest.raises(ValueError, match=r"flow\.file = '.*current\.csv' ") as refusal:
        fitting_array(in_pipe(tmp_path, grid, **flow))
    assert words in str(refusal.value)


def test_a_grid_that_ends_within_a_spacing_of_the_wall_is_enough(tmp_path):
    """Programs write the nodes of the water, the last of which lie up to a cell inside the wall."""
    grid = sample(along, low=(-0.1, -0.09, -0.09), high=(1.1, 0.09, 0.09))
    assert inlet_speed(fitting_array(in_pipe(tmp_path, grid)), in_pipe(tmp_path, grid).pipe.layout) == pytest.approx(1)


def test_a_body_that_leaves_a_grid_in_open_water_ends_its_flight_there(tmp_path):
    """A neutral body drifts with a uniform current: to the face at 1.1 m from 0.1 m at 0.5 m/s, it takes two seconds."""
    scenario = in_pipe(tmp_path, sample(lambda x: 0.5 * along(x)))
    release = Release(position=(0.1, 0.0, 0.0), velocity="current")
    scenario = scenario.model_copy(update={"pipe": OPEN, "release": release})
    neutral = sphere_agent(0.01, scenario.fluid.density * 4 / 3 * np.pi * 0.01**3)
    flight = NativeSimulator(NativeOptions()).simulate(neutral, scenario)
    assert flight.end is End.EDGE
    assert flight.t[-1] == pytest.approx(2.0, rel=1e-6)
    assert flight.position[-1] == pytest.approx([1.1, 0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize(("density", "words"), [(1, "less than 1 % of"), (1.01, None), (4, "more than")])
def test_a_body_that_drifts_with_all_water_of_a_grid_or_outruns_it_is_said(tmp_path, density, words):
    scenario = in_pipe(tmp_path, sample(lambda x: 0.5 * along(x))).model_copy(update={"pipe": OPEN})
    ball = sphere_agent(0.01, density * scenario.fluid.density * 4 / 3 * np.pi * 0.01**3)
    said = [line for line in list_doubts(ball, scenario) if "flow.file" in line]
    assert [words in line and "fastest water in flow.file, 0.5 m/s" in line for line in said] == [True] * bool(words)


@pytest.mark.parametrize("factor", [1e-3, 1e7])
def test_a_grid_of_millimetres_or_of_thousands_of_kilometres_is_refused(tmp_path, factor):
    grid = sample(along)
    grid = VelocityGrid(factor * grid.origin, factor * grid.spacing, grid.velocity)
    with pytest.raises(ValueError, match="m along x: are its coordinates in metres"):
        fitting_array(in_pipe(tmp_path, grid).model_copy(update={"pipe": OPEN}))


def test_in_open_water_every_node_needs_a_velocity():
    grid = sample(along)
    grid.velocity[3, 4, 5] = np.nan
    with pytest.raises(ValueError, match="in open water every node needs one"):
        make_grid(grid, OPEN.layout, np.zeros(1))
