"""The addresses of the page, with the function of the core that each calls."""

import math
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.resources import files
from itertools import islice
from pathlib import Path
from secrets import token_hex
from tempfile import TemporaryDirectory
from threading import Lock, Thread
from typing import Any

import numpy as np
import tomli_w
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route

from driftform import Run, Study, load_study
from driftform.errors import DriftformError, InputError, describe_error
from driftform.figures import scene
from driftform.water import Pipe, Scenario, Segment
from driftform.water.parts import shapes
from driftform_frusta.cores import CORES, CUSTOM
from driftform_frusta.materials import MATERIALS
from driftform_frusta.own.profile import read_profile
from driftform_kit.ballast import MATERIALS as BALLAST
from driftform_studio.draft import check_draft, load_draft, locate_errors, read_agent, read_draft
from driftform_studio.folder import DATABASE, RunsFolder
from driftform_studio.guard import check_values
from driftform_studio.searches import Searches
from driftform_studio.tasks import Tasks

KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
"""Content types of the files of the page."""

REPORT_POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
)
"""A report has a script of its own; in a sandbox it is of no origin, and cannot ask this server for anything."""

MAX_OPEN = 16
"""Runs whose state is kept in memory."""

BEND_STEP = math.radians(4)
"""Angle between two points of the axis of a bend on the page, rad."""

REDUCER_STEPS = 16
"""Pieces of the axis of a reducer on the page."""

Parameters = Mapping[str, str]


