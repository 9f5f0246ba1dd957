"""Morphology -> body: a chain of conical frustums around the core, with a wall, end caps and a dome."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import field_validator, model_validator

from driftform.agent import mass_properties, solid_of_revolution
from driftform.errors import InputError, WorkFailedError
from driftform.interfaces import PhenotypeBuilder, Printer, Table, option
from driftform.types import Body, Core, Fittings, FloatArray, Module, Morphology
from driftform.water import Fluid
from driftform_frusta.cores import CORES, CUSTOM, DENSITIES, DIAMETERS_MM, BallastOptions
from driftform_frusta.fitting_choice import FittingChoice
from driftform_frusta.kit_options import KitOptions
from driftform_frusta.load import LESS, SPARE, WATER, Load, find_max_ballast, list_loads, name_ball, place_ballast
from driftform_frusta.materials import MATERIALS, find_expansion, find_material
from driftform_frusta.own.builder import Profile, check_profile
from driftform_frusta.pockets import PocketOptions, clear_cavity, place_pockets
from driftform_frusta.section import draw_capsule, draw_room, hull_section, lay_chains, open_section
from driftform_frusta.strength import describe_strength, list_parts, thicken_ends

_PAPERS = Core(radius=0.01, mass=0.05)
"""The paper's core."""


KEPT_BODIES = 256
"""Bodies that are kept: a search asks for the same shape with many tunings."""

MAX_SLENDERNESS = 20.0
"""Largest plain body that is tried: its length over its width, or its width over that of the dome over the core."""

MIN_SPARE = 0.02
"""Share of what it displaces by which a plain body must be lighter: it then has room for any net weight in use."""

_ROUNDING = 1e-9
"""kg: rounding of sums of masses is less than this."""


_PRESSURE = """gauge pressure, such as 3e5 in a main; each hull then has the least wall of whole `line_width`s, in place of `wall`, \
and plates at its ends, that withstand `safety` times this; 0: not asked for"""


