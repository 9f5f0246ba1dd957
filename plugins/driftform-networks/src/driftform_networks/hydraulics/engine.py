"""Solves a network file by EPANET: the only module that imports it, for a process that a damaged file may end."""

import tomllib
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from driftform.errors import InputError, did_you_mean

NODE_KINDS = ("junction", "reservoir", "tank")
LINK_KINDS = ("cv", "pipe", "pump", "prv", "psv", "pbv", "fcv", "tcv", "gpv", "pcv")
"""Kinds by EPANET's numbers; ``cv`` is a pipe with a check valve."""

LITRES: dict[str, float] = tomllib.loads(Path(__file__).with_name("units.toml").read_text(encoding="utf-8"))
"""Litres/s of EPANET's units of flow, in the order of its numbers; the first five go with feet and inches."""

MAX_STEPS, MAX_VALUES = 100_000, 100_000_000
"""Most hydraulic steps, and most values in all of them together (0.8 GB)."""

_ELEVATION, _BASE_DEMAND, _DEMAND, _HEAD = 0, 1, 9, 10
_DIAMETER, _LENGTH, _FLOW, _STATUS, _SETTING = 0, 1, 8, 11, 12
_OPENED = "__opened__"
_DURATION, _STEP, _CLOCK, _MULTIPLIER, _GRAVITY, _PRESSURE = 0, 1, 10, 4, 12, 25
"""Codes of the EPANET toolkit."""


class _Project:
    """A file that EPANET has opened."""

    def __init__(self, file: Path) -> None:
        import epanet

        self._library, self.warnings = epanet, dict[str, None]()
        self._handle = epanet.EN_createproject()[1]
        try:
            self("open", str(file), str(file.with_suffix(".rpt")), "")
        except InputError:
            # EPANET writes the rest of its report when it closes the file.
            epanet.EN_close(self._handle)
            raise
        self("setstatusreport", 0)

    def __call__(self, name: str, *arguments: Any) -> Any:
        """Call a function of the toolkit; its first value is an error beyond 100, and a warning below."""
        code, *values = getattr(self._library, f"EN_{name}")(self._handle, *arguments)
        if code:
            said = self._library.EN_geterror(code)[1].removeprefix("WARNING: ").strip()
            if code > 100:
                raise InputError(f"Error {code}: {said.removeprefix(f'Error {code}: ')}")
            self.warnings[said] = None
        return values[0] if len(values) == 1 else values

    def list_all(self, name: str, count: int) -> list[Any]:
        """Return the values of a function for all nodes or links."""
        return [self(name, index) for index in range(1, count + 1)]

    def find(self, option: str, kind: str, name: str) -> int:
        """Return the number of a node or link that an option names."""
        try:
            return int(self(f"get{kind}index", name))
        except InputError:
            count = self("getcount", 0 if kind == "node" else 2)
            known = did_you_mean(name, self.list_all(f"get{kind}id", count)) if count < 5000 else ""
            raise InputError(f"{option} {name}: no such {kind}{known if 'known' not in known else ''}") from None


