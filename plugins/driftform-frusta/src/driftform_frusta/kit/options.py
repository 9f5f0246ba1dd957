"""What a maker may ask of a kit."""

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from driftform.interfaces import Printer
from driftform.options import Table, option
from driftform_frusta.lettering import missing_letters

GROOVE_SHARE = 0.8
"""Room between bore and groove over the cord of an O-ring: a squeeze of 20 %, usual for a seal at rest."""

GROOVE_WIDTH = 1.1
"""Width of the groove's bottom over the cord: with the sloped side, the ring fills two thirds of the groove."""

GROOVE_MARGIN = 0.001
"""m of sleeve on either side of a groove."""

_Length = Annotated[float, Field(gt=0, le=10, strict=True)]


class KitOptions(Table):
    """A hull in parts that take the core; the other options say how, where ``kit`` is true."""

    kit: bool = option(False, "cut the hull into parts that take the core and are joined again")
    clearance: float = option(
        0.0002,
        "gap between parts that fit into each other, and between seat and core",
        "m",
        ge=0.00005,
        le=0.002,
    )
    joint: Literal["auto", "sleeve", "rabbet"] = option(
        "auto",
        "how the shells meet around the core: 'sleeve', a ring inside that slides into the other shell, beside "
        "the core's equator where the core leaves no room for it; 'rabbet', a step in the thickness of the wall, at "
        "the equator; 'auto': a sleeve where there is room for one",
    )
    sleeve: float = option(0.0012, "thickness of a sleeve", "m", ge=0.0004, le=0.01)
    lap: float = option(
        0.006, "length of a sleeve in the other part; a rabbet has half of it", "m", ge=0.002, le=0.05
    )
    o_ring: float = option(
        0.0,
        "cord of O-rings to cut grooves for, in each sleeve; 0: none, the joints are glued",
        "m",
        ge=0,
        le=0.01,
    )
    nozzle: float = option(
        Printer().nozzle,
        "diameter of the printer's nozzle, the thinnest step of a joint",
        "m",
        gt=0,
        le=0.005,
    )
    bed: tuple[_Length, _Length, _Length] = option(
        Printer().bed,
        "largest part of a kit: width, depth and height; longer ones are cut at joints of modules",
        "m",
    )
    drain: float = option(
        0.0,
        "diameter of holes on the axis through both ends, to fill and to drain; 0: none",
        "m",
        ge=0,
        le=0.02,
    )
    engrave: str = option("", "text to engrave in each part of a kit that has room for it", max_length=40)
    engrave_side: Literal["outside", "inside"] = option("outside", "side of the wall that is engraved")
    engrave_depth: float = option(0.0004, "depth of the engraving", "m", gt=0, le=0.005)
    engrave_size: float = option(0.005, "height of its capital letters", "m", ge=0.001, le=0.1)

    @field_validator("bed", mode="before")
    @classmethod
    def _from_a_list(cls, value: object) -> object:
        return tuple(value) if isinstance(value, list) else value

    @field_validator("engrave")
    @classmethod
    def _can_be_engraved(cls, value: str) -> str:
        if letters := missing_letters(value):
            raise ValueError(
                f"there is no letter for {letters!r}; digits, A to Z and - . _ / : + # can be engraved"
            )
        return value

    @property
    def groove(self) -> float:
        """Depth of the O-ring's groove, m; 0 for none."""
        return max(0.0, GROOVE_SHARE * self.o_ring - self.clearance)

    @model_validator(mode="after")
    def _sleeve_takes_the_groove(self) -> "KitOptions":
        if not self.o_ring:
            return self
        if self.joint == "rabbet":
            raise ValueError(
                "a rabbet has no room for an O-ring: set joint to 'sleeve', or o_ring to 0 for glue"
            )
        needed = self.groove + self.nozzle
        # Lengths of a tenth of a micrometre mean nothing to a printer.
        if self.sleeve < needed - 1e-7:
            raise ValueError(
                f"the groove for an O-ring of {1e3 * self.o_ring:g} mm needs a sleeve of {needed:.4g} m or more, "
                f"not {self.sleeve:g}"
            )
        along = GROOVE_WIDTH * self.o_ring + self.groove + 2 * GROOVE_MARGIN
        if self.lap < along - 1e-7:
            raise ValueError(
                f"the groove for an O-ring of {1e3 * self.o_ring:g} mm needs a lap of {along:.4g} m or more, "
                f"not {self.lap:g}"
            )
        return self


class PartOptions(KitOptions):
    """What every exporter of meshes is asked for."""

    segments: int = option(64, "corners of every circle of the mesh", ge=12, le=1024)