class FrustaOptions(Table):
    """Dimensions and materials of an agent; the defaults are the paper's."""

    core: str = option(
        CUSTOM,
        "a ball by material and diameter, such as steel-20mm; 'custom' for core_radius and core_mass; or the file of the "
        "profile of a capsule, as 'driftform body' reads it, for core_mass and core_cog, a relative path from the folder of "
        "the study file; materials: "
        f"{', '.join(DENSITIES)}; diameters: {', '.join(map(str, DIAMETERS_MM))} mm",
    )
    core_radius: float = option(_PAPERS.radius, "radius of a custom core", "m", ge=1e-4, le=1)
    core_mass: float = option(_PAPERS.mass, "mass of a custom core or a capsule", "kg", ge=0, le=1e4)
    core_cog: float | None = option(
        None, "distance of a capsule's centre of gravity from its nose, which is fore", "m", ge=0, le=1000
    )
    core_profile: Profile = option(
        (), "of a capsule, from its file: distance from the nose and radius of each point", "m", max_length=1000
    )
    wall: float = option(0.00125, "wall thickness of the hull", "m", ge=1e-5, le=1)
    material: Literal["custom", "ABS", "ASA", "PLA", "PETG", "PA12", "resin"] = option(
        CUSTOM, "material of the hull, which sets its density, or 'custom' for hull_density"
    )
    hull_density: float = option(1050.0, "density of the hull's material (ABS)", "kg/m3", ge=1, le=30_000)
    clearance: float = option(0.0002, "gap between core and hull", "m", ge=0, le=1)
    min_radius: float = option(0.0025, "minimum radius of the chain, to the middle of its wall", "m", ge=1e-5, le=1)
    max_radius: float = option(
        0.0, "maximum outer radius of the chain, such as half of `release.port`; 0: none", "m", ge=0, le=10
    )
    wall_model: Literal["mitred", "paper"] = option(
        "mitred",
        "'mitred': the wall is measured normal to itself and the ends are closed by caps; 'paper': radial "
        "thickness wall/cos(tilt) and ends without mass, which no printer can make",
    )
    made_as: Literal["hull", "kit"] = option(
        "hull",
        "what is weighed: 'hull', the sealed hull in one piece; 'kit', the parts of a kit, with their joints and "
        "seats, as the exporters cut it with the same options",
    )
    kit: KitOptions | None = option(None, "options of that kit, the same as those of the exporters")
    tuning: Literal["none", "ballast", "wall"] = option(
        "none",
        "what a search adjusts after the shape, as mass (kg) that is added: 'wall', by a narrower cavity, and by a ball of "
        "ballast beside the core if that is not enough; 'ballast', by such a ball, and a narrower cavity for the rest",
    )
    thinnest: float = option(
        0.0008,
        "minimum thickness of the wall, if tuning = 'wall', where a thinner wall takes mass away, or under `pressure`",
        "m",
        ge=1e-5,
        le=1,
    )
    ballast: BallastOptions = option(BallastOptions(), "ballast that may be added")
    pockets: PocketOptions = option(PocketOptions(), "trim pockets")
    fittings: tuple[FittingChoice, ...] = option(
        (), "what is fitted to the hull, each by the name of its plugin, `use`, and its options, such as an eyelet"
    )
    pressure: float = option(0.0, _PRESSURE, "Pa", ge=0, le=1e8)
    safety: float = option(2.0, "factor on `pressure`", ge=1, le=100)
    line_width: float = option(Printer().nozzle, "width of a printed line, that of the nozzle", "m", ge=1e-5, le=0.01)

    @field_validator("core")
    @classmethod
    def _is_known(cls, name: str) -> str:
        if name != CUSTOM and name not in CORES:
            close = get_close_matches(name, CORES, n=1)
            hint = f"did you mean '{close[0]}'? " if close else ""
            raise ValueError(
                f"core '{name}' is not known; {hint}there are '{CUSTOM}', and balls of {', '.join(DENSITIES)} with "
                f"{', '.join(map(str, DIAMETERS_MM))} mm, such as 'steel-20mm', and files, such as 'capsule.csv'"
            )
        return name

    @model_validator(mode="before")
    @classmethod
    def _fill_in(cls, values: Any) -> Any:
        if isinstance(values, Mapping):
            for fill_in in _FILLING_IN:
                values = fill_in(dict(values))
        return values

    @model_validator(mode="after")
    def _has_a_capsule(self) -> "FrustaOptions":
        if not self.core_profile and self.core_cog is None:
            return self
        if not self.core_profile:
            raise ValueError("'core_cog' is for a capsule: set core to the file of its profile, or leave it out")
        if self.core_cog is None:
            raise ValueError("'core_profile' is that of a capsule, whose core_cog is missing: add it")
        check_profile(self.core_profile, self.core_cog, "core_")
        if self.core_radius != (widest := max(r for _, r in self.core_profile)):
            raise ValueError(f"'core_radius' of this capsule is {widest:g} m, from its profile: leave it out")
        return self

    @model_validator(mode="after")
    def _go_together(self) -> "FrustaOptions":
        if self.made_as == "hull" and self.kit is not None:
            raise ValueError("kit has options, but made_as is 'hull': set made_as to 'kit', or leave them out")
        if self.kit is not None and self.kit.ballast:
            raise ValueError(
                "kit.ballast is for the kit of one agent, and a builder makes many: set it for the exporter"
            )
        if self.made_as == "kit" and self.wall_model == "paper":
            raise ValueError(
                "made_as is 'kit', but no kit can be made of the open ends of wall_model 'paper': set it to 'mitred'"
            )
        if self.pressure and self.wall_model == "paper":
            raise ValueError("wall_model 'paper' withstands no pressure, as its ends are open: set it to 'mitred'")
        if self.pockets.diameter and self.wall_model == "paper":
            raise ValueError("wall_model 'paper' has open ends, which take no trim pockets: set it to 'mitred'")
        if self.pressure and find_material(self.hull_density) is None:
            raise ValueError(
                f"the strength of a material of {self.hull_density:g} kg/m3 is not known: set material, or pressure = 0"
            )
        dome = self.core_radius + self.clearance + self.wall
        if self.max_radius and self.max_radius < dome:
            raise ValueError(
                f"max_radius {self.max_radius} m is less than core, clearance and wall, {dome:g} m: make it wider"
            )
        if self.wall_model == "mitred" and self.min_radius <= 1.5 * self.wall:
            raise ValueError(
                f"min_radius {self.min_radius} m must exceed 1.5 times the wall ({1.5 * self.wall:g} m), "
                "or the cavity pinches"
            )
        return self


def _take_default_kit(values: dict[str, Any]) -> dict[str, Any]:
    """Fill in the options of the kit that is weighed, and drop them for a hull."""
    kit, made_as = values.get("kit"), values.get("made_as")
    if made_as == "kit" and kit is None:
        return {**values, "kit": {}}
    if made_as == "hull" and kit == KitOptions().model_dump(mode="json"):
        return {**values, "kit": None}
    return values