class Studio:
    """The answers of the addresses; each method takes the parameters of the path and the document of the request."""

    def __init__(self, folder: RunsFolder, given: Path) -> None:
        self.folder = folder
        self.given = given
        self.searches = Searches()
        self.tasks = Tasks()
        self._made = TemporaryDirectory(prefix="driftform-studio-")
        self._open: OrderedDict[str, Any] = OrderedDict()
        self._lock = Lock()
        self._is_warm = False

    def close(self) -> None:
        """Remove the files made for downloads; searches continue."""
        self.tasks.close()
        self._made.cleanup()

    def find(self, parameters: Parameters) -> Any:
        """Return the run that an address names. Raises InputError if it does not exist."""
        from driftform_studio.live import LiveRun

        name = parameters["run"]
        # At each use: a link may have been laid since the run was opened.
        directory = self.folder.find(name)
        with self._lock:
            if name not in self._open or not self._open[name].exists():
                self._open[name] = LiveRun(directory)
            self._open.move_to_end(name)
            while len(self._open) > MAX_OPEN:
                self._open.popitem(last=False)
            return self._open[name]

    def begin(self, parameters: Parameters, document: Any) -> Any:
        """Return the contents of an empty page: the built-in scenarios with every default filled in."""
        presets = []
        for name in Study.list_scenarios():
            try:
                study = load_study(name)
            except InputError:
                continue  # Its plugin is not installed.
            presets.append({"name": name, "title": study.title or name, "document": study.document})
        presets.sort(key=lambda preset: preset["name"] != "pipe-inspection")
        return {
            "folder": str(self.given),
            "presets": presets,
            "flows": {kind: _list_fields(rows) for kind, rows in Scenario.describe_flows().items()},
            "parts": {kind: _list_fields(rows) for kind, rows in Pipe.describe_parts().items()},
            "tables": {name: _list_fields(rows) for name, rows in Scenario.describe_tables().items()},
            "materials": {name: material.density for name, material in MATERIALS.items()},
            "ballast": BALLAST,
            "cores": [{"name": name, "radius": c.radius, "mass": c.mass} for name, c in CORES.items()],
        }

    def keep_file(self, parameters: Parameters, document: Any) -> Any:
        """Keep a file that is given to a design, and return the path that its study has."""
        if not isinstance(document, dict):
            raise InputError("the request is not a table")
        file = self.folder.keep_file(document.get("name"), document.get("content"))
        if document.get("key") != "builder.core":
            return {"file": str(file)}
        try:
            return {"file": str(file), "length": read_profile(file).length}
        except InputError as error:
            raise InputError(str(error).replace(str(file), file.name)) from None

    def _load(self, document: Any) -> tuple[dict[str, Any], str]:
        """Return a draft and its text; it may name only files that were given to designs."""
        draft = check_draft(document)
        self._check_files(draft)
        return draft, tomli_w.dumps(draft)

    def _check_files(self, study: Mapping[str, Any]) -> None:
        flow = study.get("flow")
        if isinstance(flow, dict) and "file" in flow:
            self.folder.check_file(flow["file"])
        builder = study.get("builder")
        core = builder.get("core", CUSTOM) if isinstance(builder, dict) else CUSTOM
        if core not in (CUSTOM, *CORES):
            self.folder.check_file(core)

    def open_design(self, parameters: Parameters, document: Any) -> Any:
        """Return the draft that a study file holds; of an agent's file make a run with this agent, and return the name of both."""
        if not isinstance(document, dict) or not isinstance(text := document.get("text"), str):
            raise InputError("the request has no text")
        name = str(document.get("name"))
        if not name.lower().endswith(".json"):
            return {"draft": read_draft(text, name)}
        stored, study = read_agent(text, self._check_files)
        directory = self.folder.make_run_directory(stored.name)
        with Run.create(directory, study):
            # The name of the run is none of a target, as that of the agent may be.
            (picked := directory / "picks" / directory.name).mkdir(parents=True)
            stored.write(picked / "agent.json")
        return {"run": directory.name}

    def check(self, parameters: Parameters, document: Any) -> Any:
        """Check a draft: its study file, its outline, and its errors at the keys that caused them."""
        draft, text = self._load(document)
        try:
            study = load_draft(text)
        except InputError as error:
            errors = locate_errors([str(line) for line in error.args], text)
            try:
                # Without targets, so that those that are wrong can be moved.
                outline = _outline(load_draft(tomli_w.dumps({**draft, "targets": {}})).scenario)
            except InputError:
                outline = None
            return {"text": text, "errors": errors, "outline": outline}
        if not self._is_warm:
            # The modules of the next requests are imported after the first answer.
            self._is_warm = True
            Thread(target=import_module, args=("driftform_studio.agents",), daemon=True).start()
        outline = _outline(study.scenario)
        return {"text": text, "errors": [], "outline": outline, "evaluations": study.evaluations}

    def examine(self, parameters: Parameters, document: Any) -> Any:
        """Return the slow facts of a sound draft: the current over the section, and warnings."""
        study = load_draft(self._load(document)[1])
        return {"scene": _scene(study.scenario), "warnings": study.list_warnings()}

    def list_runs(self, parameters: Parameters, document: Any) -> Any:
        """Return the runs of the folder, the newest first."""
        rows = []
        for path in self.folder.list_runs():
            row: dict[str, Any] = {"name": path.name, "changed": (path / DATABASE).stat().st_mtime}
            try:
                facts = Run.glance(path)
            except DriftformError as error:
                rows.append(row | {"state": "damaged", "problem": describe_error(error)})
                continue
            ended = "finished" if facts["done"] >= facts["budget"] else "paused"
            is_busy = facts.pop("is_worked_on") or self.searches.is_alive(path)
            rows.append(row | {"state": "running" if is_busy else ended, **facts})
        return {"runs": sorted(rows, key=lambda row: -row["changed"]), "folder": str(self.given)}

    def create(self, parameters: Parameters, document: Any) -> Any:
        """Make a run of a draft, and begin its search."""
        if not isinstance(document, dict):
            raise InputError("the request is not a table")
        draft, text = self._load(document.get("draft"))
        study = load_draft(text)
        study.check_search()
        if "seed" not in draft.get("run", {}):
            # The study file that the run keeps gives the same run again.
            draft = {**draft, "run": {**draft.get("run", {}), "seed": study.seed}}
            study = load_draft(tomli_w.dumps(draft))
        directory = self.folder.make_run_directory(str(document.get("name", "")) or "pipe")
        with Run.create(directory, study):
            pass
        self.searches.start(directory)
        return {"run": directory.name}

    def show_run(self, parameters: Parameters, document: Any) -> Any:
        """Return the fixed facts of a run: its study, surroundings and commands."""
        live = self.find(parameters)
        run = live.run
        scenario = run.study.scenario
        paths = []
        if scenario.pipe.is_open:
            # No pipe gives the scene an extent: a flight does.
            with run.read() as store:
                paths = [trajectory.position for _, trajectory in islice(store.read_trajectories(), 1)]
        return {
            "run": live.directory.name,
            "path": str(self.given / live.directory.name),
            "title": run.study.title,
            "document": run.study.document,
            "text": self.folder.read_text(live.directory, "study.toml"),
            "outline": _outline(scenario),
            "scene": _scene(scenario, paths),
            "conditions": scenario.robustness.conditions,
            "picks": sorted(path.parent.name for path in live.directory.glob("picks/*/agent.json")),
        }

    def pause(self, parameters: Parameters, document: Any) -> Any:
        """Ask the search of a run to pause."""
        self.searches.pause(self.find(parameters).directory)
        return {}

    def resume(self, parameters: Parameters, document: Any) -> Any:
        """Continue the search of a run, with more flights if the document has ``more``."""
        live = self.find(parameters)
        more = document.get("more", 0) if isinstance(document, dict) else 0
        if not isinstance(more, int) or more < 0:
            raise InputError(f"more = {more!r}: should be a number of flights")
        budget = Run.glance(live.directory)["budget"]
        self.searches.start(live.directory, budget + more if more else None)
        return {}

    def begin_work(self, parameters: Parameters, document: Any) -> Any:
        """Return a task on a run or on an agent: what :data:`driftform_studio.agents.WORK` has by its name."""
        from driftform_studio.agents import WORK, export_agent

        name = parameters.get("work", "show")
        if not isinstance(document, dict) or name not in (*WORK, "make"):
            raise InputError(f"the request to {name} is not a table, or unknown")
        live, key = self.find(parameters), parameters.get("agent", "")

        def make() -> dict[str, str]:
            folder = Path(self._made.name) / token_hex(8)
            folder.mkdir()
            file = export_agent(live.find_agent(key), parameters["kind"], folder, document.get("ballast"))
            sheets = {path.suffix[1:] for path in folder.glob("*-assembly-1.*")}
            return {"made": folder.name, "file": file.name, "sheet": "pdf" if "pdf" in sheets else "".join(sheets)}

        return {"task": self.tasks.start(make if name == "make" else lambda: WORK[name](live, key, document))}

    def take_made(self, parameters: Parameters, document: Any) -> Response:
        """Answer with a file that a task made."""
        folder = Path(self._made.name)
        known = {f"{path.parent.name}/{path.name}": path for path in folder.glob("*/*")}
        path = known.get(f"{parameters['made']}/{parameters['file']}")
        if path is None:
            raise InputError("this file is gone: make it once more")
        return FileResponse(path, filename=path.name, media_type="application/octet-stream")

    def take_report(self, parameters: Parameters, document: Any) -> Response:
        """Answer with the report of a run, in a sandbox."""
        live = self.find(parameters)
        path = live.directory / "report.html"
        if not path.is_file() or path.is_symlink():
            raise InputError(f"{live.directory.name}: has no report yet")
        headers = {"content-security-policy": REPORT_POLICY}
        return FileResponse(path, media_type="text/html", headers=headers)

    def take_section(self, parameters: Parameters, document: Any) -> Response:
        """Answer with the drawing of an agent's section."""
        design = self.find(parameters).find_agent(parameters["agent"])
        return Response(design._repr_svg_(), media_type="image/svg+xml")


