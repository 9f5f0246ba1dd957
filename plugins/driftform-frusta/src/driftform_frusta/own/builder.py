"""Your own body as an agent: a builder whose options are the whole body, and the grammar of its only genome."""

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from driftform.agent import solid_of_revolution
from driftform.errors import InputError
from driftform.interfaces import Grammar, PhenotypeBuilder, Table, option
from driftform.types import Body, Core, Fittings, FloatArray, Genome, Moments, Morphology

_Length = Annotated[float, Field(ge=0, le=1000)]
Profile = tuple[tuple[_Length, _Length], ...]
"""Distance from the nose and radius of each point of a profile, m."""

MIN_DENSITY, MAX_DENSITY = 0.01, 22_600.0
"""Bounds of a body's mean density, kg/m3: a thousandth of that of foam, and that of osmium (CRC Handbook: 22 590)."""

_Inertia = Annotated[float, Field(gt=0, le=1e12)]


class ProfileOptions(Table):
    """A body of revolution by its profile, mass and centre of gravity."""

    profile: Profile = option(
        ...,
        "distance from the nose and radius of each point, from the nose to the tail; both ends lie on the axis",
        "m",
    )
    mass: float = option(..., "mass of the whole body", "kg", gt=0, le=1e6)
    cog: float = option(..., "distance of the centre of gravity from the nose", "m", ge=0, le=1000)
    inertia: tuple[_Inertia, _Inertia] | None = option(
        None,
        "moments of inertia about the centre of gravity: about the axis, and about a line across it; by default those of a "
        "body of even density with this profile and mass",
        "kg m2",
    )

    @model_validator(mode="after")
    def _is_a_body(self) -> "ProfileOptions":
        x, r = check_profile(self.profile, self.cog)
        density = self.mass / solid_of_revolution(place_profile(np.array(self.profile))).volume
        if not MIN_DENSITY <= density <= MAX_DENSITY:
            raise ValueError(
                f"mass {self.mass:g} kg is {density:.3g} kg/m3 in a body {x[-1]:.4g} m long, possible are {MIN_DENSITY:g} to "
                f"{MAX_DENSITY:g}: is it {float(np.cbrt(density / 1000)):.2g} times as long, or the mass not in kg?"
            )
        # Mass at the two ends and on the rim: no body has more, and none less across than half of that around its axis.
        widest = self.mass * float(r.max()) ** 2
        longest = self.mass * float(self.cog * (x[-1] - self.cog)) + widest
        axial, transverse = self.inertia or (widest, longest)
        if not (0 < axial <= widest and axial / 2 <= transverse <= longest):
            raise ValueError(
                f"inertia [{axial:g}, {transverse:g}] kg m2 is not possible: about the axis at most {widest:.3g}, across it "
                f"from half of that about the axis to {longest:.3g}"
            )
        return self


def check_profile(profile: Profile, cog: float, prefix: str = "") -> tuple[FloatArray, FloatArray]:
    """Return x and r of a profile, m; a ValueError names the option that is wrong, after a prefix."""
    x, r = np.array(profile, dtype=np.float64).reshape(-1, 2).T
    if len(x) < 3 or x[0] != 0 or (np.diff(x) < 0).any() or r[0] != 0 or r[-1] != 0 or r[1:-1].min() <= 0:
        raise ValueError(
            f"{prefix}profile must run from the nose, [0, 0], to a point of the tail on the axis, with radii above 0"
        )
    if not cog <= x[-1]:
        raise ValueError(f"'{prefix}cog' is {cog:g} m from the nose, and the body {x[-1]:.4g} m long")
    return x, r


class ProfileBuilder(PhenotypeBuilder[ProfileOptions]):
    """The body of the options, for the genome of :class:`FixedGrammar`; its origin is the centre of buoyancy."""

    name = "profile"
    Options = ProfileOptions

    def build(self, morphology: Morphology) -> Body:
        """Return the body.

        The hull is the solid body at the density that gives the mass; the difference of its moments from those that are
        asked for is that of its fittings, and the core has neither size nor mass.
        A ValueError refuses modules.
        """
        if morphology.modules:
            raise ValueError("builder 'profile' has no modules: use it with grammar 'fixed'")
        o = self.options
        outer = place_profile(np.array(o.profile))
        solid = solid_of_revolution(outer)
        density, cog = o.mass / solid.volume, float(outer[-1, 0]) - o.cog
        axial, transverse = o.inertia or (density * solid.polar, density * solid.transverse)
        asked = Moments(
            volume=solid.volume,
            first=solid.volume * cog,
            second=(transverse - axial / 2) / density + solid.volume * cog**2,
            polar=axial / density,
        )
        return Body(
            outer=outer,
            cavity=np.empty((0, 2)),
            joints=outer[[0, -1], 0],
            core=Core(0.0, 0.0),
            wall=0.0,
            hull_density=density,
            fittings=Fittings(material=asked - solid),
        )


def place_profile(points: FloatArray) -> FloatArray:
    """Return the contour of a profile, from aft to fore with its centroid at the origin: x and r, m, (n, 2).

    ``points`` are distance from the nose and radius, m, (n, 2).
    """
    contour = points[::-1] * [-1.0, 1.0]
    contour[:, 0] -= solid_of_revolution(contour).centroid
    return np.asarray(contour)


class FixedGrammar(Grammar[Table]):
    """The grammar of a body that does not grow: its only genome has no symbols, and no modules."""

    name = "fixed"

    def random(self, rng: np.random.Generator) -> Genome:
        """Return the only genome."""
        return Genome(self.name, ())

    def plain(self) -> Genome:
        """Return the only genome."""
        return Genome(self.name, ())

    def flip(self, genome: Genome, index: int, rng: np.random.Generator) -> Genome:
        """Return the genome: there is nothing to replace."""
        return genome

    def crossover(self, a: Genome, b: Genome, rng: np.random.Generator) -> tuple[Genome, Genome]:
        """Return the parents, which are the same."""
        return a, b

    def express(self, genome: Genome) -> Morphology:
        """Return no modules."""
        if genome.grammar != self.name or genome.symbols:
            raise ValueError(f"the only genome of grammar '{self.name}' has no symbols")
        return Morphology()

    def to_text(self, genome: Genome) -> str:
        """Return the name of the grammar, for its only genome."""
        return self.name

    def parse(self, text: str) -> Genome:
        """Read the name of the grammar."""
        if text.strip() != self.name:
            raise InputError(f"a body that does not grow has one genome: '{self.name}'")
        return Genome(self.name, ())
