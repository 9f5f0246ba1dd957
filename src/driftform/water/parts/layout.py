"""Parts laid end to end in space: which follows which, the outlets, and what does not fit."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import cast

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray
from driftform.water.parts.shapes import Bend, Opening, PipePart, Reducer, Straight, Tee, roll_axes, upright_axes
from driftform.water.parts.tables import BendPart, ReducerPart, StraightPart, TeePart, WyePart

OUTLET = "outlet"
"""Name of the only outlet of a pipe without branches, unless it has another."""

MAX_PARTS = 200
"""Most parts of a pipe."""

MIN_BEND_RADIUS = 1.05
"""Least radius of a bend over that of its bore: the wall inside a bend as tight as its bore is a point."""

MIN_REDUCER_LENGTH = 2.0
"""Least length of a reducer over the change of its radius: its wall is then nowhere steeper than 53 degrees."""

FILLETS = (0.1, 0.5)
"""Least and greatest rounding of a junction's edge over the radius of the branch: a sharp edge has an infinite velocity."""

USUAL_FILLET = 0.2

_MAX_SAMPLES = 400
"""Most points of the axis of a part at which collisions are looked for."""

BEYOND = 6.0
"""Length of the bore beyond inlet and outlets, in radii: an agent's nose passes the outlet before its core."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A part in its place in a pipe.

    Attributes:
        name: unique in the pipe.
        key: where the study file gives it, such as ``pipe.parts[1].branch[0]``.
        part: its geometry.
        upstream: index of the part before it, ``None`` for the first one.
        by_branch: True if it follows the branch of that part, and not its run.
        flow: share of the pipe's water that enters it.
        outlet: index of the outlet at the end of its run, ``None`` where another part follows.
    """

    name: str
    key: str
    part: PipePart
    upstream: int | None
    by_branch: bool
    flow: float
    outlet: int | None = None


@dataclass(frozen=True, eq=False)
class Outlet:
    """An outlet: its name, the index of the part that ends there, and the opening."""

    name: str
    part: int
    opening: Opening


@dataclass(frozen=True, eq=False)
class Layout:
    """All parts of a pipe, each after the one upstream of it, and the outlets in the order of the parts."""

    parts: tuple[Placed, ...]
    outlets: tuple[Outlet, ...]

    @property
    def inlet(self) -> Opening:
        """The inlet."""
        first = self.parts[0].part
        return Opening(first.entry, first.axes, first.radius)

    @property
    def narrowest(self) -> float:
        """Radius of the narrowest bore, m."""
        return min(placed.part.narrowest for placed in self.parts)

    @cached_property
    def depths(self) -> FloatArray:
        """Distance of the entry of each part from the inlet along the axes, m, (parts,)."""
        depths = np.zeros(len(self.parts))
        for index, placed in enumerate(self.parts):
            if placed.upstream is not None:
                depths[index] = depths[placed.upstream] + self._length_through(placed.upstream, placed.by_branch)
        return depths

    @property
    def longest_path(self) -> float:
        """Distance from the inlet to the farthest end of a part along the axes, m."""
        ends = [depth + placed.part.length for depth, placed in zip(self.depths, self.parts, strict=True)]
        return float(max(ends))

    def junction_depth(self, index: int) -> float:
        """Return the distance (m) along the axes from the inlet to where the branch of a tee begins."""
        return float(self.depths[index] + self._length_to_junction(index))

    def find_part(self, points: FloatArray) -> npt.NDArray[np.int64]:
        """Return the index of the first part in which each of ``points`` (m, (n, 3)) lies, -1 for one outside, (n,)."""
        found = np.full(len(points), -1)
        for index, placed in enumerate(self.parts):
            inside = placed.part.find_inside(placed.part.to_local(points), margin=1e-9)
            found[(found < 0) & inside] = index
        return found

    def distance_between(
        self, first: int, second: int, from_entry: FloatArray, to_point: FloatArray, on_branch: bool = False
    ) -> FloatArray:
        """Return the distance along the axes from points of part ``first`` to points of a later part, m.

        ``from_entry`` and ``to_point`` are distances from the entries of the two parts along their axes, m; ``on_branch``
        is True for points on the branch of a tee.
        """
        here, there = self.depths[first] + from_entry, self.depths[second] + to_point
        parted = here
        leaving = self._find_exit(first, second)
        if leaving is None:
            parted = np.full_like(here, self._find_junction(first, second))
        elif isinstance(self.parts[first].part, Tee) and leaving != on_branch:
            parted = np.minimum(here, self.depths[first] + self._length_to_junction(first))
        return np.asarray(here + there - 2 * parted)

    def path_to_point(self, index: int, target: int, point: FloatArray) -> tuple[FloatArray, float]:
        """Return where the path from part ``index`` to a ``point`` (m, (3,)) of part ``target`` leads first, and its rest.

        The first is a point, (3,), and the rest a length, m. Within a part, and to one that shares an opening with it, the path
        leads straight to the point. From other parts it leads to the centre of the next opening, along the axes to the
        last opening, and straight to the point.
        """
        if index in (target, self.parts[target].upstream) or target == self.parts[index].upstream:
            return point, 0.0
        here, there = self.parts[index].part, self.parts[target].part
        leaving, coming = self._find_exit(index, target), self._find_exit(target, index)
        first = here.entry if leaving is None else here.list_exits()[leaving].centre
        last = there.entry if coming is None else there.list_exits()[coming].centre
        if leaving is not None:
            length = self.depths[target] - self.depths[index] - self._length_through(index, leaving)
        elif coming is not None:
            length = self.depths[index] - self.depths[target] - self._length_through(target, coming)
        else:
            length = self.depths[index] + self.depths[target] - 2 * self._find_junction(index, target)
        return first, float(length + np.linalg.norm(last - point))

    def _length_to_junction(self, index: int) -> float:
        part = self.parts[index].part
        return part.legs[0] if isinstance(part, Tee) else part.length

    def _length_through(self, index: int, by_branch: bool) -> float:
        part = self.parts[index].part
        return part.legs[0] + part.legs[2] if isinstance(part, Tee) and by_branch else part.length

    def _find_exit(self, index: int, below: int) -> bool | None:
        """Return whether the path from a part downstream to another leaves it by its branch; ``None`` if there is no such path."""
        while below > index:
            placed = self.parts[below]
            if placed.upstream == index:
                return placed.by_branch
            below = cast(int, placed.upstream)
        return None

    def _find_junction(self, first: int, second: int) -> float:
        """Return the distance (m) from the inlet to the junction where the paths to two parts separate."""
        above, upstream = set[int](), cast("int | None", first)
        while upstream is not None:
            above.add(upstream)
            upstream = self.parts[upstream].upstream
        while second not in above:
            second = cast(int, self.parts[second].upstream)
        return self.junction_depth(second)


