"""Contract of models of hydrodynamic coefficients."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.interfaces import Hydrodynamics
from driftform.motion.forces.inertia import added_mass_at
from driftform.plugins.seams import require_coefficients
from driftform.testing.agents import Spheroid
from driftform.testing.bodies import (
    cylinder_body,
    dome_body,
    hollow_body,
    make_body,
    mirrored_body,
    scaled_body,
    spheroid_body,
)
from driftform.testing.contract import AnsweringContract, Question
from driftform.types import Body, Coefficients, FloatArray
from driftform.water import Fluid

BODIES: dict[str, Callable[[], Body]] = {
    "sphere": lambda: spheroid_body(0.01, 0.01),
    "nearly a sphere": lambda: spheroid_body(0.0101, 0.01),
    "long spheroid": lambda: spheroid_body(0.1, 0.01),
    "long cylinder": lambda: cylinder_body(0.3, 0.01),
    "disc": lambda: cylinder_body(0.02, 0.05),
    "flat spheroid": lambda: spheroid_body(0.01, 0.04),
    "bare dome": lambda: dome_body(0.0115),
    "cone off the origin": lambda: make_body([(0.02, 0), (0.02, 0.03), (0.12, 0)]),
    "hollow hull": hollow_body,
}

every_body = pytest.mark.parametrize("kind", BODIES)

# A mirror image across the y-z plane reverses surge, and the rotations about y and z, which are axial vectors.
MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])


class HydrodynamicsContract(AnsweringContract[Hydrodynamics[Any]]):
    """The contract of models of hydrodynamic coefficients.

    Attributes:
        tolerance: relative difference up to which two coefficients count as equal: the error of the method's
            arithmetic, not of its physics.
        excess: factor up to which an approximate model may exceed what energy allows.
    """

    tolerance: ClassVar[float] = 1e-6
    excess: ClassVar[float] = 1.0

    def questions(self) -> Sequence[Question]:
        """Return the coefficients of each body."""
        return [("coefficients", make(), Fluid()) for make in BODIES.values()]

    def coefficients(self, body: Body, fluid: Fluid) -> Coefficients:
        """Return the coefficients of a body."""
        model = self.plugin()
        return require_coefficients(model.coefficients(body, fluid), body, model)

    def added_mass_about_origin(self, body: Body, fluid: Fluid | None = None) -> FloatArray:
        """Return the added mass about the body frame's origin, (6, 6)."""
        return added_mass_at(self.coefficients(body, fluid or Fluid()), np.zeros(3))

    def assert_close(self, actual: FloatArray, expected: FloatArray, length: float) -> None:
        """Compare two 6x6 matrices in units in which their blocks are of similar size; ``length`` is in m."""
        scale = np.array([1.0, 1.0, 1.0, length, length, length])
        unit = float(np.abs(expected / np.outer(scale, scale)).max())
        np.testing.assert_allclose((actual - expected) / np.outer(scale, scale) / unit, 0, atol=self.tolerance)

    @every_body
    def test_translation_in_any_direction_moves_water(self, kind: str) -> None:
        """The added mass is finite, symmetric and semi-definite; in surge, sway and heave positive, also for a disc or a core."""
        assert (np.diag(self.added_mass_about_origin(BODIES[kind]()))[:3] > 0).all()

    @every_body
    def test_added_mass_is_proportional_to_the_density_of_the_fluid(self, kind: str) -> None:
        """Twice the density gives twice the added mass; gravity does not matter."""
        body = BODIES[kind]()
        once = self.added_mass_about_origin(body, Fluid(density=1000.0, gravity=9.81))
        twice = self.added_mass_about_origin(body, Fluid(density=2000.0, gravity=1.62))
        self.assert_close(twice, 2 * once, body.length)

    @every_body
    def test_an_axisymmetric_body_has_axisymmetric_coefficients(self, kind: str) -> None:
        """Sway equals heave, pitch equals yaw, M35 = -M26, and no other pair of motions is coupled."""
        body = BODIES[kind]()
        coefficients = self.coefficients(body, Fluid())
        assert coefficients.origin[1] == coefficients.origin[2] == 0.0
        m = self.added_mass_about_origin(body)
        expected = np.diag([m[0, 0], m[1, 1], m[1, 1], m[3, 3], m[5, 5], m[5, 5]])
        expected[1, 5] = expected[5, 1] = m[1, 5]
        expected[2, 4] = expected[4, 2] = -m[1, 5]
        self.assert_close(m, expected, body.length)

    @every_body
    def test_a_mirrored_body_has_a_mirrored_matrix(self, kind: str) -> None:
        """About the mirrored origin M26 and M35 change sign, and nothing else changes."""
        body = BODIES[kind]()
        expected = MIRROR @ self.added_mass_about_origin(body) @ MIRROR
        self.assert_close(self.added_mass_about_origin(mirrored_body(body)), expected, body.length)

    @every_body
    def test_a_similar_body_has_similar_coefficients(self, kind: str) -> None:
        """Potential flow has no length scale: masses grow with the third power of the size, moments of inertia with the fifth."""
        body = BODIES[kind]()
        scale = np.diag([1.0, 1.0, 1.0, 3.0, 3.0, 3.0])
        expected = 27 * scale @ self.added_mass_about_origin(body) @ scale
        self.assert_close(self.added_mass_about_origin(scaled_body(body, 3.0)), expected, 3 * body.length)

    @every_body
    def test_damping_takes_energy_and_never_gives_any(self, kind: str) -> None:
        """For any velocity the power of the damping forces is negative or zero."""
        coefficients = self.coefficients(BODIES[kind](), Fluid())
        for nu in np.random.default_rng(0).normal(size=(200, 6)):
            drag = coefficients.linear_damping @ nu + coefficients.quadratic_damping @ (np.abs(nu) * nu)
            assert np.isfinite(drag).all()
            assert nu @ drag >= 0.0

    def test_a_cavity_changes_nothing(self) -> None:
        """The water meets the outer contour only: a sealed cavity does not change the coefficients."""
        hollow = hollow_body()
        np.testing.assert_array_equal(
            self.added_mass_about_origin(hollow), self.added_mass_about_origin(make_body(hollow.outer))
        )

    @every_body
    def test_a_body_elsewhere_on_the_axis_has_the_same_added_mass(self, kind: str) -> None:
        """About the same point of the body, wherever the origin of its frame: ``origin`` is the point that matrices refer to."""
        body, x = BODIES[kind](), np.array([0.05, 0.0, 0.0])
        contours = [c + x[:2] if len(c) else c for c in (body.outer, body.cavity)]
        moved = replace(body, outer=contours[0], cavity=contours[1], joints=body.joints + x[0])
        there = added_mass_at(self.coefficients(moved, Fluid()), x)
        self.assert_close(there, self.added_mass_about_origin(body), body.length)

    @every_body
    def test_no_motion_moves_more_water_than_that_of_a_spheroid_around_the_body(self, kind: str) -> None:
        """Kelvin: of all motions of the water that fit the body, potential flow has the least energy (Lamb, section 45).

        Water that fills the gap to the spheroid and moves with the body is another such motion. So the added mass is at
        most that of a spheroid around the body and the water that it displaces.
        """
        body, fluid = BODIES[kind](), Fluid()
        radius = math.sqrt(0.5) * body.max_diameter
        spheroid = Spheroid(max(math.sqrt(0.5) * body.length, 1.001 * radius), radius)
        k1, k2, turning = spheroid.factors
        mass = fluid.density * spheroid.volume
        inertia = 0.2 * mass * (spheroid.a**2 + spheroid.b**2)
        middle = np.array([0.5 * (body.outer[0, 0] + body.outer[-1, 0]), 0.0, 0.0])
        found = np.diag(added_mass_at(self.coefficients(body, fluid), middle))[[0, 2, 4]]
        most = np.array([(1 + k1) * mass, (1 + k2) * mass, (1 + turning) * inertia])
        assert (found <= self.excess * most).all()
