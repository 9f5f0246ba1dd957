"""Morphology -> body: a chain of conical frustums around the core, with a wall, end caps and a dome."""

from typing import Literal

from pydantic import model_validator

from driftform.interfaces import PhenotypeBuilder
from driftform.options import Table, option
from driftform.types import Body, Core, Morphology
from driftform_frusta.section import build_chain, hull_section, join_chains, open_section


class FrustaOptions(Table):
    """Dimensions and materials of an agent; the defaults are the paper's."""

    core_radius: float = option(0.01, "radius of the core", "m", ge=1e-4, le=1)
    core_mass: float = option(0.05, "mass of the core", "kg", ge=0, le=1e4)
    wall: float = option(0.00125, "wall thickness of the hull", "m", ge=1e-5, le=1)
    hull_density: float = option(1050.0, "density of the hull's material (ABS)", "kg/m3", ge=1, le=30_000)
    clearance: float = option(0.0002, "gap between core and hull", "m", ge=0, le=1)
    min_radius: float = option(
        0.0025, "least radius of the chain, to the middle of its wall", "m", ge=1e-5, le=1
    )
    wall_model: Literal["mitred", "paper"] = option(
        "mitred",
        "'mitred': the wall is measured normal to itself and the ends are closed by caps; 'paper': radial "
        "thickness wall/cos(tilt) and ends without mass, which no printer can make",
    )

    @model_validator(mode="after")
    def _leaves_a_bore(self) -> "FrustaOptions":
        if self.wall_model == "mitred" and self.min_radius <= 1.5 * self.wall:
            raise ValueError(
                f"min_radius {self.min_radius} m must exceed 1.5 times the wall ({1.5 * self.wall:g} m), "
                "or the cavity pinches"
            )
        return self


class FrustaBuilder(PhenotypeBuilder[FrustaOptions]):
    """The outline is the union of the chains and of a dome over the core; the cavity is its inward offset by the wall.

    The dome has the radius core + clearance + wall, and both chains start tangent to it at the core's equator.
    """

    name = "frusta"
    Options = FrustaOptions

    def build(self, morphology: Morphology) -> Body:
        """Return the meridian section of the morphology."""
        o = self.options
        dome = o.core_radius + o.clearance + o.wall
        least = o.min_radius + o.wall / 2
        fore = build_chain(morphology.fore, dome, least)
        aft = build_chain(morphology.aft, dome, least)
        section = hull_section if o.wall_model == "mitred" else open_section
        outer, cavity = section(fore, aft, dome, o.wall)
        return Body(
            outer=outer,
            cavity=cavity,
            joints=join_chains(fore, aft)[:, 0],
            core=Core(o.core_radius, o.core_mass),
            wall=o.wall,
            hull_density=o.hull_density,
        )