class LayoutError(ValueError):
    """A pipe that cannot be laid out; the message begins with the key to change."""


AnyPart = StraightPart | BendPart | ReducerPart | TeePart | WyePart


@dataclass
class _Builder:
    parts: list[Placed] = field(default_factory=list)
    outlets: list[Outlet] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)

    def lay_chain(
        self, tables: Sequence[AnyPart], key: str, start: Opening, upstream: int | None, by_branch: bool, flow: float
    ) -> None:
        """Lay parts end to end from an opening on, and the branches of each."""
        for position, table in enumerate(tables):
            here, last = f"{key}[{position}]", position == len(tables) - 1
            if len(self.parts) == MAX_PARTS:
                raise LayoutError(f"{here}: the pipe has more than {MAX_PARTS} parts")
            part = _place(table, start, here)
            index, exits, outlet = len(self.parts), part.list_exits(), len(self.outlets) if last else None
            self.counts[table.kind] = self.counts.get(table.kind, 0) + 1
            name = table.name or f"{table.kind} {self.counts[table.kind]}"
            if any(placed.name == name for placed in self.parts):
                raise LayoutError(f"{here}.name = '{name}': another part has this name")
            self.parts.append(Placed(name, here, part, upstream, by_branch, flow, outlet))
            if last:
                self.outlets.append(Outlet(table.outlet, index, exits[0]))
            elif table.outlet:
                raise LayoutError(
                    f"{here}.outlet = '{table.outlet}': an outlet is at the end of the pipe or of a branch, and another part follows"
                )
            if isinstance(table, TeePart | WyePart):
                if not table.branch:
                    array = re.sub(r"\[\d+\]", "", here)
                    raise LayoutError(
                        f"{here}: the branch of the {table.kind} has no parts: add at least [[{array}.branch]] "
                        'with length and outlet = "..."'
                    )
                self.lay_chain(table.branch, f"{here}.branch", exits[1], index, True, flow * table.share)
                flow *= 1.0 - table.share
            start, upstream, by_branch = exits[0], index, False

    def name_outlets(self) -> tuple[Outlet, ...]:
        """Return the outlets; the only one of a pipe may be without a name."""
        if len(self.outlets) == 1 and not self.outlets[0].name:
            self.outlets[0] = Outlet(OUTLET, self.outlets[0].part, self.outlets[0].opening)
        seen: dict[str, str] = {}
        for outlet in self.outlets:
            key = self.parts[outlet.part].key
            if not outlet.name:
                raise LayoutError(
                    f'{key}: the outlet at its end has no name: a pipe with branches has several outlets; add outlet = "..."'
                )
            if outlet.name.casefold() in seen:
                raise LayoutError(
                    f"{key}.outlet = '{outlet.name}': {seen[outlet.name.casefold()]} has this outlet, too"
                )
            seen[outlet.name.casefold()] = key
        return tuple(self.outlets)


