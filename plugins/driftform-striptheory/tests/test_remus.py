"""A real vehicle: the added mass that Prestero published for REMUS 100, by the same theory.

T. Prestero, Verification of a six-degree of freedom simulation model for the REMUS autonomous underwater vehicle, MIT
2001. His derivatives are the negative of the added mass, about a point 0.611 m behind the nose.
"""

import numpy as np
import pytest
from solids import remus_body

from driftform.motion.forces.inertia import added_mass_at
from driftform.testing.bodies import make_body
from driftform.water import Fluid
from driftform_striptheory.coefficients import StripTheory, StripTheoryOptions

SEA = Fluid(density=1030.0)
"""Table A.1."""

FINS = (-0.685, -0.611)
"""x of the fins' ends, m: table A.2."""

TIP = 0.131
"""Height of the fins above the axis, m: figure 2-3. Table 2.2 has 5.14, which is that in inches."""

PUBLISHED = {"X_u'": -0.930, "Y_v'": -35.5, "N_v'": 1.93, "M_q'": -4.88}
"""Table C.5: kg, kg, kg m, kg m2."""


def finned():
    """The hull; along its fins, a hull that moves as much water as the real one with fins.

    A circle of radius r with four fins up to s moves per length as much as a circle of radius
    sqrt(s^2 - r^2 + r^4 / s^2) (Prestero, eq. 4.19, after Blevins).
    """
    x, r = remus_body(edges=400).outer.T
    along = np.linspace(*FINS, 200)
    hull = np.interp(along, x, r)
    moving = np.sqrt(TIP**2 - hull**2 + hull**4 / TIP**2)
    aft, fore = x < FINS[0], x > FINS[1]
    return make_body(
        [
            *zip(x[aft], r[aft], strict=True),
            (FINS[0], hull[0]),
            *zip(along, moving, strict=True),
            (FINS[1], hull[-1]),
            *zip(x[fore], r[fore], strict=True),
        ]
    )


def derivatives():
    """Those that were published, by strip theory: across the axis with fins, along it as the thesis has it, without."""
    model = StripTheory(StripTheoryOptions())
    across = added_mass_at(model.coefficients(finned(), SEA), np.zeros(3))
    along = model.coefficients(remus_body(), SEA).added_mass
    return {"X_u'": -along[0, 0], "Y_v'": -across[1, 1], "N_v'": -across[5, 1], "M_q'": -across[4, 4]}


@pytest.mark.parametrize("name", PUBLISHED)
def test_remus_100_has_the_published_added_mass(name):
    assert derivatives()[name] == pytest.approx(PUBLISHED[name], rel=0.02)


def test_the_hull_is_that_of_the_thesis():
    hull = remus_body(edges=200)
    volume = StripTheory(StripTheoryOptions()).coefficients(hull, Fluid(density=1.0)).added_mass[1, 1]
    assert hull.length == pytest.approx(1.33, abs=0.005)
    assert volume == pytest.approx(3.15e-2, rel=0.01), "table A.1"
    # Table A.2: the ends of the tail and of the middle body.
    middle = hull.outer[hull.outer[:, 1] > 0.0955 * (1 - 1e-9), 0]
    assert hull.outer[0, 0] == pytest.approx(-0.721, abs=1e-3)
    assert (middle.min(), middle.max()) == pytest.approx((-0.218, 0.437), abs=1e-3)


def test_the_page_shows_how_well_it_agrees(published):
    found = derivatives()
    published(
        "REMUS",
        [
            "| derivative | published | strip theory | off by |",
            "|---|---|---|---|",
            *(
                f"| {name} | {value} | {found[name]:.3f} | {100 * (found[name] / value - 1):+.1f} % |"
                for name, value in PUBLISHED.items()
            ),
        ],
    )
