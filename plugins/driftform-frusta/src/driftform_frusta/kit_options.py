"""The options of a kit."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from driftform.interfaces import Printer, Table, option

STEEL, LEAD = 7850.0, 11340.0
"""Densities of steel and lead, kg/m3 (CRC Handbook of Chemistry and Physics, at 20 degrees C)."""

CORD = 0.00178
"""m: cord of the O-ring of a joint that opens, the thinnest section of AS568 that is sold in all sizes."""

OPENING = {"bayonet": 0.0004, "thread": 0.0003}
"""Joints that open, with the largest clearance at which half of a lug, 0.8 mm high, or of a ridge of 0.6 mm holds, m."""

_Length = Annotated[float, Field(gt=0, le=10, strict=True)]

_Ballast = tuple[
    Annotated[float, Field(ge=-10, le=10, strict=True)], Annotated[float, Field(ge=0.0005, le=1, strict=True)]
]
"""x of the centre of a ball, and its diameter, m."""


class KitOptions(Table):
    """How a hull is cut into parts that enclose the core."""

    clearance: float = option(
        0.0002, "gap between parts that fit into each other, and between seat and core", "m", ge=0.00005, le=0.002
    )
    joint: Literal["auto", "sleeve", "rabbet", "bayonet", "thread"] = option(
        "auto",
        "joint of the shells around the core: 'sleeve', a ring inside that slides into the other shell, at "
        "the core's equator or as near to it as the core leaves room; 'rabbet', a step in the thickness of the wall, at "
        "the equator; 'auto', a sleeve if there is room for one; 'bayonet', a sleeve that a turn locks and opens again, with an O-ring; "
        "'thread', one that two turns do",
    )
    sleeve: float = option(0.0012, "thickness of a sleeve; an O-ring makes it thicker", "m", ge=0.0004, le=0.01)
    lap: float = option(
        0.006,
        "length of a sleeve within the other part; a rabbet has half of it; an O-ring, a bayonet and a thread make it longer",
        "m",
        ge=0.002,
        le=0.05,
    )
    o_ring: float = option(
        0.0,
        "cord diameter of the O-ring in each sleeve, for which a groove is cut, such as 0.00178, 0.00262 or 0.00353; 0: the joints "
        "are glued, and a bayonet or a thread has 0.00178",
        "m",
        ge=0,
        le=0.01,
    )
    nozzle: float = option(
        Printer().nozzle, "diameter of the printer's nozzle, which is the thinnest step of a joint", "m", gt=0, le=0.005
    )
    bed: tuple[_Length, _Length, _Length] = option(
        Printer().bed, "largest size of a part: width, depth and height; longer parts are cut at joints of modules", "m"
    )
    ballast: tuple[_Ballast, ...] = option(
        (), "a ball of ballast that gets a seat: x of its centre, from that of the core, and its diameter", "m"
    )

    @model_validator(mode="before")
    @classmethod
    def _drop_what_older_runs_left_out(cls, values: object) -> object:
        """Options of texts, drains and brims are stated in runs and files of 0.2.0, most often as not asked for."""
        if not isinstance(values, Mapping):
            return values
        unasked = tuple(name for name in ("engrave", "drain", "brim") if not values.get(name))
        return {key: value for key, value in values.items() if not str(key).startswith(unasked)}

    @field_validator("bed", "ballast", mode="before")
    @classmethod
    def _from_a_list(cls, value: object) -> object:
        return tuple(map(cls._from_a_list, value)) if isinstance(value, list) else value

    @field_validator("ballast")
    @classmethod
    def _is_of_one_ball(cls, value: tuple[_Ballast, ...]) -> tuple[_Ballast, ...]:
        if len(value) > 1:
            raise ValueError(
                f"a kit holds one ball, not {len(value)}: replace them by one of their mass, where they balance"
            )
        return value

    @property
    def cord(self) -> float:
        """Cord diameter of the O-ring of the joint at the core, m; 0 without one."""
        return self.o_ring or (CORD if self.joint in OPENING else 0.0)

    @model_validator(mode="after")
    def _joint_takes_what_is_asked_of_it(self) -> "KitOptions":
        if self.o_ring and self.joint == "rabbet":
            raise ValueError(
                "a rabbet has no room for an O-ring: set joint to 'sleeve', or o_ring to 0 and glue the joint"
            )
        if self.clearance > (most := OPENING.get(self.joint, 1.0)):
            raise ValueError(
                f"with a clearance of {self.clearance:g} m a {self.joint} holds too little: set clearance to {most:g} or less, "
                "or joint to 'auto'"
            )
        return self


class PartOptions(KitOptions):
    """The options of every exporter of meshes; those of a kit apply if ``kit`` is true."""

    kit: bool = option(False, "cut the hull into parts that are joined around the core")
    coupon: bool = option(
        False,
        "in place of the agent, plugs and seats at clearances of 0.1 to 0.3 mm, to find the `clearance` of a printer",
    )
    ballast_density: float = option(
        STEEL, "density of the balls of ballast, which the assembly sheet weighs", "kg/m3", ge=100, le=30_000
    )
    segments: int = option(64, "corners of every circle of the mesh", ge=12, le=1024)
    layer_height: float = option(
        0.0002, "layer height that the assembly sheet and 3MF files recommend", "m", gt=0, le=0.01
    )
    perimeters: int = option(3, "recommended perimeters", ge=1, le=100)
    infill: float = option(1.0, "recommended share of infill: 1 is solid, as simulated", ge=0, le=1)
