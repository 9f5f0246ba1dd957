"""Gusts against what owes nothing to them: mixing, diffusion and dispersion of tracers; and the table of docs/turbulence.md."""

import math

import numpy as np
import pytest
from carried import Carrying
from scipy.integrate import solve_ivp
from tracers import carry, spread_evenly, straight_pipe

from driftform.motion.forces.model import flight_model
from driftform.testing.agents import sphere_agent
from driftform.testing.bodies import spheroid_body
from driftform.water.gusts import eddy_diffusivity
from driftform.water.velocity import FRICTION, flow_array, pipe_rows, water_motion

PIPES = [(0.05, 0.5), (0.1, 1.0), (0.15, 1.5), (1.0, 1.0)]
"""Radius (m) and mean speed (m/s)."""

DIAMETERS = np.array([5, 15, 30])
TRACERS = 6000


def mix(radius, speed):
    """Shares in the outer tenth of the area and within 1 % of R of the wall, and the mean speed over the bulk's, (3, 3)."""
    times = DIAMETERS * 2 * radius / speed
    places = carry(straight_pipe(radius, speed), spread_evenly(TRACERS, radius), times, seed=1)
    r = np.hypot(places[..., 1], places[..., 2]) / radius
    way = np.diff(places[..., 0].mean(axis=1), prepend=0.0)
    speeds = way / np.diff(times, prepend=0.0) / speed
    return np.column_stack([(r > math.sqrt(0.9)).mean(axis=1), (r > 0.99).mean(axis=1), speeds])


def friction(scenario):
    return float(flow_array(scenario)[FRICTION])


def spread_by_diffusion(times):
    """The rms distance from the axis over R after ``times`` (R/u*) of what diffuses from there, by finite volumes."""
    n = 200
    edges = np.linspace(0, 1, n + 1)
    middles = 0.5 * (edges[1:] + edges[:-1])
    K = np.array([eddy_diffusivity(1 - x, 1.0) for x in edges])

    def rate(_, density):
        flux = np.zeros(n + 1)
        flux[1:-1] = edges[1:-1] * K[1:-1] * np.diff(density) * n
        return np.diff(flux) * n / middles

    start = np.zeros(n)
    start[0] = 1.0
    found = solve_ivp(rate, (0, times[-1]), start, "BDF", t_eval=times, rtol=1e-8, atol=1e-12)
    mass = found.y * middles[:, None]
    return np.sqrt((mass * middles[:, None] ** 2).sum(axis=0) / mass.sum(axis=0))


def spread_of_tracers(scenario, times, count=3000):
    radius = scenario.pipe.layout.inlet.radius
    places = carry(scenario, np.zeros((count, 3)), np.array(times) * radius / friction(scenario), seed=2)
    return np.sqrt((places[..., 1:] ** 2).sum(axis=2).mean(axis=1)) / radius


def dispersion_by_integral(scenario):
    """(2/R^2) int [int_0^r (U - U_mean) r' dr']^2 / (r K) dr over R u*: Taylor 1954, with the model's own U and K."""
    radius, u = scenario.pipe.layout.inlet.radius, friction(scenario)
    r = (np.arange(20_000) + 0.5) / 20_000
    pipe, flow = pipe_rows(scenario), flow_array(scenario)
    U = np.array([water_motion((0.0, 0.0, x * radius), 0.0, pipe, flow)[0][0] for x in r.tolist()]) / u
    inner = np.cumsum((U - (U @ r) / r.sum()) * r) / len(r)
    K = np.array([eddy_diffusivity(1 - x, 1.0) for x in r.tolist()])
    return float(2 * (inner**2 / (r * K)).sum() / len(r))


def dispersion_of_tracers(scenario, count=3000):
    radius, u = scenario.pipe.layout.inlet.radius, friction(scenario)
    # A tracer crosses the bore within about R / u*; before, its spread depends on where it began.
    times = np.array([2.0, 16.0]) * radius / u
    x = carry(scenario, spread_evenly(count, radius), times, seed=6)[..., 0]
    return float(0.5 * np.diff(x.var(axis=1))[0] / np.diff(times)[0] / (radius * u))


