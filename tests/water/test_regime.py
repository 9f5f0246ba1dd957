"""The regime of a pipe: which profile it has, and what is said where a formula does not hold."""

import math

import numpy as np
import pytest

from driftform.study import load_study
from driftform.util.validity import RANGES, Range, find_departures
from driftform.water import Scenario
from driftform.water.field import water_velocity
from driftform.water.regime import entry_length, warn_of_regime

OIL = {"density": 870.0, "viscosity": 1e-4}


def pipe(kind, reynolds, length=5000.0, **flow):
    """A straight pipe of oil at a Reynolds number, of 0.1 m radius, or of 10 m above 1e5."""
    radius = 0.1 if reynolds <= 1e5 else 10.0
    speed = reynolds * OIL["viscosity"] / (2 * radius)
    segment = {"start": [0, 0, 0], "end": [length, 0, 0], "radius": radius}
    table = {"kind": kind, "speed": speed, **flow}
    return Scenario.model_validate({"pipe": {"segments": [segment]}, "flow": table, "fluid": OIL})


def test_developed_flow_is_a_parabola_below_2300_and_logarithmic_above():
    for reynolds in (10, 1000, 2299):
        calm = pipe("developed", reynolds)
        r = np.linspace(0, 0.1, 11)
        places = np.column_stack([np.ones(11), r, np.zeros(11)])
        velocity = water_velocity(places, 0.0, calm)
        assert velocity[:, 0] == pytest.approx(2 * calm.flow.speed * (1 - (r / 0.1) ** 2), abs=1e-12)
        assert not warn_of_regime(calm)
    for reynolds in (2301, 3000, 5000, 1e5):
        places = [[1.0, 0.02 * k, 0.0] for k in range(5)]
        pair = [water_velocity(places, 0.0, pipe(kind, reynolds)) for kind in ("developed", "log_law")]
        np.testing.assert_array_equal(*pair)


def test_laminar_flow_has_no_gusts_and_turbulent_flow_of_any_profile_has():
    table = {"always": True}
    for kind, reynolds, gusty in (
        ("developed", 2000, False),
        ("developed", 1e4, True),
        ("log_law", 1e4, True),
        ("power_law", 1e4, True),
        ("turbulent", 1e4, True),
        ("developing", 1e4, False),
        ("uniform", 1e4, False),
    ):
        scenario = pipe(kind, reynolds)
        scenario = Scenario.model_validate({**dict(scenario), "gusts": table})
        assert scenario.has_gusts == gusty, kind
        moved = water_velocity([1.0, 0.0, 0.0], 1.0, scenario, gusts=True)
        assert bool(np.any(moved != water_velocity([1.0, 0.0, 0.0], 1.0, scenario))) == gusty


@pytest.mark.parametrize(
    ("kind", "reynolds", "words"),
    [
        ("developed", 3000, ["Re_D = 3000", "the profile is unknown", "2300 to 4000", "logarithmic law is taken"]),
        ("log_law", 1000, ["Re_D = 1000", "from 4000 to 1e+08", "take flow.kind = 'developed'"]),
        ("log_law", 3000, ["Re_D = 3000", "from 4000"]),
        ("power_law", 1000, ["power law", "Re_D = 1000", "from 4000 to 3.24e+06"]),
        ("power_law", 5e6, ["power law", "Re_D = 5e+06", "to 3.24e+06"]),
        ("turbulent", 2000, ["Re_D = 2000", "from 4000"]),
    ],
)
def test_a_profile_outside_its_range_is_named_with_its_number_and_the_range(kind, reynolds, words):
    [line] = warn_of_regime(pipe(kind, reynolds))
    for word in words:
        assert word in line


def test_every_bore_of_a_junction_is_checked_at_its_own_speed():
    tee = {"kind": "tee", "branch_radius": 0.05, "share": 0.001, "branch": [{"length": 1.0, "outlet": "side"}]}
    parts = [{"length": 50.0}, tee, {"length": 1.0, "outlet": "main"}]
    scenario = Scenario.model_validate(
        {"pipe": {"radius": 0.1, "parts": parts}, "flow": {"kind": "log_law", "speed": 0.5}, "fluid": {}}
    )
    [line] = warn_of_regime(scenario)
    # 0.001 of the water in a quarter of the section: 2 mm/s.
    assert "0.1 m wide, 0.002 m/s" in line and "Re_D = 190.5" in line


def test_laminar_and_turbulent_bores_of_one_pipe_have_their_own_profiles():
    parts = [{"length": 4.0}, {"kind": "reducer", "length": 0.4, "radius": 0.04}, {"length": 4.0}]
    scenario = Scenario.model_validate(
        {
            "pipe": {"radius": 0.1, "parts": parts},
            "flow": {"kind": "developed", "speed": 0.01, "upstream": 100},
            "fluid": {"viscosity": 1e-6},
        }
    )
    wide, narrow = (water_velocity([x, 0.0, 0.0], 0.0, scenario)[0, 0] for x in (1.0, 7.0))
    assert wide == pytest.approx(2 * 0.01, rel=1e-9)
    assert 1.1 < narrow / (0.01 * 6.25) < 1.5


@pytest.mark.parametrize(("reynolds", "diameters"), [(1000, 60), (2000, 120), (4000, 17.5), (1e4, 20.4), (1e6, 44)])
def test_a_pipe_shorter_than_its_entry_length_is_named(reynolds, diameters):
    # The turbulent ones are those of White's table of eq. 6.6.
    entry, bore = entry_length(reynolds, reynolds < 2300), 0.2 if reynolds <= 1e5 else 20.0
    assert entry == pytest.approx(diameters, rel=0.01)
    [line] = warn_of_regime(pipe("developed", reynolds, length=0.99 * bore * entry))
    assert f"within {bore * entry:.3g} m" in line and "set flow.upstream" in line
    assert not warn_of_regime(pipe("developed", reynolds, length=1.01 * bore * entry))
    assert not warn_of_regime(pipe("developed", reynolds, length=bore, upstream=bore * entry))


@pytest.mark.parametrize("name", ["paper", "pipe-inspection", "t-junction"])
def test_the_built_in_pipes_are_within_all_ranges(name):
    assert not warn_of_regime(load_study(name).scenario)


def test_a_range_names_quantity_value_and_bounds():
    limit = Range("speed", "U", 1.0, math.inf, "", "", unit="m/s")
    assert limit.contains(1.0) and not limit.contains(0.9) and not limit.contains(math.nan)
    assert limit.describe() == "from 1 m/s"
    assert find_departures("logarithmic law", {"Re_D": 5e4}) == []
    assert find_departures("logarithmic law", {}) == []
    for ranges in RANGES.values():
        for limit in ranges:
            assert limit.low < limit.high and limit.source and limit.outside
