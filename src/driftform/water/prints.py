"""A body as it was printed, weighed and trimmed, and as it is in the water then."""

from dataclasses import replace

from driftform.agent.distance import offset_contour
from driftform.agent.mass import hull_mass, mass_properties
from driftform.types import Body
from driftform.water import Fluid
from driftform.water.disturbances import Condition, Specimen, disturb_fluid


def disturb_body(condition: Condition, body: Body, fluid: Fluid) -> Body:
    """Return a body under a disturbed condition: mass, volume and both centres are those in flight.

    What lies outside the design moves the wall's surfaces along their normals. What is weighed and trimmed has the
    right net weight, in water or in air, but for what no scale shows; the difference lies at the core, and the
    balance is that of the print.

    Args:
        body: as designed.
        fluid: that of the scenario, for which it is designed.
    """
    made = _print(condition, body)
    there, water = _immerse(condition, made), disturb_fluid(condition, fluid).density
    wet, bubble = condition.absorbed * hull_mass(made), fluid.density * condition.bubble
    if condition.specimen in (Specimen.WEIGHED, Specimen.BASELINE):
        design, volume = mass_properties(body), mass_properties(there).volume
        # What the body displaces in flight more than the maker expects, by thermometers and by data sheets, relative to it.
        there_at, read_at = fluid.celsius + condition.warmer, fluid.celsius + condition.warmer + condition.read
        unknown = 3 * body.expansion * (condition.expanded * condition.warmer - condition.warmer - condition.read)
        unknown += (fluid.density_at(there_at) - fluid.density_at(read_at)) / fluid.density
        unknown += (1 - condition.squeezed) * body.squeeze
        net = design.mass - fluid.density * design.volume * (1 + unknown)
        extra = net + condition.left + wet - bubble + water * volume - mass_properties(made).mass
    elif condition.specimen is Specimen.WEIGHED_IN_AIR:
        extra = mass_properties(body).mass + condition.left + wet - abs(bubble) - mass_properties(made).mass
    else:
        extra = wet - abs(bubble)
    # Your own body has no core, and may lack ballast.
    core = replace(body.core, mass=body.core.mass + max(extra, -body.core.mass or extra))
    return replace(there, core=core)


def _print(condition: Condition, body: Body) -> Body:
    """Return the body as printed."""
    outer = offset_contour(body.outer, condition.outside)
    # Your own body may have a given mass, and no wall.
    cavity = offset_contour(body.cavity, -condition.wall if body.wall else 0.0)
    made = replace(body, outer=outer, cavity=cavity, hull_density=body.hull_density * condition.mass)
    return _scale(made, condition.scale)


def _immerse(condition: Condition, body: Body) -> Body:
    """Return the same body at the temperature and under the pressure of its flight, at the same mass."""
    factor = 1 + body.expansion * condition.expanded * condition.warmer
    hull = replace(body, hull_density=body.hull_density / factor**3, squeeze=condition.squeezed * body.squeeze)
    return _scale(hull, factor)


def _scale(body: Body, factor: float) -> Body:
    """Return the body with all lengths of its hull multiplied by a factor, those of its fittings too."""
    outer, cavity = factor * body.outer, factor * body.cavity
    return replace(body, outer=outer, cavity=cavity, fittings=body.fittings.scale(factor))