def _take_size_of_core(values: dict[str, Any]) -> dict[str, Any]:
    core = CORES.get(values.get("core", CUSTOM))
    if core is None:
        return values
    given = Core(values.get("core_radius", core.radius), values.get("core_mass", core.mass))
    # A resolved study, whose core is replaced by this one, has the size of the other core.
    if given not in (_PAPERS, *CORES.values()):
        raise ValueError(
            f"core '{values['core']}' has a radius of {core.radius:g} m and a mass of {core.mass:.5g} kg: leave out "
            f"core_radius and core_mass, or set core to '{CUSTOM}'"
        )
    return {**values, "core_radius": core.radius, "core_mass": core.mass}


def _take_capsule(values: dict[str, Any]) -> dict[str, Any]:
    """Read the profile of a capsule and fill in its radius, so that a resolved study needs no file."""
    name, taken = values.get("core", CUSTOM), dict(values)
    if isinstance(name, str) and Path(name).suffix[1:].isalpha():
        from driftform_frusta.own.profile import read_profile

        for key in ("core_mass", "core_cog"):
            if taken.get(key) is None:
                raise ValueError(f"'core' is the file of a capsule, whose {key} is missing: add it")
        try:
            points = read_profile(Path(name)).points.round(9).tolist()
        except InputError as error:
            raise ValueError(f"'core' is the file of a capsule: {error}") from None
        taken |= {"core": CUSTOM, "core_profile": points, "core_radius": max(r for _, r in points)}
    elif name in CORES and taken.get("core_profile"):
        # A resolved study, whose capsule is replaced by a ball.
        for key in ("core_profile", "core_cog", "core_radius", "core_mass"):
            taken.pop(key, None)
    return taken


def _take_density_of_material(values: dict[str, Any]) -> dict[str, Any]:
    material = MATERIALS.get(str(values.get("material")))
    if material is None:
        return values
    # A resolved study, whose material is replaced by this one, has the density of the other.
    if values.get("hull_density", material.density) not in (m.density for m in MATERIALS.values()):
        raise ValueError(
            f"material '{values['material']}' has {material.density:g} kg/m3: leave out hull_density, or set material to "
            f"'{CUSTOM}'"
        )
    return {**values, "hull_density": material.density}


def _take_ballast_of_older_runs(values: dict[str, Any]) -> dict[str, Any]:
    """Fill in the ball of lead, of any mass, that 0.2.0 tuned: its resolved studies have `thinnest`, and no `ballast`."""
    if values.get("tuning") == "ballast" and "thinnest" in values and "ballast" not in values:
        return {**values, "ballast": {"material": "lead", "most": 1e4}}
    return values


_FILLING_IN = (
    _take_density_of_material,
    _take_capsule,
    _take_size_of_core,
    _take_default_kit,
    _take_ballast_of_older_runs,
)
"""What fills in options that follow from others, in this order, so that a resolved study states them."""


class FrustaBuilder(PhenotypeBuilder[FrustaOptions]):
    """The outline is the union of the chains and of a dome over the core; the cavity is its inward offset by the wall.

    The dome has the radius core + clearance + wall, and both chains start tangent to it at the core's equator. Over a capsule
    it is the offset of its profile by clearance and wall, and the chains start at the ends of the widest part. Without modules a
    body that can be tuned is a plain one: the shortest capsule of the width ``max_radius`` that floats the core, or the smallest
    such sphere if the width is free.
    """

    name = "frusta"
    Options = FrustaOptions

    def build(self, morphology: Morphology) -> Body:
        """Return the meridian section of the morphology.

        Raises ValueError if a module has no length, or turns back, and WorkFailedError if the body is weighed as a kit, and
        no kit can be made of it, or if no wall withstands the pressure; the message names the module or has the reason.
        """
        untuned = replace(morphology, tuning=0.0)
        o = _size_wall(self.options, untuned)
        if o.tuning == "none" or not morphology.tuning:
            body = _build_untuned(o, untuned)
        elif _loads_any_mass(o):
            body, density = _build_untuned(o, untuned), o.ballast.density
            body = replace(body, ballast=place_ballast(body, morphology.tuning, density), ballast_density=density)
        else:
            body = _build_loaded(o, untuned, morphology.tuning)
        lost = o.pressure and o.pressure * sum(part.loss for part in list_parts(body))
        return replace(body, squeeze=lost / mass_properties(body).volume) if lost else body

    def describe_strength(self, body: Body, fluid: Fluid) -> Mapping[str, Any] | None:
        """Return what the hull withstands by :mod:`driftform_frusta.strength`; ``None`` if that is not known."""
        return describe_strength(body, fluid)

    def find_tunings(self, morphology: Morphology) -> tuple[float, float] | None:
        """Return the least and the greatest mass (kg) that can be added to the hull; the least is negative for a thinner wall."""
        untuned = replace(morphology, tuning=0.0)
        o = _size_wall(self.options, untuned)
        if o.tuning == "none":
            return None
        if not _loads_any_mass(o):
            low, high = _find_range(_list_loads(o, untuned))
            return (low, high) if high - low > _ROUNDING else None
        density, body = o.ballast.density, _build_untuned(o, untuned)
        most = min(find_max_ballast(body, density), o.ballast.most)

        def can_hold(mass: float) -> bool:
            try:
                _measure_fittings(o, _draw(o, untuned), (name_ball(place_ballast(body, mass, density)),))
            except WorkFailedError:
                return False
            return True

        # The ball that lets the body float freely, and the largest one: those between them fit if both do.
        if most and can_hold(most / SPARE):
            return (0.0, next(m for m in (most, *(most * s / SPARE for s in LESS)) if can_hold(m)))
        return None