def lay_out(tables: Sequence[AnyPart], start: FloatArray, direction: FloatArray, radius: float) -> Layout:
    """Return the layout of parts from the inlet on.

    Args:
        tables: the parts of the run, with those of the branches in them.
        start, direction: centre of the inlet (m) and the direction downstream, world frame, (3,).
        radius: of the bore at the inlet, m.

    Raises LayoutError if a part does not fit to its bore, two parts run into each other, or an outlet has no name.
    """
    builder = _Builder()
    opening = Opening(
        np.asarray(start, dtype=np.float64), upright_axes(np.asarray(direction, dtype=np.float64)), radius
    )
    builder.lay_chain(tables, "pipe.parts", opening, None, False, 1.0)
    layout = Layout(tuple(builder.parts), builder.name_outlets())
    _check_collisions(layout)
    return layout


def _place(table: AnyPart, start: Opening, key: str) -> PipePart:
    radius = start.radius
    roll = math.radians(getattr(table, "roll_deg", 0.0))
    axes = roll_axes(upright_axes(start.axes[0], start.axes), roll)
    match table:
        case StraightPart():
            return Straight(start.centre, axes, radius, table.length)
        case BendPart():
            if table.radius < MIN_BEND_RADIUS * radius * (1 - 1e-9):
                raise LayoutError(
                    f"{key}.radius = {table.radius:g}: the bend is tighter than its bore of radius {radius:g} m: "
                    f"it needs at least {MIN_BEND_RADIUS * radius:g} m"
                )
            return Bend(start.centre, axes, radius, table.radius, math.radians(table.angle_deg))
        case ReducerPart():
            change = abs(table.radius - radius)
            if change < 1e-9 * radius:
                raise LayoutError(f"{key}.radius = {table.radius:g}: the bore has this radius already: use a straight")
            if table.length < MIN_REDUCER_LENGTH * change * (1 - 1e-9):
                raise LayoutError(
                    f"{key}.length = {table.length:g}: too short for a change of the radius from {radius:g} to {table.radius:g} m: "
                    f"it needs at least {MIN_REDUCER_LENGTH * change:g} m"
                )
            return Reducer(start.centre, axes, radius, table.radius, table.length)
    angle = math.radians(table.angle_deg if isinstance(table, WyePart) else 90.0)
    r = table.branch_radius
    if r > radius:
        raise LayoutError(
            f"{key}.branch_radius = {r:g}: the branch is wider than the run of radius {radius:g} m: "
            "put a reducer before the junction"
        )
    fillet = USUAL_FILLET * r if table.fillet is None else table.fillet
    low, high = FILLETS[0] * r, FILLETS[1] * r
    if not low * (1 - 1e-9) <= fillet <= high * (1 + 1e-9):
        raise LayoutError(
            f"{key}.fillet = {fillet:g}: the edge of a branch of radius {r:g} m is rounded by {low:g} to {high:g} m"
        )
    tee = Tee(start.centre, axes, radius, r, angle, fillet, table.share)
    return Tee(start.centre + tee.legs[0] * axes[0], axes, radius, r, angle, fillet, table.share)


def _check_collisions(layout: Layout) -> None:
    """Check that no two bores meet except at their openings.

    Two points of the axes that are closer than the sum of the radii must be neighbours along the pipe: half a turn of the
    tightest bend apart, at most.
    """
    samples = list(_sample_axes(layout))
    for second in samples:
        for first in samples:
            (low, high), (least, most) = first.box, second.box
            if first.part >= second.part or (low > most).any() or (least > high).any():
                continue
            apart = np.linalg.norm(second.points - first.points[:, None], axis=2)
            needed = second.radii + first.radii[:, None]
            along = layout.distance_between(
                first.part, second.part, first.lengths[:, None], second.lengths, first.on_branch
            )
            if ((apart < (1 - 1e-6) * needed) & (along > 0.5 * math.pi * MIN_BEND_RADIUS * needed)).any():
                one, other = layout.parts[first.part], layout.parts[second.part]
                raise LayoutError(
                    f"{other.key}: {other.name} runs into {one.name}; change a length, an angle or a roll_deg between them"
                )


@dataclass(frozen=True, eq=False)
class _Samples:
    """Points of one axis of a part, their radii, and their distances from the part's entry along the axes, m."""

    part: int
    points: FloatArray
    radii: FloatArray
    lengths: FloatArray
    on_branch: bool = False

    @cached_property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest coordinates of the bore, m, (3,) each."""
        wide = self.radii.max()
        return self.points.min(axis=0) - wide, self.points.max(axis=0) + wide


def _sample_axes(layout: Layout) -> Iterator[_Samples]:
    for index, placed in enumerate(layout.parts):
        part = placed.part
        for number, axis in enumerate(part.list_axes(max(0.25 * part.narrowest, part.length / _MAX_SAMPLES))):
            begin = part.legs[0] if isinstance(part, Tee) and number == 1 else 0.0
            yield _Samples(index, axis.points, axis.radii, begin + axis.lengths, number == 1)
        if placed.outlet is not None:
            opening = part.list_exits()[0]
            x = np.linspace(0, BEYOND * opening.radius, 17)[1:]
            points = opening.centre + x[:, None] * opening.axes[0]
            yield _Samples(index, points, np.full(len(x), opening.radius), part.length + x)
