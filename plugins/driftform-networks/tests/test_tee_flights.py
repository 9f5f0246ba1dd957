"""Streamtubes at a tee against flights through it.

By hand: ``pytest -m slow -s plugins/driftform-networks/tests/test_tee_flights.py``; with ``UPDATE_DOCS=1`` the table goes into
docs/networks.md.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from driftform.motion.forces.spheres import make_sphere
from driftform.types import End
from driftform.water import Scenario
from driftform_networks.flights.bodies import open_traveller
from driftform_networks.flights.bore import divide_bore, smallest_share, spread_points
from driftform_networks.flights.tees import BRANCH, HORIZON_BORES, Tee, describe_pipe, fly_tee

pytestmark = pytest.mark.slow

BORE, SPEED = 0.2, 0.5
"""Bore of the main, m, and mean speed, m/s."""

CASES = [(size, bore, share) for size in (0.05, 0.2) for bore in (0.5, 1.0) for share in (0.1, 0.3)]
"""Radius of the sphere over that of the main, bore of the branch over it, and the branch's share of the water."""

RINGS, AROUND = 7, 15
"""Releases: so many rings of so many, each for the same area of the bore."""


@dataclass(frozen=True)
class Comparison:
    """Shares of the spheres that enter the branch, and that are held at its downstream edge."""

    flown: float
    held: float
    divided: float


@pytest.fixture(scope="module")
def traveller():
    return open_traveller("sphere:10mm")


def compare(traveller, size, tee):
    """Fly neutral spheres from all over the bore, those nearest to the wall as near as they can be, with friction and for longer."""
    share, horizon = tee.share or 0.0, 2 * HORIZON_BORES * BORE / SPEED
    document = describe_pipe(traveller, tee) | {"flight": {"horizon": horizon}}
    document["contact"] = traveller.scenario.contact.model_dump()
    places = spread_points(1.0, RINGS, AROUND)
    # The thousandth keeps the releases off the wall.
    places = places * np.minimum(1.0, 0.999 * (1 - size) / np.linalg.norm(places, axis=1))[:, None]
    scenarios = [
        Scenario.model_validate(document | {"release": {"position": (BORE / 4, -right * BORE / 2, up * BORE / 2)}})
        for right, up in places.tolist()
    ]
    sphere = make_sphere(size * BORE, scenarios[0].fluid)
    flights = traveller.simulator.screen_batch([sphere] * len(places), scenarios, lambda _, __: False)
    [outlet] = [o for o in scenarios[0].pipe.layout.outlets if o.name == "branch"]
    held = np.array([flight.end == End.HORIZON for flight in flights])
    entered = [
        flight.end == End.OUTLET
        and np.linalg.norm(flight.position[-1] - outlet.opening.centre) < 1.5 * outlet.opening.radius
        for flight in flights
    ]
    assert all(flight.end in (End.OUTLET, End.HORIZON) for flight in flights)
    # The weight of a place is the speed of the water that passes it.
    weight = np.array([np.linalg.norm(flight.velocity[0, :3]) for flight in flights])
    weight /= weight.sum()
    divided = divide_bore(places, np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([1 - share, share]))[:, 1]
    return Comparison(float(weight @ entered), float(weight @ held), float(weight @ divided))


def test_spheres_take_the_branch_as_the_streamtubes_say_unless_they_are_wide_and_it_is_slow(traveller, publish):
    still = open_traveller("sphere:10mm", None, ("flow.kind=log_law",))
    lines = [
        "| radius of the sphere | bore of the branch | its share of the water | no entry below | streamtubes | flights without gusts | held at its edge | with gusts | held |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for size, bore, share in CASES:
        tee, sphere = Tee(BORE, SPEED, bore, 90.0, 90.0, share), make_sphere(size * BORE, traveller.scenario.fluid)
        found = compare(still, size, tee)
        (calm, _), (entered, held) = (
            (table[BRANCH].sum(), 1 - table.sum())
            for table in (fly_tee(replace(body, agent=sphere), tee, None).onward[0] for body in (still, traveller))
        )
        known = (smallest_share(size), found.divided, found.flown, found.held, entered, held)
        lines.append(f"| {size:g} | {bore:g} | {share:.0%} | {' | '.join(f'{abs(part):.1%}' for part in known)} |")
        if size < 0.1:
            assert found.flown == pytest.approx(found.divided, abs=0.05)
        else:
            # A wide sphere touches the downstream edge of a branch in which the water is slow, and is turned into the run.
            assert found.flown + found.held < found.divided + 0.03
        if (size, bore, share) == (0.2, 1.0, 0.1):
            assert found.flown < 0.02 and found.divided > 0.05
        # The tables of routes say what these flights do. Without friction, the spheres that the edge would hold move on, and
        # some of them enter the branch. Gusts change less than three standard errors.
        assert found.flown - 0.02 < calm < found.flown + found.held + 0.02
        assert entered == pytest.approx(calm, abs=0.03 + 3 * np.sqrt(share * (1 - share) / (RINGS * AROUND)))
    publish("streamtubes and flights", [line.replace("%", " %") for line in lines])
