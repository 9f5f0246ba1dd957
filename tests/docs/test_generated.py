"""Pages, and parts of pages, that are made from the program. ``UPDATE_DOCS=1 pytest tests/docs`` rewrites them."""

import ast
import inspect
import re
import subprocess
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import metadata
from itertools import chain
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import pytest
import typer
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from driftform.cli.app import Commands, app
from driftform.interfaces import SEAMS
from driftform.plugins.registry import Contribution, registry
from driftform.study import RunOptions
from driftform.util.options import describe_bounds, find_table
from driftform.util.validity import RANGES
from driftform.water import Scenario
from driftform.water.flow import FLOWS
from driftform.water.fluids import FLUIDS
from driftform.water.parts.tables import PARTS as PIPE_PARTS
from driftform_frusta.materials import MATERIALS

Check = Callable[[Path, str], None]

ROOT = Path(__file__).parents[2]


# Values of a model, in words.


def type_text(annotation: Any) -> str:
    """A type as a person writes it: ``float``, ``"first"`` or ``"last"``, ``[float, float, float]``."""
    if get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        return " or ".join(f'`"{value}"`' for value in arguments)
    if origin in (Union, UnionType):
        return " or ".join(dict.fromkeys(type_text(a) for a in arguments if a is not NoneType))
    if origin is tuple:
        if len(arguments) == 2 and arguments[1] is Ellipsis:
            return f"list of {type_text(arguments[0])}s"
        return "[" + ", ".join(type_text(a) for a in arguments) + "]"
    if origin is dict or (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
        return "table"
    names = {str: "string", int: "integer", float: "number", bool: "boolean"}
    return names.get(annotation, getattr(annotation, "__name__", str(annotation)))


def default_text(field: FieldInfo) -> str:
    """The default as a study file would say it."""
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    return "none" if value is None else f"`{toml_text(value)}`"


def toml_text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple | list):
        return "[" + ", ".join(toml_text(item) for item in value) + "]"
    return repr(value)


def keys_table(model: type[BaseModel]) -> list[str]:
    """One row for each field of a model, and of the tables of options within it."""
    return ["| key | type | default | unit | meaning |", "|---|---|---|---|---|", *keys_rows(model)]


def keys_rows(model: type[BaseModel], within: str = "") -> list[str]:
    lines = []
    for name, field in model.model_fields.items():
        extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
        kind = ", ".join(part for part in (type_text(field.annotation), describe_bounds(field)) if part)
        cells = (f"`{within}{name}`", kind, default_text(field), str(extra.get("unit", "")), field.description or "")
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        if get_origin(field.annotation) is UnionType and (table := find_table(field.annotation)):
            lines += keys_rows(table, f"{within}{name}.")
    return lines


def markdown(docstring: str) -> str:
    """A docstring as Markdown: roles and double backticks become single ones."""
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", inspect.cleandoc(docstring))
    return text.replace("``", "`")


# docs/cli.md


