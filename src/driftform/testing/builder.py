"""Contract of builders."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.agent import distance_from, mass_properties, solid_of_revolution
from driftform.interfaces import PhenotypeBuilder
from driftform.plugins.seams import require_body
from driftform.testing.bodies import crosses_itself, lies_inside, mirrored_contour
from driftform.testing.contract import AnsweringContract, Question
from driftform.types import Body, Module, Morphology


def random_morphology(seed: int, count: int = 39) -> Morphology:
    """Return modules with the paper's lengths and tilts, on either side of the core."""
    rng = np.random.default_rng(seed)
    lengths = rng.choice([0.0025, 0.005, 0.01], size=count)
    tilts = np.deg2rad(rng.choice([-20, -10, 0, 10, 20], size=count))
    modules = [Module(float(length), float(tilt)) for length, tilt in zip(lengths, tilts, strict=True)]
    cut = int(rng.integers(count + 1))
    return Morphology(fore=tuple(modules[:cut]), aft=tuple(modules[cut:]))


def _run(count: int, tilt_deg: float, length: float = 0.01) -> tuple[Module, ...]:
    return (Module(length, float(np.deg2rad(tilt_deg))),) * count


MORPHOLOGIES: dict[str, Callable[[], Morphology]] = {
    "no module": Morphology,
    "one module": lambda: Morphology(fore=_run(1, 10)),
    "one short module aft": lambda: Morphology(aft=_run(1, 0, 0.0025)),
    "all fore": lambda: Morphology(fore=_run(12, 5)),
    "all aft": lambda: Morphology(aft=_run(12, -5)),
    "all narrowing": lambda: Morphology(fore=_run(20, -20), aft=_run(19, -20)),
    "all widening": lambda: Morphology(fore=_run(20, 20), aft=_run(19, 20)),
    "zigzag": lambda: Morphology(fore=(*_run(1, 20), *_run(1, -20)) * 5, aft=(*_run(1, -20), *_run(1, 20)) * 5),
    **{f"39 random modules ({seed})": partial(random_morphology, seed) for seed in range(6)},
}

every_morphology = pytest.mark.parametrize("kind", MORPHOLOGIES)


class BuilderContract(AnsweringContract[PhenotypeBuilder[Any]]):
    """The contract of builders.

    Attributes:
        slack: greatest distance (m) of two points that should coincide: the resolution of the builder's geometry.
    """

    slack: ClassVar[float] = 2e-7

    def questions(self) -> Sequence[Question]:
        """Return the body of each morphology."""
        return [("build", make()) for make in MORPHOLOGIES.values()]

    def build(self, kind: str) -> Body:
        """Return the body of one of the morphologies."""
        builder = self.plugin()
        return require_body(builder.build(MORPHOLOGIES[kind]()), builder)

    @every_morphology
    def test_contours_run_from_the_axis_to_the_axis(self, kind: str) -> None:
        """Outer contour and cavity start at the aft axis point, end at the fore one, never go below it or cross themselves.

        Joints are in order, and lie between the ends of the body.
        """
        body = self.build(kind)
        assert all(a <= b for a, b in pairwise(body.joints))
        assert body.outer[:, 0].min() - self.slack <= body.joints[0]
        assert body.joints[-1] <= body.outer[:, 0].max() + self.slack
        assert not any(crosses_itself(contour) for contour in (body.outer, body.cavity))
        assert body.max_diameter > 0

    @every_morphology
    def test_the_cavity_lies_inside_the_outer_contour(self, kind: str) -> None:
        """No vertex of the cavity lies outside the outer contour, no outer vertex inside the cavity; the hull has a volume."""
        body = self.build(kind)
        if not len(body.cavity):
            return
        assert lies_inside(body.cavity, body.outer, self.slack).all()
        off_axis = body.outer[body.outer[:, 1] > 0]
        deep = distance_from(off_axis, body.cavity) > self.slack
        assert not lies_inside(off_axis[deep], body.cavity, 0.0).any()
        outside, hole = solid_of_revolution(body.outer).volume, solid_of_revolution(body.cavity).volume
        assert 0 < hole < outside

    @every_morphology
    def test_the_core_fits_in_the_cavity(self, kind: str) -> None:
        """The core does not overlap a wall; in a solid body it lies within the hull."""
        body = self.build(kind)
        room = body.cavity if len(body.cavity) else body.outer
        assert room[0, 0] < 0 < room[-1, 0]
        if body.core.contour:
            assert lies_inside(np.array(body.core.contour[1:-1]), room, self.slack).all()
        else:
            assert distance_from(np.zeros((1, 2)), room)[0] >= body.core.radius

    @every_morphology
    def test_mass_properties_are_those_of_a_body(self, kind: str) -> None:
        """Mass, volume and moments of inertia are positive and physically possible; COG and COB lie within the body."""
        body = self.build(kind)
        properties = mass_properties(body)
        assert np.isfinite(properties.inertia).all()
        assert properties.mass > 0 and properties.volume > 0
        roll, pitch, yaw = np.linalg.eigvalsh(properties.inertia)
        assert roll > 0 and roll + pitch >= yaw * (1 - 1e-12)
        for point in (properties.cog, properties.cob):
            assert body.outer[:, 0].min() < point[0] < body.outer[:, 0].max()
            assert point[1] == point[2] == 0.0

    @every_morphology
    def test_a_tuning_changes_the_weight_and_not_the_outer_contour(self, kind: str) -> None:
        """Within the bounds that :meth:`find_tunings` returns, the mass changes steadily, by the same for the same step."""
        builder, morphology = self.plugin(), MORPHOLOGIES[kind]()
        if (bounds := builder.find_tunings(morphology)) is None:
            return
        low, high = bounds
        assert low <= high
        tuned = (replace(morphology, tuning=low + share * (high - low)) for share in (0.0, 0.5, 1.0))
        bodies = [require_body(builder.build(each), builder) for each in tuned]
        assert all(np.array_equal(body.outer, bodies[0].outer) for body in bodies)
        masses = [mass_properties(body).mass for body in bodies]
        steps = np.diff(masses)
        assert high == low or (np.all(steps > 0) or np.all(steps < 0))
        assert steps[0] == pytest.approx(steps[1], rel=0.2)

    @every_morphology
    def test_a_mirrored_morphology_gives_a_mirrored_body(self, kind: str) -> None:
        """Fore and aft are equivalent: exchanging the modules exchanges the ends of the body."""
        morphology = MORPHOLOGIES[kind]()
        there = self.plugin().build(morphology)
        back = self.plugin().build(Morphology(fore=morphology.aft, aft=morphology.fore))
        for a, b in ((there.outer, back.outer), (there.cavity, back.cavity)):
            m = mirrored_contour(a)
            assert len(a) == len(b) == 0 or max(*distance_from(m, b), *distance_from(b, m)) <= self.slack
        np.testing.assert_allclose(-there.joints[::-1], back.joints, atol=self.slack)

    def test_modules_make_the_body_longer(self) -> None:
        """Twelve modules of 10 mm on either side move that end of the body outward, by at most one and a half times as much."""
        bare, fore, aft = self.build("no module"), self.build("all fore"), self.build("all aft")
        assert 0 < fore.outer[-1, 0] - bare.outer[-1, 0] < 0.18
        assert 0 < bare.outer[0, 0] - aft.outer[0, 0] < 0.18
