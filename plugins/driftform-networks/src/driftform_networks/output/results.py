"""What the commands print and write of passages and fleets: lines, tables, maps, layers, reports."""

import csv
import io
import json
import re
from collections import ChainMap, Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from driftform.cli import output
from driftform.errors import InputError
from driftform.figures import files as picture_files
from driftform.figures import style, svg
from driftform.types import FloatArray
from driftform.util import files
from driftform_networks.flights.bodies import Traveller
from driftform_networks.flights.limits import warn_of_limits, word_weight
from driftform_networks.hydraulics.network import BoolArray, Network, warn_of_model
from driftform_networks.output.map import fleet_svg, format_time, passage_svg, plan_svg
from driftform_networks.passages.passage import Passage, count_passings, word_ends
from driftform_networks.planning.candidates import save_agents
from driftform_networks.planning.fleets import Fleet, Member
from driftform_networks.planning.plans import Plan
from driftform_networks.planning.sights import group_sight

_MAX_NAME = 30
"""Characters of an agent's name in a table."""

MAX_ROWS = 8
"""Rows of a table on the screen if it names no other number; all are in the files of ``--tables``, and in the JSON document."""


class TextTable(NamedTuple):
    """A table for people: what it says, a header, rows of text, the columns that are flush right, and most rows on the screen."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[int] = ()
    most: int = MAX_ROWS


@dataclass(frozen=True, eq=False)
class Outputs:
    """What a command prints, and the files that it writes, by the names of their options; ``None`` for no file.

    Attributes:
        columns: values of each link, by the name of the column, by which it says what is seen.
        heard: share of each link within the range of a receiver, (links,); ``None`` without receivers.
    """

    map: Path | None = None
    tables: Path | None = None
    report: Path | None = None
    agents: Path | None = None
    gis: Path | None = None
    crs: str | None = None
    page: style.Page = style.SCREEN
    json: bool = False
    columns: Mapping[str, Sequence[str]] = field(default_factory=dict)
    heard: FloatArray | None = None

    def check(self) -> Self:
        """Return these files. Raises InputError if a directory cannot be written to, or a file has the wrong suffix."""
        for option, path, suffix in (("--map", self.map, ".svg"), ("--report", self.report, ".html")):
            if path is None:
                continue
            if path.suffix != suffix:
                raise InputError(f"{option} {path}: the name of this file must end in {suffix}")
            files.check_directory(path.parent, option)
        if self.crs is not None and not re.fullmatch(r"EPSG:\d{4,6}", self.crs):
            raise InputError(
                f"--crs {self.crs}: expected the number of a coordinate reference system, such as EPSG:25832"
            )
        for option, path in (("--tables", self.tables), ("--agents", self.agents), ("--gis", self.gis)):
            if path is not None:
                files.check_directory(path, option)
        return self

    def write_map(self, draw: Callable[..., str]) -> list[Path]:
        """Write the map, a function of its page, if it is asked for, and return its paths."""
        if self.map is None:
            return []
        return [*picture_files.write_picture(self.map, draw(page=self.page), self.page)]

    def present(
        self,
        result: Passage | Fleet | Plan,
        title: str,
        document: dict[str, Any],
        lines: Sequence[str],
        tables: Sequence[TextTable],
        figure: Callable[..., str],
        bodies: Sequence[Traveller],
        saved: Sequence[Path] = (),
    ) -> None:
        """Write map, report, tables and layers, those that are asked for, and print the result.

        ``document``, ``lines`` and ``tables`` get what all results have; ``figure`` draws the map;
        ``bodies`` travel, and there are none where water does; ``saved`` files are already written.
        """
        network, known = result.network, result.recorded if isinstance(result, Plan) else result.seen
        more, groups = self._describe_sights(network, known, result.reachable, document)
        limits = (line for one in bodies for line in warn_of_limits(one, network, known, result.steps))
        document["warnings"] = [*limits, *warn_of_model(network, result.steps)]
        columns = result.list_tables()
        texts = [
            text for table in columns.values() for cells in table.values() for text in cells if isinstance(text, str)
        ]
        if self.tables is not None and (
            formula := next((text for text in texts if text.startswith(tuple("=+-@"))), "")
        ):
            document["warnings"].append(
                f"a spreadsheet takes '{formula}' for a formula, as it begins with =, +, - or @"
            )
        lines, tables = [*lines, *more, *document["warnings"]], [*tables, *groups]
        written = self.write_map(figure)
        if self.report is not None:
            # One page, which loads nothing over the network.
            page = svg.fill_template(
                __package__,
                "page.html",
                title=title,
                script=resources.files(__package__).joinpath("zoom.js").read_text(encoding="utf-8"),
                style=resources.files("driftform.search.report").joinpath("page.css").read_text(encoding="utf-8"),
                lead=lines,
                tables=tables,
                figure=figure(),
                is_body=bool(bodies),
            )
            files.write_text(self.report, page)
            written.append(self.report)
        if self.tables is not None:
            for name, table in columns.items():
                buffer = io.StringIO()
                writer = csv.writer(buffer, lineterminator="\n")
                writer.writerow(table)
                writer.writerows(zip(*table.values(), strict=True))
                written.append(self.tables / f"{name}.csv")
                files.write_text(written[-1], buffer.getvalue())
        if self.gis is not None:
            written += write_geojson(self.gis, network, columns, self.crs)
        present(document, [title, *tables, *lines], [*written, *saved], self.json)

    def _describe_sights(
        self, network: Network, seen: FloatArray, reachable: BoolArray, document: dict[str, Any]
    ) -> tuple[list[str], list[TextTable]]:
        """Return lines and tables, and add the same to a JSON document."""
        lines, tables = [], []
        for name, values in self.columns.items():
            groups = group_sight(network, seen, reachable, values)
            rows = [[value, f"{length / 1000:.2f}", f"{100 * share:.1f}"] for value, length, share in groups]
            tables.append(TextTable(f"What is seen by {name}", (name, "km", "seen %"), rows, (1, 2)))
            keys = ("value", "length", "seen")
            document.setdefault("by", {})[name] = [dict(zip(keys, row, strict=True)) for row in groups]
        if self.heard is not None:
            worth = np.where(reachable, network.worth, 0.0)
            both = [float(worth @ part / worth.sum()) for part in (self.heard, self.heard * seen)]
            document |= {"in_range": both[0], "heard": both[1]}
            lines.append(
                f"receivers are in range of {100 * both[0]:.1f} % of the length; {100 * both[1]:.1f} % is seen by bodies in range"
            )
        return lines, tables


def present_plan(plan: Plan, title: str, outputs: Outputs, travellers: Sequence[Traveller]) -> None:
    """Write the files of a plan, and print it."""
    network, document = plan.network, plan.as_document()
    clock = network.hydraulics.format_clock
    counts = Counter(plan.members)
    rows = [[f"{n}", name, node, f"{hour:g}", clock(hour, 0)] for (name, node, hour), n in counts.items()]
    starts = min(hour for _, _, hour in plan.members)
    caught = [
        [node, f"{100 * share:.1f}", format_time(age), clock(starts, age)]
        for node, share, age in zip(plan.nets, plan.catches, plan.arrivals, strict=True)
    ]
    tables = [
        TextTable("Release these bodies", ("number", "agent", "release", "hour", "time"), rows, (0, 3)),
        TextTable("Place these nets", ("net at", "catches %", "mean age", "time of the first release"), caught, (1,)),
    ]
    words = {"ends": word_ends(plan.ends, len(plan.members)), "passings": word_passings(plan.passings)}
    lines = list_lines("plan.txt", **document, **words)
    figure = partial(plan_svg, plan, title, lines[1])
    passings = [(name, how) for (name, _, _), how in zip(plan.members, plan.passings, strict=True)]
    chosen, weights = _choose_bodies(travellers, passings, network, plan.steps)
    lines += weights
    outputs.present(plan, title, document, lines, tables, figure, chosen)


def present_passage(passage: Passage, title: str, outputs: Outputs, body: Traveller | None = None) -> None:
    """Write the files of a passage of a body, or of water, and print it."""
    network, document = passage.network, passage.as_document()
    length = network.length[passage.reachable].sum() / 1000
    lines = [
        f"sees {100 * passage.coverage:.1f} % of the {length:.1f} km that its water reaches",
        word_ends(passage.ends),
    ]
    if body is not None:
        lines += [word_passings([passage.passings]), *word_weight(body, network, passage.passings, passage.steps)]
    rows = [
        [end.kind, end.place, f"{100 * end.probability:.2f}", end.reason]
        for end in passage.ends
        if end.probability >= 5e-5
    ]
    tables = [
        _table_nodes(passage),
        TextTable("Where it ends, and why", ("ends by", "place", "probability %", "reason"), rows, (2,)),
    ]
    if passage.gates:
        rows = [[link, what, f"{100 * share:.2f}"] for link, (what, share) in passage.gates.items()]
        tables.append(TextTable("What it passes", ("passes", "what", "probability %"), rows, (2,)))
    if passage.branches:
        document["branches"], sides = _compare_sides(passage)
        tables.append(sides)
    figure = partial(passage_svg, passage, title, lines[0])
    outputs.present(passage, title, document, lines, tables, figure, [] if body is None else [body])


def present_fleet(fleet: Fleet, title: str, outputs: Outputs, travellers: Sequence[Traveller]) -> None:
    """Write the files of a fleet, and print it."""
    document, size = fleet.as_document(), len(fleet.members)
    ends = word_ends((end for member in fleet.members for end in member.passage.ends), size)
    passings = word_passings(member.passage.passings for member in fleet.members)
    lines = list_lines("fleet.txt", **document, ends=ends, passings=passings)
    ways = [(member.agent, member.passage.passings) for member in fleet.members]
    chosen, weights = _choose_bodies(travellers, ways, fleet.network, fleet.steps)
    lines += weights
    figure = partial(fleet_svg, fleet, title, lines[0])
    saved = [] if outputs.agents is None else save_agents(chosen, outputs.agents)
    outputs.present(fleet, title, document, lines, _table_fleet(fleet), figure, chosen, saved)


def _choose_bodies(
    travellers: Sequence[Traveller],
    ways: Sequence[tuple[str, Mapping[int, str]]],
    network: Network,
    steps: Sequence[int],
) -> tuple[list[Traveller], list[str]]:
    """Return the bodies that travel, of which ``ways`` have the names and passings, and for each how much its weight decides."""
    chosen = [one for one in travellers if one.name in dict(ways)]
    passings = {one.name: ChainMap(*(dict(how) for name, how in ways if name == one.name)) for one in chosen}
    words = [(one.name, word_weight(one, network, passings[one.name], steps)) for one in chosen]
    return chosen, [f"{name}: {line.partition(':')[0]}" for name, lines in words for line in lines]


def present(document: Mapping[str, Any], text: Sequence[str | TextTable], written: Sequence[Path], json: bool) -> None:
    """Print a JSON document, or lines and tables for people, with the files that were written."""
    if json:
        output.print_json({**document, "files": [str(file) for file in written]})
        return
    for part in (*text, *(f"wrote {file}" for file in written)):
        if isinstance(part, str):
            output.print_text(part)
            continue
        output.print_table(part.header, part.rows[: part.most], part.right)
        if len(part.rows) > part.most:
            output.print_text(f"and {len(part.rows) - part.most} more")


def list_lines(template: str, **values: Any) -> list[str]:
    """Return the lines of a template without empty ones."""
    return list(filter(None, svg.fill_template(__package__, template, **values).splitlines()))


def word_passings(passings: Iterable[Mapping[int, str]]) -> str:
    """Return a line with what bodies were flown through, and why streamtubes divide them at how many junctions."""
    counts = count_passings(passings)
    reasons = ", ".join(f"{reason} {count}" for reason, count in counts["streamtubes"].items())
    total = sum(counts["streamtubes"].values())
    flown = " and ".join(f"{count} {kind}" for kind, count in counts["flown"].items() if count)
    return f"flown through {flown or 'no fittings'}; streamtubes divide bodies at {total}{reasons and f': {reasons}'}"


def _table_nodes(passage: Passage) -> TextTable:
    network, probability = passage.network, passage.probability
    order = [node for node in np.flatnonzero(probability > 1e-6).tolist() if node != passage.release]
    order.sort(key=lambda node: (-probability[node], passage.age[node]))
    header, rows = ["node", "probability %", "mean age", "time"], []
    for node in order:
        row = [network.nodes[node], f"{100 * probability[node]:.2f}", format_time(passage.age[node])]
        row.append(network.hydraulics.format_clock(passage.hour, passage.age[node]))
        if len(passage.quantiles):
            low, _, high = passage.quantiles[node]
            row.append(f"{format_time(low)} to {format_time(high)}")
        rows.append(row)
    if len(passage.quantiles):
        header.append("9 of 10 arrive after")
    return TextTable("When it arrives at each node", header, rows, (1,))


def _compare_sides(passage: Passage) -> tuple[dict[str, Any], TextTable]:
    """Return what changes if branches leave the pipes at each side, as plain values and as a table."""
    document, rows = dict[str, Any](), []
    for side, other in passage.branches.items():
        change, stuck = np.abs(other.probability - passage.probability), sum(end.probability for end in other.stuck)
        most = int(np.argmax(change))
        node, largest = passage.network.nodes[most] if change[most] > 0 else "", float(change[most])
        document[side] = {"coverage": other.coverage, "stuck": stuck, "largest_change": largest, "node": node}
        at = f"{100 * largest:.1f}{node and ' at '}{node}"
        rows.append([side, f"{100 * other.coverage:.1f}", f"{100 * stuck:.1f}", at])
    header = ("branches at", "sees %", "stuck %", "largest change, points")
    return document, TextTable("What changes with the side where branches leave", header, rows, (1, 2))


def _table_fleet(fleet: Fleet) -> list[TextTable]:
    """Return the members, those that are alike in one row, and what fleets of some sizes see."""
    groups: dict[tuple[str, str, float], list[Member]] = {}
    for member in fleet.members:
        release = fleet.network.nodes[member.passage.release]
        groups.setdefault((member.agent, release, member.passage.hour), []).append(member)
    rows = []
    for (agent, release, hour), members in groups.items():
        alone, adds = 100 * members[0].coverage, 100 * sum(member.gain for member in members)
        name = agent if len(agent) <= _MAX_NAME else f"{agent[: _MAX_NAME - 3]}..."
        rows.append([f"{len(members)}", name, release, f"{hour:g}", f"{alone:.1f}", f"{adds:.1f}"])
    header = ("number", "agent", "release", "hour", "alone sees %", "adds %")
    size = len(fleet.curve)
    counts = sorted({count for count in (1, 2, 5, 10, 20, 50, 100) if count < size} | {size})
    curves = (fleet.tracers, fleet.retained, fleet.curve, fleet.choice_bound, fleet.bound)
    seen = [[f"{count}", *(f"{100 * curve[count - 1]:.1f}" for curve in curves)] for count in counts]
    names = ("bodies see %", "tracers", "retained", "fleet", "any choice", "steered")
    return [
        TextTable("Release these bodies", header, rows, (0, 3, 4, 5)),
        TextTable("What fleets of each size see", names, seen, (0, 1, 2, 3, 4, 5)),
    ]


def write_geojson(
    folder: Path, network: Network, tables: Mapping[str, Mapping[str, Sequence[Any]]], crs: str | None
) -> list[Path]:
    """Write the tables of nodes and links, each as the layer of its name, and return the files.

    Points and lines have the coordinates of the network's file. A ``crs`` is named as GeoJSON of 2008 does, which GDAL
    and QGIS read; in RFC 7946 coordinates are longitude and latitude, and nothing is named. Without it, the names of the
    files say that their system is unknown.
    The first column of a table, ``node`` or ``link``, has the names of what each row is about.

    Raises InputError if the network has no coordinates.
    """
    if not np.isfinite(network.places).any():
        raise InputError(f"{network.name}: the file gives its nodes no coordinates: leave out --gis")
    named = {"name": f"urn:ogc:def:crs:{(crs or '').replace(':', '::')}"}
    system = {} if crs in (None, "EPSG:4326") else {"crs": {"type": "name", "properties": named}}
    written = []
    for name, columns in tables.items():
        kind = next(iter(columns))
        if kind not in ("node", "link"):
            continue
        known = {key: row for row, key in enumerate(network.nodes if kind == "node" else network.links)}
        features = []
        for row in zip(*columns.values(), strict=True):
            index = known[row[0]]
            line = network.places[[index]] if kind == "node" else network.polyline(index)
            # JSON has no NaN.
            values = [None if isinstance(value, float) and not np.isfinite(value) else value for value in row]
            place = line.tolist() if kind == "link" else line[0].tolist()
            shape = {"type": "LineString" if kind == "link" else "Point", "coordinates": place}
            features.append(
                {"type": "Feature", "properties": dict(zip(columns, values, strict=True))}
                | {"geometry": shape if np.isfinite(line).all() else None}
            )
        document = {"type": "FeatureCollection", "name": name, **system, "features": features}
        written.append(folder / f"{name}{'' if crs else '-unknown-crs'}.geojson")
        files.write_text(written[-1], json.dumps(document, ensure_ascii=False) + "\n")
    return written