def solve(file: str, changes: dict[str, Any]) -> dict[str, Any]:
    """Return what EPANET computes for a file, as arrays in SI units; write its report and the percent done next to the file.

    Args:
        changes: :class:`driftform_networks.hydraulics.epanet.Changes` as plain values.

    Raises InputError if EPANET refuses the file or cannot solve it, in its words.
    """
    project, done = _Project(Path(file)), Path(file).with_suffix(".percent")
    nodes, links = project("getcount", 0), project("getcount", 2)
    units = project("getflowunits")
    metre, bore = (0.3048, 0.0254) if units < 5 else (1.0, 0.001)
    litre = list(LITRES.values())[units]
    found = _describe(project, nodes, links, metre, bore)
    fixed = _change(project, changes, litre, found)
    duration, step = project("gettimeparam", _DURATION), project("gettimeparam", _STEP)
    most = min(MAX_STEPS, MAX_VALUES // max(2 * nodes + links, 1))
    if duration / max(step, 1) > most:
        raise InputError(
            f"the simulation lasts {duration / 3600:g} h in hydraulic steps of {step} s; at most {most} steps are read: "
            "shorten Duration in [TIMES]"
        )
    times, states, shown = list[int](), list[tuple[Any, ...]](), 0
    project("openH")
    project("initH", 0)
    while True:
        for link, status, setting in fixed:
            project("setlinkvalue", link, _STATUS, status)
            if setting is not None:
                project("setlinkvalue", link, _SETTING, setting)
        time = project("runH")
        state = (
            project("getlinkvalues_NPY", _FLOW) * litre / 1000,
            project("getnodevalues_NPY", _DEMAND) * litre / 1000,
            project("getnodevalues_NPY", _HEAD) * metre,
        )
        left, percent = project("nextH"), 100 * time // max(duration, 1)
        if percent > shown:
            done.write_text(f"{percent}", encoding="utf-8")
            shown = percent
        # The state at the end of the simulation holds for no time.
        if left > 0 or not times:
            times.append(time)
            states.append(state)
        if left <= 0:
            break
        if len(times) > most:
            raise InputError(f"more than {most} hydraulic steps: shorten Duration in [TIMES]")
    flow, outflow, head = map(np.array, zip(*states, strict=True))
    return found | {
        "hydraulics.times": np.array(times, float),
        "hydraulics.end": float(time),
        "hydraulics.clock": float(project("gettimeparam", _CLOCK)),
        "hydraulics.flow": flow,
        "hydraulics.outflow": outflow,
        "hydraulics.head": head,
        "hydraulics.warnings": np.array(list(project.warnings), np.str_),
    }


def _describe(project: _Project, nodes: int, links: int, metre: float, bore: float) -> dict[str, Any]:
    """Return names, ends and sizes."""
    names, kinds = project.list_all("getnodeid", nodes), project.list_all("getnodetype", nodes)
    sorts = project.list_all("getlinktype", links)
    drawn = np.array([kind < 2 for kind in sorts])
    sizes = {
        "elevation": np.array(project("getnodevalues_NPY", _ELEVATION) * metre),
        "length": np.where(drawn, project("getlinkvalues_NPY", _LENGTH) * metre, 0.0),
        "diameter": np.where(np.array(sorts) == 2, 0.0, project("getlinkvalues_NPY", _DIAMETER) * bore),
    }
    ends = np.array(project.list_all("getlinknodes", links), np.int64).reshape(-1, 2) - 1
    ids = project.list_all("getlinkid", links)
    demand = project("getnodevalues_NPY", _BASE_DEMAND)
    for what, values in (sizes | {"demand": demand}).items():
        owners = names if what in ("elevation", "demand") else ids
        for row in np.flatnonzero(~(np.abs(values) < 1e7)).tolist():
            raise InputError(f"the {what} of {owners[row]} is {values[row]:g}")
    places, corners = np.full((nodes, 2), np.nan), list[list[tuple[float, float]]]()
    for row in range(nodes):
        code, *place = project._library.EN_getcoord(project._handle, row + 1)
        if code == 0 and np.isfinite(place).all() and np.abs(place).max() < 1e12:
            places[row] = place
    for link, count in enumerate(project.list_all("getvertexcount", links), start=1):
        corners.append([project("getvertex", link, number) for number in range(1, count + 1)])
    return {
        "nodes": np.array(names, np.str_),
        "node_kinds": np.array([NODE_KINDS[kind] for kind in kinds], np.str_),
        "links": np.array(ids, np.str_),
        "link_kinds": np.array([LINK_KINDS[kind] for kind in sorts], np.str_),
        "start": ends[:, 0],
        "end": ends[:, 1],
        "places": places,
        "vertices": np.array(list(chain.from_iterable(corners)), float).reshape(-1, 2),
        "counts": np.array(list(map(len, corners)), np.int64),
        **sizes,
    }


def _change(
    project: _Project, changes: dict[str, Any], litre: float, found: dict[str, Any]
) -> list[tuple[int, int, float | None]]:
    """Change demands, and return links whose status, and perhaps setting, are held in each step, whatever controls say."""
    # psi, kPa, metres, bar and feet: EPANET's own factors, of water of the specific gravity of the file.
    gravity = project("getoption", _GRAVITY)
    per_foot = (0.4333 * gravity, 6.895 * 0.4333 * gravity, 0.3048, 0.068948 * 0.4333 * gravity, 1.0)
    metre = 0.3048 / per_foot[int(project("getoption", _PRESSURE))]
    fixed: list[tuple[int, int, float | None]] = []
    for name in changes.get("close", ()):
        link = project.find("--close", "link", name)
        if found["link_kinds"][link - 1] == "cv":
            link = project("setlinktype", link, 1, 0)
        fixed.append((link, 0, None))
    for name, value in changes.get("valves", {}).items():
        link = project.find("--set-valve", "link", name)
        kind = str(found["link_kinds"][link - 1])
        if kind not in LINK_KINDS[3:] or (kind == "gpv" and not isinstance(value, str)):
            raise InputError(f"--set-valve {name}: not a valve with a setting, but a {kind}")
        if isinstance(value, str):
            fixed.append((link, int(value == "open"), None))
        else:
            unit = {"prv": metre, "psv": metre, "pbv": metre, "fcv": litre}.get(kind, 1.0)
            fixed.append((link, 1, value / unit))
    if changes.get("open"):
        # A pattern that no multiplier changes.
        project("addpattern", _OPENED)
    for name, litres in changes.get("open", {}).items():
        node = project.find("--open", "node", name)
        if found["node_kinds"][node - 1] != "junction":
            raise InputError(f"--open {name}: it is a {found['node_kinds'][node - 1]}: water is drawn at junctions")
        project("adddemand", node, litres / litre / project("getoption", _MULTIPLIER), _OPENED, _OPENED)
    for link, _, _ in fixed:
        for control in range(1, project("getcount", 5) + 1):
            if project("getcontrol", control)[1] == link:
                project("setcontrolenabled", control, 0)
    return fixed
