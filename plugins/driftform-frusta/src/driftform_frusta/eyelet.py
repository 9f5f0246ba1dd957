"""An eyelet: a ring that stands on an end of the hull, to hang it on a line."""

from typing import Literal

from driftform.interfaces import Fitting, Table, option
from driftform.types import Body
from driftform_frusta.csg import MM, Node, Revolve, Rotate, Translate


class EyeletOptions(Table):
    """Size and place of an eyelet."""

    end: Literal["fore", "aft"] = option("fore", "end of the hull that it stands on")
    diameter: float = option(0.01, "outer diameter of the ring", "m", ge=0.003, le=0.1)
    aside: float = option(0.0, "its distance from the axis, such as beside a trim pocket", "m", ge=0, le=1)
    thickness: float = option(0.002, "thickness of the ring, along its axis and across", "m", ge=0.0008, le=0.02)


class Eyelet(Fitting[EyeletOptions]):
    """A ring of square section around a hole across the axis, sunk into an end by the wall, or by its thickness if that is less."""

    name = "eyelet"
    Options = EyeletOptions

    def draw(self, body: Body) -> tuple[Node, None]:
        """Return the ring; nothing is cut out."""
        o, way = self.options, 1.0 if self.options.end == "fore" else -1.0
        outside, half = MM * o.diameter / 2, MM * o.thickness / 2
        hole = max(outside - 2 * half, 0.0)
        ring = Revolve(((hole, -half), (outside, -half), (outside, half), (hole, half)))
        end = MM * float(body.outer[-1 if way > 0 else 0, 0])
        middle = end + way * (outside - min(MM * body.wall, 2 * half))
        return Translate((MM * o.aside, 0.0, middle), Rotate((0.0, 90.0, 0.0), ring)), None