def make_app(studio: Studio) -> Starlette:
    """Return the application without its guard."""
    run, agent = "/api/runs/{run}", "/api/runs/{run}/agents/{agent}"
    answers: list[tuple[str, str, Callable[[Parameters, Any], Any]]] = [
        ("GET", "/api/begin", studio.begin),
        ("POST", "/api/check", studio.check),
        ("POST", "/api/examine", studio.examine),
        ("POST", "/api/files", studio.keep_file),
        ("POST", "/api/designs", studio.open_design),
        ("GET", "/api/runs", studio.list_runs),
        ("POST", "/api/runs", studio.create),
        ("GET", run, studio.show_run),
        ("GET", f"{run}/status", lambda given, _: studio.find(given).read_status(studio.searches)),
        (
            "GET",
            f"{run}/flights/{{evaluation:int}}",
            lambda given, _: {"path": studio.find(given).read_path(int(given["evaluation"]))},
        ),
        ("POST", f"{run}/pause", studio.pause),
        ("POST", f"{run}/resume", studio.resume),
        ("POST", f"{run}/{{work}}", studio.begin_work),
        ("POST", agent, studio.begin_work),
        ("POST", f"{agent}/{{work}}", studio.begin_work),
        ("POST", f"{agent}/{{work}}/{{kind}}", studio.begin_work),
        ("GET", "/api/tasks/{task}", lambda given, _: studio.tasks.find(given["task"])),
        ("GET", "/take/made/{made}/{file}", studio.take_made),
        ("GET", "/take/{run}/report.html", studio.take_report),
        ("GET", "/take/{run}/agents/{agent}/section.svg", studio.take_section),
    ]
    folder = files("driftform_studio").joinpath("page")
    page = {file.name: file.read_bytes() for file in folder.iterdir() if Path(file.name).suffix in KINDS}
    page["viewer.js"] = scene.read_viewer().encode()

    async def serve(request: Request) -> Response:
        name = request.url.path.rpartition("/")[2] or "index.html"
        return Response(page[name], media_type=KINDS[Path(name).suffix])

    routes = [Route(path, _answer(function), methods=[method]) for method, path, function in answers]
    names = ("" if name == "index.html" else name for name in page)
    return Starlette(routes=[*routes, *(Route(f"/{name}", serve, methods=["GET"]) for name in names)])