def _loads_any_mass(o: FrustaOptions) -> bool:
    return o.tuning == "ballast" and not o.ballast.is_sold_in_sizes


def _find_range(loads: Sequence[Load]) -> tuple[float, float]:
    """Return the least and the greatest mass (kg) that loads add, without a gap in between."""
    low, high = loads[0].masses
    for least, most in sorted(load.masses for load in loads):
        high = max(high, most) if least <= high else high
        low = min(low, least)
    return low, high


@lru_cache(maxsize=KEPT_BODIES)
def _size_wall(o: FrustaOptions, morphology: Morphology) -> FrustaOptions:
    """Return the options with the least wall that withstands the pressure; the same ones if none is asked for."""
    if not o.pressure:
        return o
    lines, needed = math.ceil(o.thinnest / o.line_width - 1e-9), o.safety * o.pressure
    while True:
        wall = lines * o.line_width
        # A thick wall needs a wider chain, or it pinches the cavity.
        sized = o.model_copy(update={"wall": wall, "thinnest": wall, "min_radius": max(o.min_radius, 1.6 * wall)})
        bare = _draw(sized, morphology)
        holds = min((part.holds for part in list_parts(bare)), default=0.0)
        if holds >= needed:
            return sized
        # A cavity that is hardly larger than its core does not become smaller.
        if not holds or solid_of_revolution(bare.cavity).volume < 1.2 * bare.core.volume:
            raise WorkFailedError(
                f"no wall withstands {needed / 1e5:g} bar and leaves room beside the core: {1000 * wall:g} mm fill the hull",
                violations={"pressure": 1 - holds / needed},
            )
        # No part gains more than by the cube of its wall.
        lines = max(lines + 1, math.ceil(lines * (needed / holds) ** (1 / 3) - 1e-9))


@lru_cache(maxsize=KEPT_BODIES)
def _build_untuned(o: FrustaOptions, morphology: Morphology) -> Body:
    bare = _draw(o, morphology)
    return replace(bare, fittings=_measure_fittings(o, bare))


@lru_cache(maxsize=KEPT_BODIES)
def _build_loaded(o: FrustaOptions, morphology: Morphology, added: float) -> Body:
    """Return a body with a mass (kg) that is added to its hull."""
    loads = _list_loads(o, morphology)
    chosen = next((load for load in loads if load.masses[0] - _ROUNDING <= added <= load.masses[1] + _ROUNDING), None)
    if chosen is None:
        low, high = (1000 * mass for mass in _find_range(loads))
        raise ValueError(f"{1000 * added:.4g} g cannot be added to this hull: it takes {low:.4g} to {high:.4g} g")
    body = chosen.add_to(_draw(o, morphology), added)
    if details := body.fittings.details:
        # Another cavity leaves another share of them in the wall.
        from driftform_frusta.fittings import measure_details

        body = measure_details(body, [(detail.name, detail.added, detail.removed) for detail in details])
    held = (name_ball(body.ballast),) if body.ballast.volume else ()
    return replace(body, fittings=_measure_fittings(o, body, held))


@lru_cache(maxsize=KEPT_BODIES)
def _list_loads(o: FrustaOptions, morphology: Morphology) -> tuple[Load, ...]:
    bare = _draw(o, morphology)
    widest, wall = bare.cavity, o.wall
    if o.tuning == "wall" and o.wall_model == "mitred" and not o.pressure:
        from driftform_frusta.envelope import offset_inward

        widest = clear_cavity(offset_inward(bare.outer, o.thinnest), bare.pockets, o.wall)
        wall = min(o.wall, o.thinnest)
    loads = list_loads(replace(bare, wall=wall), widest, draw_room(_place_core(o)[1], o.wall), o.ballast, o.clearance)
    return loads if o.tuning == "wall" else loads[::-1]


