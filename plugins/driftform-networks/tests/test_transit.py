"""How long mixed bodies take through a straight bore: measured speeds, and quantiles of routes against those of whole flights."""

import numpy as np
import pytest

from driftform.types import End
from driftform_networks.flights.bodies import open_traveller
from driftform_networks.flights.straight import draw_attitude, fly, release, spread_numbers
from driftform_networks.flights.transit import transit
from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.planning.following import route

BORE, SPEED, WIDTH, LEAD = 0.15, 0.3, 0.06, 0.3
"""Of a main, m and m/s; diameter of a sphere, and length of the pipe before its release, m."""


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


@pytest.mark.parametrize(
    ("length", "count"),
    [pytest.param(60.0, 100, marks=pytest.mark.long), pytest.param(1000.0, 200, marks=pytest.mark.slow)],
)
def test_quantiles_of_a_route_are_those_of_whole_flights(length, count, tmp_path):
    """To within 0.4 % of the time, a quarter of the spread, and three standard errors; ``-s`` prints them."""
    text = f"[JUNCTIONS]\na 0 0\nb 0 {250 * np.pi * BORE**2 * SPEED}\n[RESERVOIRS]\ns 90\n[PIPES]\nlead s a 1 150 130\n"
    path, sphere = tmp_path / "main.inp", open_traveller(f"sphere:{1000 * WIDTH:g}mm")
    path.write_text(f"{text}main a b {length} 150 130\n[OPTIONS]\nUnits LPS\n[TIMES]\nDuration 0\n[END]\n")
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
    flights = fly(sphere, [scenario for scenario in scenarios if scenario is not None], "in a main")
    times = np.array([flight.t[-1] for flight in flights if flight is not None and flight.end is End.OUTLET])
    assert len(times) == count
    flown, expected = np.quantile(times, (0.05, 0.5, 0.95)), passage.quantiles[1]
    error = 3 * 1.25 * times.std() / np.sqrt(count)
    print(f"\n{length:g} m: flights {flown.round(1)}, route {expected.round(1)} s, standard error {error / 3:.2f} s")
    assert expected[1] == pytest.approx(flown[1], rel=0.004, abs=error)
    # From 5 to 95 % of a normal distribution there are 3.29 standard deviations.
    assert np.ptp(expected) == pytest.approx(3.29 * times.std(), rel=0.25, abs=3.29 * error)