def _answer(function: Callable[[Parameters, Any], Any]) -> Callable[[Request], Any]:
    """Return an endpoint that answers with a document or a file, or with the lines of an error."""

    async def endpoint(request: Request) -> Response:
        try:
            document = await request.json() if request.method == "POST" else None
        except (ValueError, RecursionError):
            return _refuse(400, "the request is not JSON")
        try:
            check_values(document)
            check_values(request.path_params)
            answer = await run_in_threadpool(function, request.path_params, document)
        except DriftformError as error:
            return _refuse(422, *error.args)
        except Exception as error:
            return _refuse(500, describe_error(error, with_place=True))
        return answer if isinstance(answer, Response) else JSONResponse(answer)

    return endpoint


def _refuse(status: int, *lines: object) -> JSONResponse:
    return JSONResponse({"errors": [str(line) for line in lines]}, status)


def _outline(scenario: Any) -> dict[str, Any]:
    """Return a scenario for the side view: pipe, openings, release, targets, current, free surface.

    The axis of each part of the pipe is a line through points with a radius at each; openings look outward, the inlet
    first. ``pipe`` is the pipe as one straight segment, empty for other pipes.
    """
    pipe = scenario.pipe
    straight, outlets = pipe.straight, pipe.layout.outlets
    ends = [] if pipe.is_open else [(pipe.layout.inlet, -1), *((outlet.opening, 1) for outlet in outlets)]
    targets = scenario.target_points().items()
    return {
        "pipe": [straight.model_dump(mode="json")] if straight else [],
        "axes": [
            {
                "part": placed.name,
                "branch": bool(number),
                "points": np.round(axis.points, 6).tolist(),
                "radii": np.round(axis.radii, 6).tolist(),
            }
            for placed in pipe.layout.parts
            for number, axis in enumerate(placed.part.list_axes(_axis_step(placed.part)))
        ],
        "openings": [
            {"centre": end.centre.tolist(), "direction": (sign * end.axes[0]).tolist(), "radius": end.radius}
            for end, sign in ends
        ],
        "outlets": [outlet.name for outlet in outlets],
        "release": scenario.release_position().tolist(),
        "targets": [{"name": name, "position": list(point)} for name, point in targets],
        "current": scenario.current().tolist(),
        "water": scenario.fluid.water_level,
    }


def _axis_step(part: Any) -> float:
    """Return the distance at which points of the axis of a part are drawn, m: two points for a straight axis of one bore."""
    if isinstance(part, shapes.Bend):
        return part.bend_radius * BEND_STEP
    return part.length / REDUCER_STEPS if isinstance(part, shapes.Reducer) else math.inf


def _scene(scenario: Any, paths: Any = ()) -> dict[str, Any]:
    """Return the scene of the 3-D view, and the profile of the current at the inlet, empty without a pipe."""
    found = scene.scene_data(scenario, paths)
    pipe, profile = scenario.pipe, found["pipe"]
    if not profile and not pipe.is_open and isinstance(pipe.layout.parts[0].part, shapes.Straight):
        # The first part carries the profile of a straight pipe.
        start, end = pipe.layout.inlet.centre, pipe.layout.parts[0].part.list_exits()[0].centre
        inlet = Segment(start=tuple(start.tolist()), end=tuple(end.tolist()), radius=pipe.layout.inlet.radius)
        straight = scenario.model_copy(update={"pipe": Pipe(segments=(inlet,)), "targets": {}})
        profile = scene.scene_data(straight)["pipe"]
    return {**found, "profile": profile[0]["speeds"] if profile else []}


def _list_fields(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [{**row, "default": str(row["default"])} for row in rows if row["option"] != "kind"]
