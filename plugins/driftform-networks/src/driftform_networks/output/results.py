"""What the commands print and write of passages and fleets: lines, tables, maps, layers, reports."""

import csv
import io
import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
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
from driftform_networks.flights.limits import warn_of_limits
from driftform_networks.hydraulics.network import BoolArray, Network, warn_of_pressure
from driftform_networks.output.map import curve_svg, fleet_svg, format_time, passage_svg, plan_svg
from driftform_networks.passages.passage import Passage, count_passings
from driftform_networks.planning.candidates import save_agents
from driftform_networks.planning.fleets import Fleet, Member
from driftform_networks.planning.plans import Plan
from driftform_networks.planning.sights import group_sight

_MAX_NAME = 30
"""Characters of an agent's name in a table."""

MAX_ROWS = 12
"""Rows of a table on the screen; all are in the files of ``--tables``, and in the JSON document."""


class TextTable(NamedTuple):
    """A table for people: a header, rows of text, and the columns that are flush right."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[int] = ()


@dataclass(frozen=True)
class Outputs:
    """Files that a command writes, by the names of their options; ``None`` for no file."""

    map: Path | None = None
    tables: Path | None = None
    report: Path | None = None
    agents: Path | None = None
    gis: Path | None = None
    crs: str | None = None
    page: style.Page = style.SCREEN

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

    def write(
        self,
        network: Network,
        title: str,
        figures: Mapping[str, Callable[..., str]],
        text: Sequence[str | TextTable],
        columns: Mapping[str, Mapping[str, Sequence[Any]]],
        is_body: bool,
    ) -> list[Path]:
        """Write map, report, tables and layers, those that are asked for, and return their paths.

        ``figures`` draw SVG pictures, first the map; ``text`` is what a command prints, of which lines come first;
        ``columns`` are those of each table; ``is_body`` is whether it is about bodies, in place of water.
        """
        written = self.write_map(figures["Map"])
        if self.report is not None:
            # One page, which loads nothing over the network.
            page = svg.fill_template(
                __package__,
                "page.html",
                title=title,
                script=resources.files(__package__).joinpath("zoom.js").read_text(encoding="utf-8"),
                style=resources.files("driftform.search.report").joinpath("page.css").read_text(encoding="utf-8"),
                lead=[part for part in text if isinstance(part, str)],
                tables=[part for part in text if not isinstance(part, str)],
                figures=[(name, draw()) for name, draw in figures.items()],
                is_body=is_body,
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
        return written


@dataclass(frozen=True, eq=False)
class Sights:
    """Further results of a command: what is seen by values of columns, and what receivers hear.

    Attributes:
        columns: values of each link, by the name of the column.
        heard: share of each link within the range of a receiver, (links,); ``None`` without receivers.
    """

    columns: Mapping[str, Sequence[str]]
    heard: FloatArray | None = None

    def describe(
        self, network: Network, seen: FloatArray, reachable: BoolArray, document: dict[str, Any]
    ) -> tuple[list[str], list[TextTable]]:
        """Return lines and tables, and add the same to a JSON document."""
        lines, tables = [], []
        for name, values in self.columns.items():
            groups = group_sight(network, seen, reachable, values)
            rows = [[value, f"{length / 1000:.2f}", f"{100 * share:.1f}"] for value, length, share in groups]
            tables.append(TextTable((name, "km", "seen %"), rows, right=(1, 2)))
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


def present_plan(
    plan: Plan, title: str, outputs: Outputs, json: bool, sights: Sights, travellers: Sequence[Traveller]
) -> None:
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
    tables: list[str | TextTable] = [
        TextTable(("number", "agent", "release", "hour", "time"), rows, right=(0, 3)),
        TextTable(("net at", "catches %", "mean age", "time of the first release"), caught, right=(1,)),
    ]
    percent = {key: f"{100 * document[key]:.1f} %" for key in ("caught", "coverage", "coverage_with_nets", "recorded")}
    lines = [
        f"{len(plan.members)} bodies see {percent['coverage']} of the {document['reachable_length'] / 1000:.1f} km that water "
        f"from the releases reaches; {percent['coverage_with_nets']} if nets catch them",
        f"nets catch {percent['caught']} of the bodies, which have seen {percent['recorded']}",
        f"share of what nets everywhere could yield: these {100 * plan.value:.1f} %, the best {len(plan.nets)} at most "
        f"{100 * plan.bound:.1f} %, random ones {100 * plan.random:.1f} %",
    ]
    more, groups = sights.describe(network, plan.recorded, plan.reachable, document)
    steps = {network.hydraulics.find_step(hour) for _, _, hour in plan.members}
    chosen = [one for one in travellers if one.name in {name for name, _, _ in plan.members}]
    document["warnings"] = [line for one in chosen for line in warn_of_limits(one, network, plan.alone, steps)]
    lines += [word_passings(plan.passings), *more, *warn_of_pressure(network, sorted(steps)), *document["warnings"]]
    figures = {"Map": partial(plan_svg, plan, title)}
    columns = {"members": plan.member_table(), "nets": plan.net_table(), "links": plan.link_table()}
    written = outputs.write(network, title, figures, [*lines, *tables, *groups], columns, True)
    present(document, [title, *tables, *groups, *lines], written, json)


def present(document: Mapping[str, Any], text: Sequence[str | TextTable], written: Sequence[Path], json: bool) -> None:
    """Print a JSON document, or lines and tables for people, with the files that were written."""
    if json:
        output.print_json({**document, "files": [str(file) for file in written]})
        return
    for part in (*text, *(f"wrote {file}" for file in written)):
        if isinstance(part, str):
            output.print_text(part)
        else:
            output.print_table(*part)


def present_passage(
    passage: Passage, title: str, outputs: Outputs, json: bool, sights: Sights, body: Traveller | None = None
) -> None:
    """Write the files of a passage of a body, or of water, and print it."""
    length = passage.network.length[passage.reachable].sum() / 1000
    lines = [f"sees {100 * passage.coverage:.1f} % of the {length:.1f} km that its water reaches"]
    if body is not None:
        lines.append(word_passings([passage.passings]))
    if passage.stuck:
        lines.append(f"{100 * sum(end.probability for end in passage.stuck):.1f} % end in the pipes")
    ends = [end for end in passage.ends if end.probability >= 5e-5][:MAX_ROWS]
    rows = [[end.kind, end.place, f"{100 * end.probability:.2f}", end.reason] for end in ends]
    tables = [*_table_nodes(passage), TextTable(("ends by", "place", "probability %", "reason"), rows, right=(2,))]
    if len(passage.ends) > len(ends):
        tables.append(f"and {len(passage.ends) - len(ends)} more ends")
    if passage.gates:
        rows = [[link, what, f"{100 * share:.2f}"] for link, (what, share) in passage.gates.items()]
        tables.append(TextTable(("passes", "what", "probability %"), rows[:MAX_ROWS], right=(2,)))
    document = passage.as_document()
    more, groups = sights.describe(passage.network, passage.seen, passage.reachable, document)
    tables += groups
    lines += [*more, *warn_of_pressure(passage.network, passage.steps)]
    if body is not None:
        document["warnings"] = warn_of_limits(body, passage.network, passage.seen, passage.steps)
        lines += document["warnings"]
    if passage.branches:
        document["branches"], sides = _compare_sides(passage)
        tables.append(sides)
    figures = {"Map": partial(passage_svg, passage, title)}
    columns = {"nodes": passage.node_table(), "links": passage.link_table(), "ends": passage.end_table()}
    written = outputs.write(passage.network, title, figures, [*lines, *tables], columns, body is not None)
    present(document, [title, *tables, *lines], written, json)


def present_fleet(
    fleet: Fleet, title: str, outputs: Outputs, json: bool, sights: Sights, travellers: Sequence[Traveller]
) -> None:
    """Write the files of a fleet, and print it."""
    document, size = fleet.as_document(), len(fleet.members)
    kilometres = document["reachable_length"] / 1000
    lines = [
        f"{size} bodies see {100 * fleet.coverage:.1f} % of the {kilometres:.1f} km that water from the releases reaches",
        f"{100 * fleet.gap_closed:.1f} % of the gap from point tracers to perfect steering is closed",
    ]
    if fleet.coverage <= fleet.retained[-1] + 1e-9:
        lines.append(
            "shape brings nothing here: bodies that divide like the water, too wide for service pipes, see as much"
        )
    more, groups = sights.describe(fleet.network, fleet.seen, fleet.reachable, document)
    tables = [_table_members(fleet), _table_curves(fleet), *groups]
    steps = sorted({step for member in fleet.members for step in member.passage.steps})
    passings = word_passings(member.passage.passings for member in fleet.members)
    chosen = [one for one in travellers if one.name in {member.agent for member in fleet.members}]
    document["warnings"] = [line for one in chosen for line in warn_of_limits(one, fleet.network, fleet.seen, steps)]
    lines += [passings, *more, *warn_of_pressure(fleet.network, steps), *document["warnings"]]
    figures = {"Map": partial(fleet_svg, fleet, title), "Coverage": partial(curve_svg, fleet, title)}
    columns = {"members": fleet.member_table(), "curve": fleet.curve_table(), "links": fleet.link_table()}
    written = outputs.write(fleet.network, title, figures, [*lines, *tables], columns, True)
    if outputs.agents is not None:
        written += save_agents(chosen, outputs.agents)
    present(document, [title, *tables, *lines], written, json)


def word_passings(passings: Iterable[Mapping[int, str]]) -> str:
    """Return a line with what bodies were flown through, and why streamtubes divide them at how many junctions."""
    counts = count_passings(passings)
    reasons = ", ".join(f"{reason} {count}" for reason, count in counts["streamtubes"].items())
    total = sum(counts["streamtubes"].values())
    flown = " and ".join(f"{count} {kind}" for kind, count in counts["flown"].items() if count)
    return f"flown through {flown or 'no fittings'}; streamtubes divide bodies at {total}{reasons and f': {reasons}'}"


def _table_nodes(passage: Passage) -> list[str | TextTable]:
    network, probability = passage.network, passage.probability
    order = [node for node in np.flatnonzero(probability > 1e-6).tolist() if node != passage.release]
    order.sort(key=lambda node: (-probability[node], passage.age[node]))
    header, rows = ["node", "probability %", "mean age", "time"], []
    for node in order[:MAX_ROWS]:
        row = [network.nodes[node], f"{100 * probability[node]:.2f}", format_time(passage.age[node])]
        row.append(network.hydraulics.format_clock(passage.hour, passage.age[node]))
        if len(passage.quantiles):
            low, _, high = passage.quantiles[node]
            row.append(f"{format_time(low)} to {format_time(high)}")
        rows.append(row)
    if len(passage.quantiles):
        header.append("9 of 10 arrive after")
    left = [f"and {len(order) - MAX_ROWS} more nodes"] if len(order) > MAX_ROWS else []
    return [TextTable(header, rows, right=(1,)), *left]


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
    return document, TextTable(("branches at", "sees %", "stuck %", "largest change, points"), rows, right=(1, 2))


def _table_members(fleet: Fleet) -> TextTable:
    """Return the members, those that are alike in one row."""
    groups: dict[tuple[str, str, float], list[Member]] = {}
    for member in fleet.members:
        groups.setdefault((member.agent, member.release, member.passage.hour), []).append(member)
    rows = []
    for (agent, release, hour), members in groups.items():
        alone, adds = 100 * members[0].coverage, 100 * sum(member.gain for member in members)
        name = agent if len(agent) <= _MAX_NAME else f"{agent[: _MAX_NAME - 3]}..."
        rows.append([f"{len(members)}", name, release, f"{hour:g}", f"{alone:.1f}", f"{adds:.1f}"])
    header = ("number", "agent", "release", "hour", "alone sees %", "adds %")
    return TextTable(header, rows, right=(0, 3, 4, 5))


def _table_curves(fleet: Fleet) -> TextTable:
    size = len(fleet.curve)
    counts = sorted({count for count in (1, 2, 5, 10, 20, 50, 100) if count < size} | {size})
    curves = (fleet.tracers, fleet.retained, fleet.curve, fleet.choice_bound, fleet.bound)
    rows = [[f"{count}", *(f"{100 * curve[count - 1]:.1f}" for curve in curves)] for count in counts]
    header = ("bodies see %", "tracers", "retained", "fleet", "any choice", "steered")
    return TextTable(header, rows, right=(0, 1, 2, 3, 4, 5))


def write_geojson(
    folder: Path, network: Network, tables: Mapping[str, Mapping[str, Sequence[Any]]], crs: str | None
) -> list[Path]:
    """Write the tables of nodes and links, each as the layer of its name, and return the files.

    Points and lines have the coordinates of the network's file. A ``crs`` is named as GeoJSON of 2008 does, which GDAL
    and QGIS read; in RFC 7946 coordinates are longitude and latitude, and nothing is named.
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
        written.append(folder / f"{name}.geojson")
        files.write_text(written[-1], json.dumps(document, ensure_ascii=False) + "\n")
    return written