@pytest.mark.long
@pytest.mark.parametrize(("radius", "speed"), PIPES)
def test_evenly_spread_tracers_stay_evenly_spread(radius, speed):
    outer, wall, mean = mix(radius, speed).T
    assert outer == pytest.approx([0.10] * 3, abs=0.01)
    assert wall == pytest.approx([0.02] * 3, abs=0.005)
    assert mean == pytest.approx([1.0] * 3, abs=0.01)


@pytest.mark.parametrize("smoothing", [pytest.param(0.1, marks=pytest.mark.long), 0.2])
def test_bodies_of_any_size_stay_evenly_spread_over_the_room_that_they_have(smoothing):
    for share in (0.03, 0.3):
        scenario = straight_pipe(0.1, 1.0, gusts={"smoothing": smoothing})
        times = np.array([1.0, 2.5]) * 0.1 / friction(scenario)
        room = (1 - share) * 0.1
        places = carry(scenario, spread_evenly(500, room), times, share * 0.1, seed=4)
        r = np.hypot(places[..., 1], places[..., 2]) / room
        assert r.max() < 1
        # Four standard errors of shares of 500 independent bodies.
        for least, expected in ((math.sqrt(0.9), 0.1), (0.99, 0.0199)):
            error = math.sqrt(expected * (1 - expected) / 500)
            assert (r > least).mean(axis=1) == pytest.approx([expected] * 2, abs=4 * error)


def test_tracers_spread_from_the_axis_like_a_diffusing_substance():
    times = [1.0, 2.0]
    # The root mean square of 400 tracers is known to 2.5 %.
    found = spread_of_tracers(straight_pipe(0.1, 1.0), times, 400)
    assert found == pytest.approx(spread_by_diffusion(times), rel=0.10)


@pytest.mark.long
def test_tracers_disperse_along_the_pipe_as_their_profile_and_diffusivity_say():
    scenario = straight_pipe(0.1, 1.0)
    assert dispersion_of_tracers(scenario) == pytest.approx(dispersion_by_integral(scenario), rel=0.10)


def test_a_body_against_the_wall_meets_no_gust_across_it():
    scenario = straight_pipe(0.1, 1.0)
    agent = sphere_agent(0.02, 0.034)
    model = flight_model(agent, scenario)
    from driftform.water.velocity import gust_at

    for turn in np.linspace(0, 6, 7):
        place = (1.0, 0.08 * math.cos(turn), 0.08 * math.sin(turn))
        gust, _, _ = gust_at(place, (1.0, 0.0, 0.0), model.pipe, model.flow, model.gusts, model.eddies)
        outward = (gust[1] * place[1] + gust[2] * place[2]) / 0.08
        assert abs(outward) < 1e-12 < math.hypot(gust[1], gust[2])


def test_neutral_balls_do_not_gather_at_the_wall_of_a_narrow_main():
    """They have inertia, and are no tracers."""
    count = 80
    [found] = Carrying(spheroid_body(0.03, 0.03), 0.15, 1.0, (6,)).observe(count)
    assert found.outer == pytest.approx(0.1, abs=3 * math.sqrt(0.09 / count))
    assert found.touching <= 0.06
    assert found.speed == pytest.approx(1.0, abs=0.02)


@pytest.mark.slow
def test_the_page_shows_what_tracers_do(published):
    lines = [
        "| R, U | after | in the outer tenth of the area | within 1 % of R | mean speed over the bulk's |",
        "|---|---|---|---|---|",
    ]
    for radius, speed in PIPES:
        for diameters, row in zip(DIAMETERS, mix(radius, speed), strict=True):
            values = " | ".join(f"{value:.3f}" for value in row)
            lines.append(f"| {radius:g} m, {speed:g} m/s | {diameters} diameters | {values} |")
    scenario, times = straight_pipe(0.1, 1.0), [0.5, 1.0, 2.0]
    lines += ["", "| quantity | tracers | computed otherwise |", "|---|---|---|"]
    pairs = zip(times, spread_of_tracers(scenario, times), spread_by_diffusion(times), strict=True)
    lines += [f"| rms distance from the axis over R, after {t:g} R/u* | {a:.3f} | {b:.3f} |" for t, a, b in pairs]
    found, expected = dispersion_of_tracers(scenario), dispersion_by_integral(scenario)
    lines.append(f"| dispersion along the pipe over R u* | {found:.2f} | {expected:.2f} |")
    published("turbulence", lines)