@lru_cache(maxsize=KEPT_BODIES)
def _draw(o: FrustaOptions, morphology: Morphology) -> Body:
    """Return a body without what is added to it, and without what its kit has in addition to the wall."""
    _check_modules("fore", morphology.fore)
    _check_modules("aft", morphology.aft)
    if o.tuning != "none" and not morphology.modules:
        return _draw_plain(o)
    core, over, shoulders = _place_core(o)
    dome = over if isinstance(over, float) else float(over[:, 1].max())
    chains = lay_chains(
        morphology.fore, morphology.aft, dome, o.min_radius + o.wall / 2, shoulders, o.max_radius or math.inf
    )
    return _draw_hull(o, core, over, chains, chains[:, 0])


def _draw_plain(o: FrustaOptions) -> Body:
    """Return the shortest capsule of the greatest width that floats its core, or the smallest sphere if the width is free."""
    core, over, _ = _place_core(o)
    dome = over if isinstance(over, float) else float(over[:, 1].max())
    for scale in np.arange(1.0, MAX_SLENDERNESS, 0.1).tolist():
        width, length = (2 * o.max_radius, 2 * o.max_radius * scale) if o.max_radius else (2 * dome * scale,) * 2
        capsule = draw_capsule(width, max(length, 2 * dome))
        body = _draw_hull(o, core, over, capsule, capsule[[0, -1], 0])
        try:
            found = mass_properties(replace(body, fittings=_measure_fittings(o, body)))
        except WorkFailedError:
            continue  # no kit: too short for its joint
        if found.mass < (1 - MIN_SPARE) * WATER * found.volume:
            return body
    raise WorkFailedError(f"no plain body floats the core: at most {MAX_SLENDERNESS:g} times as large as it was tried")


def _draw_hull(o: FrustaOptions, core: Core, over: float | FloatArray, chains: FloatArray, joints: FloatArray) -> Body:
    section = hull_section if o.wall_model == "mitred" else open_section
    outer, cavity = section(chains, over, o.wall)
    body = Body(
        outer=outer,
        cavity=cavity,
        joints=joints,
        core=core,
        wall=o.wall,
        hull_density=o.hull_density,
        expansion=find_expansion(o.hull_density),
    )
    if o.pressure:
        body = replace(body, cavity=thicken_ends(body, o.clearance, o.safety * o.pressure, o.line_width))
    if o.pockets.diameter:
        pockets = place_pockets(body, o.pockets)
        body = replace(body, pockets=pockets, cavity=clear_cavity(body.cavity, pockets, o.wall))
    if not o.fittings:
        return body
    # Solids take a while to import, and most bodies have no fittings.
    from driftform_frusta.fittings import fit_hull

    return fit_hull(body, [choice.make() for choice in o.fittings])


def _place_core(o: FrustaOptions) -> tuple[Core, float | FloatArray, tuple[float, float]]:
    """Return the core, the radius or the contour of the dome over it, and where chains start at its ends, m."""
    if not o.core_profile:
        return Core(o.core_radius, o.core_mass), o.core_radius + o.clearance + o.wall, (0.0, 0.0)
    # manifold3d takes a while to import, and a ball needs no offset.
    from driftform_frusta.own.core import find_shoulders, outline_core, place_capsule

    core = place_capsule(o.core_profile, o.core_mass, o.core_cog or 0.0)
    return core, outline_core(core.contour, o.clearance + o.wall), find_shoulders(np.array(core.contour))


def _measure_fittings(o: FrustaOptions, bare: Body, ballast: tuple[tuple[float, float], ...] = ()) -> Fittings:
    """Return what the kit of a body has in addition to the wall, with seats for some balls; nothing for a hull in one piece."""
    if o.kit is None:
        return bare.fittings
    # The sections of parts take a while to import, and most studies weigh the hull in one piece.
    from driftform_frusta.parts import find_maker

    fittings: Fittings = find_maker().measure_fittings(bare, o.kit.model_copy(update={"ballast": ballast}))
    return fittings


def _check_modules(side: str, modules: Sequence[Module]) -> None:
    for number, module in enumerate(modules, start=1):
        if not (0 < module.length < math.inf and abs(module.tilt) < math.pi / 2):
            raise ValueError(
                f"module {number} {side} of the core cannot be built: it is {1000 * module.length:g} mm long with a tilt "
                f"of {math.degrees(module.tilt):g} deg; a length is more than 0, and a tilt less than 90 deg"
            )
