"""Fluids by name: density, viscosity and expansion at a stated temperature and pressure, with their sources."""

from dataclasses import dataclass


@dataclass(frozen=True)
class NamedFluid:
    """A fluid at one temperature and pressure.

    Attributes:
        density: kg/m3.
        viscosity: kinematic, m2/s.
        expansion: coefficient of thermal expansion, of the volume, 1/K.
        celsius: temperature of these, degrees C.
        state: what it is, with its temperature and its pressure where that is not 1 bar.
        source: of these numbers.
    """

    density: float
    viscosity: float
    expansion: float
    celsius: float
    state: str
    source: str


FLUIDS = {
    "fresh-water": NamedFluid(999.1, 1.14e-6, 1.51e-4, 15.0, "15 degrees C", "IAPWS 1995 and 2008"),
    "seawater": NamedFluid(
        1024.0, 1.05e-6, 2.57e-4, 20.0, "35 g/kg, 20 degrees C", "ITTC 7.5-02-01-03; expansion: TEOS-10"
    ),
    "brine": NamedFluid(
        1147.8,
        1.33e-6,
        4.11e-4,
        20.0,
        "20 % of sodium chloride by mass, 20 degrees C",
        "Melinder, Properties of Secondary Working Fluids (2010), in CoolProp (MNA)",
    ),
    "oil": NamedFluid(
        860.0, 1.0e-4, 7.53e-4, 22.0, "mineral oil, 22 degrees C: 100 cSt", "Texatherm 22, in CoolProp (TX22)"
    ),
    "methane-60bar": NamedFluid(
        45.2,
        2.68e-7,
        5.24e-3,
        15.0,
        "60 bar, 15 degrees C",
        "Setzmann and Wagner, J. Phys. Chem. Ref. Data 20 (1991), 1061; viscosity from CoolProp",
    ),
    "slurry": NamedFluid(
        1328.6,
        1.49e-6,
        1.73e-4,
        20.0,
        "water of 20 degrees C with a fifth of its volume of fine quartz (2650 kg/m3), as a Newtonian liquid",
        "Thomas, J. Colloid Sci. 20 (1965), 267: 1 + 2.5 c + 10.05 c^2 + 0.00273 exp(16.6 c) times the viscosity of water",
    ),
}
"""The fluids that a study may name."""


def find_water_density(celsius: float) -> float:
    """Return the density (kg/m3) of pure water at 1 bar and 0 to 100 degrees C.

    Kell, Journal of Chemical and Engineering Data 20 (1975), 97, equation 16.
    """
    top = 0.0
    for coefficient in (-280.54253e-12, 105.56302e-9, -46.170461e-6, -7.9870401e-3, 16.945176, 999.83952):
        top = top * celsius + coefficient
    return top / (1 + 16.879850e-3 * celsius)
