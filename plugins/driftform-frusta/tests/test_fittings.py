"""What is fitted to a hull weighs, displaces and turns as its solid does, and one of revolution is a part of the outline."""

import math

import numpy as np
import pytest
from prints import chain_body, weigh_meshes

from driftform.agent import MassElement, mass_properties
from driftform.errors import WorkFailedError
from driftform.interfaces import Fitting, Table
from driftform.testing import FittingContract
from driftform.types import Agent, Coefficients
from driftform_frusta.csg import MM, Revolve, Rotate, Translate
from driftform_frusta.eyelet import Eyelet, EyeletOptions
from driftform_frusta.fittings import fit_hull
from driftform_frusta.kit_options import PartOptions

TUBE = chain_body("sss", "sss")


class TestContract(FittingContract):
    def plugin(self) -> Eyelet:
        return Eyelet(EyeletOptions(end="aft"))


class Made(Fitting[Table]):
    """A fitting of these trees."""

    name = "made"

    def __init__(self, *trees):
        super().__init__(Table())
        self.draw = lambda body: trees


Made.__abstractmethods__ = frozenset()


def bar(radius: float, low: float, high: float, z: float = 25.0):
    """A bar across the axis, mm."""
    upright = Revolve(((0.0, low), (radius, low), (radius, high), (0.0, high)))
    return Translate((0.0, 0.0, z), Rotate((0.0, 90.0, 0.0), upright))


def ring(inner: float, outer: float, low: float, high: float) -> Revolve:
    return Revolve(((inner, low), (outer, low), (outer, high), (inner, high)))


POCKET = Made(bar(4.2, 5.0, 10.5), bar(3.0, 6.2, 20.0))
"""A pocket in the side, with its wall inside."""


@pytest.mark.parametrize("fitting", [Eyelet(EyeletOptions(diameter=0.02, thickness=0.004)), POCKET])
def test_a_body_with_a_fitting_weighs_balances_and_turns_as_its_mesh(fitting):
    body = fit_hull(TUBE, [fitting])
    found = mass_properties(body)
    mass, cog, inertia = weigh_meshes(body, PartOptions())
    assert found.mass == pytest.approx(mass, rel=1e-6)
    assert found.cog == pytest.approx(cog, abs=1e-8)
    assert found.inertia == pytest.approx(inertia, abs=1e-5 * inertia.max())
    assert found.mass - mass_properties(TUBE).mass == pytest.approx(
        body.hull_density * body.fittings.details[0].moments.volume, rel=1e-6
    )


def test_water_in_a_pocket_is_not_displaced_and_the_sensor_s_side_is_the_heavy_one():
    bare, body = mass_properties(TUBE), fit_hull(TUBE, [POCKET])
    found = mass_properties(body)
    radius = MM * TUBE.max_diameter / 2
    bore = math.pi * 3.0**2 * (radius - 6.2) / MM**3
    assert bare.volume - found.volume == pytest.approx(bore, rel=0.05)
    assert found.cog[1] > 0 and found.cob[1] < 0 and found.cob[0] < bare.cob[0]
    assert abs(found.inertia[0, 1]) > 1e-9
    # A trimmed print keeps what is on its side.
    agent = Agent(body, found, Coefficients(np.eye(6)))
    heavier = MassElement.reweigh(agent, [MassElement.of_agent(agent), MassElement(0.01, 0.0)]).mass
    assert heavier.cog[1] * heavier.mass == pytest.approx(found.cog[1] * found.mass)


def test_a_collar_is_a_part_of_the_outline():
    radius = MM * TUBE.max_diameter / 2
    body = fit_hull(TUBE, [Made(ring(radius - 1, radius + 2, 20.0, 24.0), None)])
    assert body.fittings.details == () and body.max_diameter == pytest.approx(TUBE.max_diameter + 0.004)
    collar = math.pi * ((radius + 2) ** 2 - radius**2) * 4.0 / MM**3
    bare, found = mass_properties(TUBE), mass_properties(body)
    assert found.volume - bare.volume == pytest.approx(collar, rel=1e-5)
    assert found.mass - bare.mass == pytest.approx(collar * TUBE.hull_density, rel=1e-5)
    assert weigh_meshes(body, PartOptions())[0] == pytest.approx(found.mass, rel=1e-6)


@pytest.mark.parametrize(
    ("trees", "message"),
    [
        ((None, bar(3.0, 0.0, 20.0)), "opens or divides"),
        ((bar(3.0, 40.0, 50.0), None), "does not touch"),
        ((bar(3.0, 0.0, 11.0, 0.0), None), "takes the place of the core"),
        ((ring(0.0, 12.0, 100.0, 110.0), None), "does not touch"),
        ((ring(11.0, 12.0, 25.0, 60.0), None), "undercut"),
        ((None, ring(9.0, 20.0, 20.0, 22.0)), "opens or divides"),
        (("hull", None), "draws .'hull', None., not two trees"),
    ],
)
def test_a_fitting_that_cannot_be_is_refused_by_its_name(trees, message):
    with pytest.raises(WorkFailedError, match=f"fitting 'made' .*{message}"):
        fit_hull(TUBE, [Made(*trees)])


def test_an_eyelet_keeps_out_of_a_trim_pocket():
    body = chain_body("ssssss", "ssssss", pockets={"diameter": 0.005})
    assert body.pockets
    with pytest.raises(WorkFailedError, match="'eyelet' takes the place of the core or of a trim pocket"):
        fit_hull(body, [Eyelet(EyeletOptions())])
