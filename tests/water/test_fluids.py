"""Fluids by name, and what a study makes of them."""

import math

import pytest

from driftform.study import load_study
from driftform.water import Fluid
from driftform.water.disturbances import disturb_fluid, draw_conditions
from driftform.water.fluids import FLUIDS
from driftform.water.scenario import Robustness


def test_a_fluid_replaces_the_water_of_the_scenario_that_a_study_is_based_on():
    fluid = load_study("pipe-inspection", ["fluid.name=oil"]).scenario.fluid
    assert (fluid.density, fluid.viscosity) == (860.0, 1e-4)
    assert load_study("pipe-inspection").scenario.fluid.density == 999.1


def test_the_fluid_of_a_disturbed_flight_keeps_its_own_density_when_it_is_read_again():
    (condition,) = draw_conditions(Robustness(), 1, (3,))
    disturbed = disturb_fluid(condition, Fluid(name="brine"))
    assert disturbed.density != FLUIDS["brine"].density
    assert Fluid.model_validate(disturbed.model_dump()) == disturbed


def test_the_slurry_is_the_formula_of_thomas():
    c, water, viscosity = 0.2, 998.2, 1.0016e-3
    density = water + c * (2650 - water)
    relative = 1 + 2.5 * c + 10.05 * c**2 + 0.00273 * math.exp(16.6 * c)
    assert FLUIDS["slurry"].density == pytest.approx(density, abs=0.1)
    assert FLUIDS["slurry"].viscosity == pytest.approx(relative * viscosity / density, rel=0.005)


def test_methane_is_denser_than_an_ideal_gas():
    # p M / (R T), and a compressibility factor of 0.9 at 60 bar (Setzmann and Wagner).
    ideal = 60e5 * 16.043e-3 / (8.314 * 288.15)
    assert FLUIDS["methane-60bar"].density == pytest.approx(ideal / 0.9, rel=0.03)


@pytest.mark.parametrize(
    ("celsius", "density"), [(5, 999.967), (10, 999.703), (15, 999.103), (20, 998.207), (30, 995.65)]
)
def test_fresh_water_has_the_density_of_the_tables_at_other_temperatures(celsius, density):
    # CRC Handbook, Standard Density of Water.
    water = load_study("pipe-inspection").scenario.fluid
    assert water.density_at(celsius) == pytest.approx(density, abs=0.02)
    assert Fluid(name="fresh-water").density_at(celsius) == water.density_at(celsius)


def test_seawater_has_the_density_of_its_equation_of_state_at_other_temperatures():
    # UNESCO 1981 at 35 g/kg: 1025.97 at 15, 1024.76 at 20, 1023.34 at 25 degrees C; ours has 1024 at 20.
    water = Fluid(name="seawater")
    assert water.density_at(25) - water.density_at(15) == pytest.approx(1023.343 - 1025.973, abs=0.05)


def test_oil_and_gas_expand_evenly():
    oil = Fluid(name="oil")
    assert oil.density_at(32) == pytest.approx(860 * (1 - 10 * 7.53e-4))