def commands(command: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """A command and those below it, those of plugins after those of the core."""
    yield path, command
    added = command.list_added() if isinstance(command, Commands) else {}
    for name, child in {**getattr(command, "commands", {}), **added}.items():
        yield from commands(child, (*path, name))


def value_text(parameter: Any) -> str:
    """What stands for the value of an option or argument, ``""`` for a flag."""
    if getattr(parameter, "is_flag", False):
        return ""
    if parameter.metavar:
        return str(parameter.metavar).strip("[]") if parameter.metavar.count("[") == 1 else parameter.metavar
    annotation = getattr(getattr(parameter, "type_descriptor", None), "annotation", None)
    kind = getattr(getattr(parameter, "type", None), "name", "")
    return "N" if annotation is int or kind.startswith("integer") else "VALUE"


def parameter_default(parameter: Any) -> str:
    if getattr(parameter, "is_flag", False) or parameter.default is None or parameter.default is Ellipsis:
        return "required" if parameter.required else ""
    return f"`{parameter.default}`"


def is_argument(parameter: Any) -> bool:
    return not parameter.opts[0].startswith("-")


def command_section(path: tuple[str, ...], command: Any) -> list[str]:
    arguments = [p for p in command.params if is_argument(p)]
    options = [p for p in command.params if not is_argument(p)]
    usage = ["driftform", *path]
    usage += [value_text(p) if p.required else f"[{value_text(p)}]" for p in arguments]
    usage += [f"{p.opts[0]} {value_text(p)}" for p in options if p.required]
    usage += ["[OPTIONS]"] if any(not p.required for p in options) else []
    usage += ["[COMMAND]"] if getattr(command, "commands", {}) else []
    lines = [f"{'#' * (1 + max(1, len(path)))} driftform {' '.join(path)}".rstrip(), ""]
    lines += [markdown(command.help or ""), "", "```text", " ".join(usage), "```", ""]
    if command.params:
        lines += ["| argument or option | default | what it does |", "|---|---|---|"]
        for p in (*arguments, *options):
            name = value_text(p) if is_argument(p) else f"{', '.join(p.opts)} {value_text(p)}".strip()
            cells = (f"`{name}`", parameter_default(p), p.help or "")
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return lines


def cli_page(text: str) -> str:
    """The page with the generated part of each command made anew; what is written by hand follows each of them."""
    for path, command in commands(typer.main.get_command(app)):
        if path:
            text = with_generated(text, " ".join(path), command_section(path, command)[:-1])
    return text


@pytest.mark.peers
def test_cli_page(docs: Path, up_to_date: Check) -> None:
    page = docs / "cli.md"
    text = page.read_text(encoding="utf-8")
    up_to_date(page, cli_page(text))
    every = [" ".join(path) for path, _ in commands(typer.main.get_command(app)) if path]
    assert re.findall("<!-- generated: (.+) -->", text) == every


def test_every_command_and_option_has_help() -> None:
    bare = []
    for path, command in commands(typer.main.get_command(app)):
        if not command.help:
            bare.append(" ".join(path))
        bare += [f"{' '.join(path)} {p.opts[0]}" for p in command.params if not p.help]
    assert bare == []


# docs/plugins.md and docs/plugins


@dataclass(frozen=True)
class Distribution:
    """A distribution of this repository: its table in ``pyproject.toml``, and what it brings to the seams."""

    project: dict[str, Any]
    rows: list[Contribution]

    @property
    def name(self) -> str:
        return str(self.project["name"])

    @property
    def page(self) -> str:
        """Name of its page in ``docs/plugins``; that of the core is ``core``."""
        return self.name.removeprefix("driftform-").replace("driftform", "core")


def distributions() -> list[Distribution]:
    """The core and the plugins of this repository, with their contributions in the order of the seams."""
    files = [ROOT / "pyproject.toml", *sorted(ROOT.glob("plugins/*/pyproject.toml"))]
    found = [row for seam in SEAMS for row in registry().contributions() if row.seam == seam and row.cls]
    projects = [tomllib.loads(path.read_text(encoding="utf-8"))["project"] for path in files]
    return [Distribution(p, [row for row in found if row.distribution == p["name"]]) for p in projects]


EXTRAS = """\
## Extras and licences

`pip install driftform` installs the plugins of the default study, and in a clone `uv run` does. The others, and what
some formats need, are extras: `uv sync --extra robotics --extra film` in a clone of driftform, elsewhere
`pip install "driftform[robotics,film]"`. In a clone the next `uv sync` removes what it does not name.

| extra | what it adds | packages | their licence |
|---|---|---|---|
| `film` | films by `renderer exudyn` | imageio-ffmpeg | BSD-2-Clause; the ffmpeg in it is built with `--enable-gpl --enable-version3` and under the GPL, version 3 or later |
| `ribs` | `strategy ribs` | driftform-ribs, ribs | MIT |
| `robotics` | the recorders, exporters and fitness of driftform-robotics | driftform-robotics, rosbags | MIT, Apache-2.0 |
| `ros` | `driftform ros`, live flights on ROS 1, which comes from the system | driftform-ros, driftform-robotics | MIT |
| `parquet` | tables in Parquet | pyarrow | Apache-2.0 |
| `dask` | runs on a cluster | distributed | BSD-3-Clause |
| `step` | `exporter step` | cadquery-ocp-novtk | Apache-2.0; the Open CASCADE in it is under the LGPL 2.1 with an exception |
| `png` | PNG of every figure | resvg-py | MIT |
| `pdf` | assembly sheets as PDF; needs the Cairo library of the system | cairosvg | LGPL-3.0 or later |
| `netcdf` | `flow.kind = "grid"` from NetCDF files | netCDF4 | MIT |
| `vtk` | `flow.kind = "grid"` from VTK files, legacy and XML; 0.6 GB | vtk | BSD-3-Clause |
| `networks` | `driftform network show` and the like: pipe networks from EPANET files | driftform-networks, epanet-plus | MIT |
| `studio` | `driftform studio`, a page in the browser | driftform-studio, starlette, uvicorn | MIT, BSD-3-Clause |

driftform and its plugins are under the MIT licence. Exudyn has a licence of its own, the EXUDYN General License 1.0,
which permits use and redistribution if its notice is kept, and forbids endorsement in the names of its authors. The
other packages that driftform and these plugins name are under an MIT, BSD or Apache licence; those have needs of their
own.

Only the tests of the group `peers` compare with Drake, which installs the proprietary solver Mosek; they call no solver
of it, and nothing that users install depends on it.
""".splitlines()


def index_page() -> str:
    lines = [
        "# Plugins that come with driftform",
        "",
        "Generated from the program: `driftform plugins show NAME` prints the description and the options of any installed",
        "plugin. A study file selects a plugin by its name and sets its options in the table of its seam",
        "([study-files.md](study-files.md)). Commands select exporters, recorders, renderers and checkers by name; their",
        "options are in tables such as `[exporter.stl]` and `[checker.mesh]`.",
        "[write-a-plugin.md](write-a-plugin.md) explains how to write one.",
        "",
        "| distribution | what it is | seams and names |",
        "|---|---|---|",
    ]
    for d in distributions():
        names = [f"{seam} " + ", ".join(links) for seam, links in links_of(d).items()]
        lines.append(f"| [{d.name}](plugins/{d.page}.md) | {description(d)} | {'; '.join(names)} |")
    return "\n".join([*lines, "", *EXTRAS]).rstrip() + "\n"


def links_of(d: Distribution) -> dict[str, list[str]]:
    """Links to the plugins of a distribution, by seam."""
    links: dict[str, list[str]] = {}
    for row in d.rows:
        links.setdefault(row.seam, []).append(f"[`{row.name}`](plugins/{d.page}.md#{row.seam}-{row.name})")
    return links


def description(d: Distribution) -> str:
    if d.page == "core":
        return "The plugins of the core"
    return re.sub(r"[,;] a driftform plugin$", "", str(d.project["description"]).removesuffix("."))


def plugin_page(d: Distribution) -> str:
    core = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    included = d.page == "core" or any(need.startswith(f"{d.name}==") for need in core["dependencies"])
    extras = [e for e, n in core["optional-dependencies"].items() if any(x.startswith(f"{d.name}==") for x in n)]
    lines = [f"# {d.name}", "", f"{description(d)}.".capitalize() if d.page == "core" else f"{description(d)}.", ""]
    if included:
        lines.append("`pip install driftform` installs it.")
    elif extras:
        lines.append(f'The extra installs it: `pip install "driftform[{extras[0]}]"`.')
    else:
        lines.append(f"`pip install {d.name}` installs it.")
    lines[-1] += " [All plugins](../plugins.md)."
    package = d.name.replace("-", "_")
    added = [
        f"`driftform {' '.join(path)}`"
        for path, command in commands(typer.main.get_command(app))
        if path and str(getattr(command.callback, "__module__", "")).split(".")[0] == package != "driftform"
    ]
    if added:
        lines += ["", f"It adds {', '.join(added)} to the [command line](../cli.md)."]
    for row in d.rows:
        assert row.cls is not None
        lines += ["", f"## {row.seam} {row.name}", "", markdown(row.cls.__doc__ or ""), ""]
        if row.cls.Options.model_fields:
            lines += keys_table(row.cls.Options)
        else:
            lines.append("It has no options.")
        endings = (getattr(row.cls, "suffix", ""), *getattr(row.cls, "suffixes", ()))
        if told := " or ".join(f"`{ending}`" for ending in endings if ending):
            lines += ["", f"Its files end in {told}."]
        if told := " or ".join(f"`{ending}`" for ending in getattr(row.cls, "stills", ())):
            lines += ["", f"Its stills end in {told}."]
    return "\n".join(lines) + "\n"


@pytest.mark.peers
def test_index_of_plugins(docs: Path, up_to_date: Check) -> None:
    up_to_date(docs / "plugins.md", index_page())


@pytest.mark.peers
def test_page_of_each_plugin(docs: Path, up_to_date: Check) -> None:
    found = distributions()
    for d in found:
        up_to_date(docs / "plugins" / f"{d.page}.md", plugin_page(d))
    assert {path.stem for path in (docs / "plugins").glob("*.md")} == {d.page for d in found}


def licence_of(package: str) -> str:
    """What the metadata of an installed package, or the first lines of its licence, say."""
    found = metadata.metadata(package)
    words = [found.get("License-Expression") or found.get("License") or "", *found.get_all("Classifier", [])]
    files = [file for file in metadata.files(package) or () if file.name.startswith("LICENSE")]
    words += [Path(str(file.locate())).read_text(encoding="utf-8")[:300] for file in files]
    return " ".join(words)


@pytest.mark.peers
def test_licences_are_as_told(docs: Path) -> None:
    page = " ".join((docs / "plugins.md").read_text(encoding="utf-8").split())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needs = [project["dependencies"]]
    for path in ROOT.glob("plugins/*/pyproject.toml"):
        needs.append(tomllib.loads(path.read_text(encoding="utf-8"))["project"]["dependencies"])
    names = {re.split("[=<>]", need)[0] for need in chain(*needs)}
    free = re.compile("MIT|BSD|Apache|Permission is hereby granted, free of charge")
    others = {name for name in names if not free.search(licence_of(name))}
    assert others == {"exudyn"} and "EXUDYN-General-License" in licence_of("exudyn")
    told = {"imageio-ffmpeg": "BSD-2-Clause", "pyarrow": "Apache-2.0", "distributed": "BSD-3-Clause"}
    told |= {"cairosvg": "LGPL-3.0"}
    for name, licence in {**told, "cadquery-ocp-novtk": "Apache-2.0", "cairosvg": "LGPL-3.0"}.items():
        assert licence in licence_of(name) and re.search(rf"{name} \| {licence}", page)
    ffmpeg = subprocess.run([get_ffmpeg(), "-version"], capture_output=True, text=True, check=True).stdout
    assert "--enable-gpl --enable-version3" in ffmpeg
    assert "mosek" in str(metadata.requires("drake")).lower()


def get_ffmpeg() -> str:
    from imageio_ffmpeg import get_ffmpeg_exe

    return str(get_ffmpeg_exe())


@pytest.mark.peers
def test_every_option_of_a_shipped_plugin_has_help_and_a_unit_where_it_is_a_quantity() -> None:
    for d in distributions():
        for row in d.rows:
            assert row.cls is not None
            for name, field in row.cls.Options.model_fields.items():
                assert field.description, f"{row.name}.{name} has no help"
                assert isinstance(field.json_schema_extra, dict), f"{row.name}.{name} is not made by option()"
                if name.endswith("_deg"):
                    assert field.json_schema_extra["unit"] == "deg", f"{row.name}.{name}"


# Parts of hand-written pages, between <!-- generated: NAME --> and <!-- end -->.


def with_generated(text: str, name: str, lines: list[str]) -> str:
    start, end = f"<!-- generated: {name} -->\n", "<!-- end -->"
    head, found, rest = text.partition(start)
    assert found, f"the page has no line {start!r}"
    _, found, tail = rest.partition(end)
    assert found, f"generated part {name} has no end"
    return head + start + "\n" + "\n".join(lines) + "\n\n" + end + tail


def inner_table(annotation: Any) -> type[BaseModel] | None:
    """The model that a field holds, singly or as a list."""
    for candidate in (annotation, *get_args(annotation)):
        if isinstance(candidate, type) and issubclass(candidate, BaseModel):
            return candidate
    return None


def scenario_keys() -> list[str]:
    lines: list[str] = []
    for name, field in Scenario.model_fields.items():
        if name == "flow":
            for kind, profile in FLOWS.items():
                lines += [f'## `[flow]` with `kind = "{kind}"`', "", markdown(profile.__doc__ or ""), ""]
                lines += [*keys_table(profile), ""]
            continue
        model = inner_table(field.annotation)
        if model is None:
            extra = field.json_schema_extra
            unit = extra.get("unit", "") if isinstance(extra, dict) else ""
            lines += [f"## `[{name}]`", "", f"{field.description or ''}: each key is a name, each value a point "]
            lines[-1] += f"`[x, y, z]` of the world frame in {unit}, or the name of an outlet. Default: none."
            lines.append("")
            continue
        lines += [f"## `[{name}]`", "", markdown(model.__doc__ or ""), "", *keys_table(model), ""]
        for key, item in model.model_fields.items():
            if (name, key) == ("pipe", "parts"):
                for kind, part in PIPE_PARTS.items():
                    lines += [f'### `[[pipe.parts]]` with `kind = "{kind}"`', "", markdown(part.__doc__ or ""), ""]
                    lines += [*keys_table(part), ""]
                continue
            inner = inner_table(item.annotation)
            if inner is not None:
                lines += [f"### `[[{name}.{key}]]`", "", markdown(inner.__doc__ or ""), "", *keys_table(inner), ""]
    return lines[:-1]


def test_study_keys_page(docs: Path, up_to_date: Check) -> None:
    lines = [
        "# Keys of a study file",
        "",
        "Every key of the environment and of the run, with type, default and unit; generated from the program.",
        "[study-files.md](study-files.md) explains how a study is written and merged. The options of the plugins are on the",
        "pages of the [plugins](plugins.md).",
        "",
        *scenario_keys(),
        "",
        "## `[run]`",
        "",
        *keys_table(RunOptions),
    ]
    up_to_date(docs / "study-keys.md", "\n".join(lines) + "\n")


def test_validity_page(docs: Path, up_to_date: Check) -> None:
    lines = [
        "# Where the formulas hold",
        "",
        "Every formula of the water and of the motion, with the quantity that decides whether it holds, and what the program",
        "does outside; generated from the program. `driftform scenarios check` and `evolve` print the warnings of a study,",
        "`inspect`, `simulate`, the report and the studio those of an agent too. The speed of an agent through the water is its terminal",
        "speed, or a fifth of that of the water if this is more.",
        "",
        "| formula | quantity | symbol | holds | source | outside |",
        "|---|---|---|---|---|---|",
    ]
    for formula, ranges in RANGES.items():
        lines += [
            f"| {formula} | {r.quantity} | {r.symbol} | {r.describe()} | {r.source} | {r.outside} |" for r in ranges
        ]
    lines += [
        "",
        "## Fluids",
        "",
        "`fluid.name` takes density, viscosity and expansion of one of these. All are Newtonian; a slurry that is not is outside",
        "of the model.",
        "",
        "| name | density, kg/m3 | viscosity, m2/s | expansion, 1/K | what it is | source |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| `{name}` | {f.density:g} | {f.viscosity:.3g} | {f.expansion:.3g} | {f.state} | {f.source} |"
        for name, f in FLUIDS.items()
    ]
    up_to_date(docs / "validity.md", "\n".join(lines) + "\n")


def _imports(node: ast.AST, known: set[str]) -> Iterator[str]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            continue
        if isinstance(child, ast.ImportFrom) and child.module and child.module.split(".")[0] == "driftform":
            whole = child.module.split(".")
            yield from whole[1:2] if len(whole) > 1 else [a.name for a in child.names if a.name in known]
        else:
            yield from _imports(child, known)


def module_rows() -> list[str]:
    """One row for each module of the core, those that need least first."""
    package = ROOT / "src" / "driftform"
    sources: dict[str, list[Path]] = {}
    for path in sorted(package.rglob("*.py")):
        name = path.relative_to(package).parts[0].removesuffix(".py")
        if name not in ("__init__", "__main__"):
            sources.setdefault(name, []).append(path)
    needs: dict[str, set[str]] = {}
    for name, paths in sources.items():
        trees = [ast.parse(path.read_text(encoding="utf-8")) for path in paths]
        needs[name] = {n for tree in trees for n in _imports(tree, set(sources))} - {name}

    def depth(name: str, above: tuple[str, ...] = ()) -> int:
        below = [depth(n, (*above, name)) + 1 for n in needs[name] if n not in (*above, name)]
        return max(below, default=0)

    lines = ["| module | what it is | needs |", "|---|---|---|"]
    for name in sorted(sources, key=lambda n: (depth(n), n)):
        first = next((p for p in sources[name] if p.name == "__init__.py"), sources[name][0])
        doc = markdown(ast.get_docstring(ast.parse(first.read_text(encoding="utf-8"))) or "").split("\n")[0]
        shown = f"{name}/" if first.name == "__init__.py" else f"{name}.py"
        cells = (f"`{shown}`", doc.replace("|", "\\|"), ", ".join(f"`{n}`" for n in sorted(needs[name])))
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def test_module_table_of_dataflow_page(docs: Path, up_to_date: Check) -> None:
    path = docs / "dataflow.md"
    up_to_date(path, with_generated(path.read_text(encoding="utf-8"), "modules", module_rows()))


# docs/printing.md


def material_rows() -> list[str]:
    """A row for each material of hulls, in the units that data sheets use."""
    lines = [
        "| material | kg/m3 | modulus, GPa | along, MPa | across, MPa | creep | Poisson | expansion, 1e-6/K | water, % |"
    ]
    lines.append("|---|" + "---:|" * 8)
    for name, m in MATERIALS.items():
        cells = (m.density, m.modulus / 1e9, m.strength / 1e6, m.across / 1e6, m.creep, m.poisson)
        cells += (m.expansion * 1e6, m.absorption * 100)
        lines.append("| ".join([f"| {name} ", *(f"{cell:.4g} " for cell in cells)]) + "|")
    return lines


def test_the_table_of_materials(docs: Path, up_to_date: Check) -> None:
    page = docs / "printing.md"
    up_to_date(page, with_generated(page.read_text(encoding="utf-8"), "materials", material_rows()))
