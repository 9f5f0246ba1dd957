"""How long mixed bodies take through a straight bore: measured speeds, and quantiles of routes against those of whole flights."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.types import End
from driftform_networks.flights.bodies import open_traveller
from driftform_networks.flights.straight import draw_attitude, fly, release, spread_numbers
from driftform_networks.flights.transit import section_means, transit
from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.planning.following import route

EXACT = tuple(f"simulator.{text}" for text in ("tolerance=1e-9", "max_step=0.02", "step_limit=100000000"))

BORE, SPEED, WIDTH, LEAD = 0.15, 0.3, 0.06, 0.3
"""Of a main, m and m/s; diameter of a sphere, and length of the pipe before its release, m."""

MAIN = f"""[JUNCTIONS]
a 0 0
b 0 {250 * np.pi * BORE**2 * SPEED}
[RESERVOIRS]
s 90
[PIPES]
lead s a 1 150 130
main a b {{length}} 150 130
[OPTIONS]
Units LPS
[TIMES]
Duration 0
[END]
"""


@pytest.mark.parametrize("size", [0.31, 0.69])
def test_neutral_spheres_outrun_the_water_as_measured(size):
    """In a bore of 31.75 mm at 1 m/s: 1.05 to 1.5 times the mean speed (Ellis, Can. J. Chem. Eng. 42, 1964)."""
    sphere = open_traveller(f"sphere:{31.75 * size:g}mm", settings=("flow.roughness=0",))
    time, scatter = transit(sphere.place(0.03175, 1.0), sphere.width, 100.0)
    assert 1.05 < 1 / time < 1.5
    assert 0 < scatter < 1e-3


def test_a_point_takes_the_time_of_the_water_and_spreads_in_proportion_to_the_root_of_the_length():
    point = open_traveller("sphere:0.5mm")
    (time, short), (_, long) = (transit(point.place(1.0, 1.0), point.width, length) for length in (1e4, 4e4))
    assert time == pytest.approx(1, abs=2e-3)
    assert 4 * long == pytest.approx(short, rel=0.02)


@pytest.mark.parametrize("size", [0.3, 0.5, 0.69])
def test_the_centre_of_a_sphere_meets_the_mean_of_the_water_in_it(size):
    """Of the logarithmic law, 3/2 + ln(y / R) over kappa, at places that it takes evenly; points of the ball are drawn."""
    rng = np.random.default_rng(1)
    x = (1 - size) * np.sqrt(rng.random(200_000))
    way = rng.normal(size=(len(x), 3))
    way *= size * np.cbrt(rng.random((len(x), 1))) / np.linalg.norm(way, axis=1, keepdims=True)
    law = (1.5 + np.log(1 - np.hypot(x + way[:, 0], way[:, 1]))) / 0.4
    assert section_means(size)[0] == pytest.approx(law.mean(), rel=0.025)


def test_the_eddies_of_a_point_are_those_of_the_bore():
    """The mean of kappa min(y (1 - y), 1/6) over the section, in closed form: its pieces meet at y = (1 - sqrt(1/3)) / 2."""
    y = (1 - np.sqrt(1 / 3)) / 2
    near, core = y**2 - 4 * y**3 / 3 + y**4 / 2, (1 - y) ** 2 / 6
    assert section_means(0.001)[3] == pytest.approx(0.4 * (near + core), rel=0.005)


def test_bodies_keep_their_speeds_at_first_and_spread_as_by_a_diffusivity_later():
    """Taylor (1922): var U t^2 before the memory T, 2 K (t - T) long after it; eddies add theirs at once."""
    mean, variance, along, eddies = section_means(0.4)
    calm, rough = (open_traveller("sphere:60mm", settings=(f"gusts.crossing={c}",)) for c in (0.0, 10.0))
    friction = calm.place(BORE, SPEED).friction_velocity() / SPEED
    pace, growth, memory = 1 + friction * mean, 1 + 10 * 0.4**3, along / (variance * friction)

    def measure_spread(sphere, time):
        """The variance of places after a time, over the radius squared; the time is relative to radius over speed."""
        length = time * pace * BORE / 2
        return transit(sphere.place(BORE, SPEED), WIDTH, length)[1] * (time * pace) ** 2 * pace**2 / growth

    short, long = memory / 100, 1000 * memory
    expected = friction**2 * variance * short**2 + 2 * friction * eddies * short
    assert measure_spread(calm, short) == pytest.approx(expected, rel=0.01)
    assert measure_spread(calm, long) == pytest.approx(2 * friction * (along + eddies) * long, rel=0.002)
    # A body as long as many eddies is moved by the mean of two: half the exchange between the speeds, and twice the spread.
    halved = 2 * friction * (2 * along + eddies / 2) * long
    assert measure_spread(rough, long) == pytest.approx(halved, rel=0.003)


def test_a_body_arrives_with_the_mean_and_the_spread_of_its_pipe(tmp_path):
    """``[PIPES]`` of 1 m and 60 m; between the quantiles of 5 and 95 % there are 3.29 standard deviations."""
    path, sphere = tmp_path / "main.inp", replace(open_traveller("sphere:60mm"), error=0.0)
    path.write_text(MAIN.format(length=60.0))
    found = route(open_network(path, tmp_path), sphere, "a", demand_error=0.0, walks=20_000, cache=tmp_path).quantiles[
        1
    ]
    mean, variance = transit(sphere.place(BORE, SPEED), WIDTH, 60.0)
    assert found[1] == pytest.approx(mean * 60 / SPEED, rel=1e-3)
    assert np.ptp(found) == pytest.approx(3.29 * np.sqrt(variance) * 60 / SPEED, rel=0.03)


@pytest.mark.parametrize(
    ("length", "count"),
    [pytest.param(60.0, 100, marks=pytest.mark.long), pytest.param(1000.0, 200, marks=pytest.mark.slow)],
)
def test_quantiles_of_a_route_are_those_of_whole_flights(length, count, tmp_path):
    """To within three standard errors of median and spread; ``-s`` prints them.

    The flights are more exact than those of a search, which lose 0.24 % of the way: bodies touch the wall thousands of times.
    """
    path, sphere = (
        tmp_path / "main.inp",
        replace(open_traveller(f"sphere:{1000 * WIDTH:g}mm", settings=EXACT), error=0.0),
    )
    path.write_text(MAIN.format(length=length))
    passage = route(open_network(path, tmp_path), sphere, "a", demand_error=0.0, walks=20_000, cache=tmp_path)
    document = sphere.scenario.model_dump(include={"fluid", "flow", "gusts", "contact"})
    end = {"start": (0.0, 0.0, 0.0), "end": (LEAD + length, 0.0, 0.0), "radius": BORE / 2}
    document |= {"pipe": {"segments": [end]}, "flight": {"horizon": 2 * length / SPEED}}
    document["flow"]["speed"] = SPEED
    scenarios = []
    for seed, row in enumerate(spread_numbers(count, 4, 1)[:count]):
        document["gusts"]["seed"], clock, away = seed, 2 * np.pi * row[1], (BORE - WIDTH) / 2 * 0.999 * np.sqrt(row[0])
        place = away * np.array([np.sin(clock), np.cos(clock)])
        scenarios.append(release(sphere, document, LEAD, place, *draw_attitude(row[2:])))
    # One at a time: all samples of all flights take gigabytes.
    flights = (fly(sphere, [scenario], "in a main")[0] for scenario in scenarios if scenario is not None)
    times = np.array([flight.t[-1] for flight in flights if flight is not None and flight.end is End.OUTLET])
    assert len(times) == count
    flown, expected = np.quantile(times, (0.05, 0.5, 0.95)), passage.quantiles[1]
    error = 3 * 1.25 * times.std() / np.sqrt(count)
    print(f"\n{length:g} m: flights {flown.round(1)}, route {expected.round(1)} s, standard error {error / 3:.2f} s")
    assert expected[1] == pytest.approx(flown[1], abs=error)
    # From 5 to 95 % of a normal distribution there are 3.29 standard deviations.
    assert np.ptp(expected) == pytest.approx(3.29 * times.std(), rel=3 / np.sqrt(2 * count))
