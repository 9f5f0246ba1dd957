"""Pages, and parts of pages, that are made from the program. ``UPDATE_DOCS=1 pytest tests/docs`` rewrites them."""

import ast
import inspect
import re
import subprocess
import tomllib
from dataclasses import dataclass
from importlib import metadata
from itertools import chain
from pathlib import Path
from typing import Any, get_args

import pytest
import typer
from imports import find_rooms, read_imports
from pydantic import BaseModel

from driftform.cli.app import Commands, app
from driftform.interfaces import SEAMS
from driftform.plugins.registry import Contribution, registry
from driftform.study import RunOptions
from driftform.util.options import describe
from driftform.util.validity import RANGES
from driftform.water import Scenario
from driftform.water.flow import FLOWS
from driftform.water.fluids import FLUIDS
from driftform.water.parts.tables import PARTS as PIPE_PARTS
from driftform_frusta.materials import MATERIALS

ROOT = Path(__file__).parents[2]


# Values of a model, in words.

WORDS = {"str": "string", "int": "integer", "float": "number", "bool": "boolean", "dict": "table"}


def type_text(text):
    """A type as a person writes it: ``number``, ``"first"`` or ``"last"``, ``[number, number, number]``."""
    text = re.sub(r"\w+", lambda word: WORDS.get(word[0], word[0]), re.sub(r"'([^']*)'", r'`"\1"`', text))
    text = re.sub(r"\b(\w+)( or \1\b)+", r"\1", text).replace(" or none", "")
    return re.sub(r"list of (\w+)", r"list of \1s", text)


def default_text(value):
    return {None: "none", "required": "required"}[value] if value in (None, "required") else f"`{toml_text(value)}`"


def toml_text(value):
    """A value as a study file would say it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple | list):
        return "[" + ", ".join(toml_text(item) for item in value) + "]"
    return repr(value)


def write_row(*cells):
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def keys_table(model):
    """One row for each field of a model, and of the tables of options within it."""
    lines = ["| key | type | default | unit | meaning |", "|---|---|---|---|---|"]
    for row in describe(model):
        kind = ", ".join(filter(None, (type_text(row["type"]), row["bounds"])))
        lines.append(write_row(f"`{row['option']}`", kind, default_text(row["default"]), row["unit"], row["help"]))
    return lines


def markdown(docstring):
    """A docstring as Markdown: roles and double backticks become single ones."""
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", inspect.cleandoc(docstring))
    return text.replace("``", "`")


# docs/cli.md


def commands(command, path=()):
    """A command and those below it, those of plugins after those of the core."""
    yield path, command
    added = command.list_added() if isinstance(command, Commands) else {}
    for name, child in {**getattr(command, "commands", {}), **added}.items():
        yield from commands(child, (*path, name))


def value_text(parameter):
    """What stands for the value of an option or argument, ``""`` for a flag."""
    if getattr(parameter, "is_flag", False):
        return ""
    if parameter.metavar:
        return str(parameter.metavar).strip("[]") if parameter.metavar.count("[") == 1 else parameter.metavar
    annotation = getattr(getattr(parameter, "type_descriptor", None), "annotation", None)
    kind = getattr(getattr(parameter, "type", None), "name", "")
    return "N" if annotation is int or kind.startswith("integer") else "VALUE"


def parameter_default(parameter):
    if getattr(parameter, "is_flag", False) or parameter.default is None or parameter.default is Ellipsis:
        return "required" if parameter.required else ""
    return f"`{parameter.default}`"


def is_argument(parameter):
    return not parameter.opts[0].startswith("-")


def command_section(path, command):
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
            lines.append(write_row(f"`{name}`", parameter_default(p), p.help or ""))
        lines.append("")
    return lines


@pytest.mark.peers
def test_cli_page(docs, published):
    found = {" ".join(path): (path, command) for path, command in commands(typer.main.get_command(app)) if path}
    for name, (path, command) in found.items():
        published(name, command_section(path, command)[:-1], docs / "cli.md")
    text = (docs / "cli.md").read_text(encoding="utf-8")
    assert re.findall("<!-- generated: (.+) -->", text) == list(found)


def test_every_command_and_option_has_help():
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
    def name(self):
        return str(self.project["name"])

    @property
    def page(self):
        """Name of its page in ``docs/plugins``; that of the core is ``core``."""
        return self.name.removeprefix("driftform-").replace("driftform", "core")


def distributions():
    """The core and the plugins of this repository, with their contributions in the order of the seams."""
    files = [ROOT / "pyproject.toml", *sorted(ROOT.glob("plugins/*/pyproject.toml"))]
    found = [row for seam in SEAMS for row in registry().contributions() if row.seam == seam and row.cls]
    projects = [tomllib.loads(path.read_text(encoding="utf-8"))["project"] for path in files]
    return [Distribution(p, [row for row in found if row.distribution == p["name"]]) for p in projects]


def plugin_rows():
    lines = ["| distribution | what it is | seams and names |", "|---|---|---|"]
    for d in distributions():
        names = [f"{seam} " + ", ".join(links) for seam, links in links_of(d).items()]
        lines.append(write_row(f"[{d.name}](plugins/{d.page}.md)", description(d), "; ".join(names)))
    return lines


def links_of(d):
    """Links to the plugins of a distribution, by seam."""
    links = {}
    for row in d.rows:
        links.setdefault(row.seam, []).append(f"[`{row.name}`](plugins/{d.page}.md#{row.seam}-{row.name})")
    return links


def description(d):
    if d.page == "core":
        return "The plugins of the core"
    return re.sub(r"[,;] a driftform plugin$", "", str(d.project["description"]).removesuffix("."))


def plugin_page(d):
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
def test_page_of_each_plugin(docs, up_to_date):
    found = distributions()
    for d in found:
        up_to_date(docs / "plugins" / f"{d.page}.md", plugin_page(d))
    assert {path.stem for path in (docs / "plugins").glob("*.md")} == {d.page for d in found}


def licence_of(package):
    """What the metadata of an installed package, or the first lines of its licence, say."""
    found = metadata.metadata(package)
    words = [found.get("License-Expression") or found.get("License") or "", *found.get_all("Classifier", [])]
    files = [file for file in metadata.files(package) or () if file.name.startswith("LICENSE")]
    words += [Path(str(file.locate())).read_text(encoding="utf-8")[:300] for file in files]
    return " ".join(words)


@pytest.mark.peers
def test_licences_are_as_told(docs):
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


def get_ffmpeg():
    from imageio_ffmpeg import get_ffmpeg_exe

    return str(get_ffmpeg_exe())


@pytest.mark.peers
def test_every_option_of_a_shipped_plugin_has_help_and_a_unit_where_it_is_a_quantity():
    for d in distributions():
        for row in d.rows:
            assert row.cls is not None
            for name, field in row.cls.Options.model_fields.items():
                assert field.description, f"{row.name}.{name} has no help"
                assert isinstance(field.json_schema_extra, dict), f"{row.name}.{name} is not made by option()"
                if name.endswith("_deg"):
                    assert field.json_schema_extra["unit"] == "deg", f"{row.name}.{name}"


def inner_table(annotation):
    """The model that a field holds, singly or as a list."""
    for candidate in (annotation, *get_args(annotation)):
        if isinstance(candidate, type) and issubclass(candidate, BaseModel):
            return candidate
    return None


def study_keys():
    lines = []
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
    return [*lines, "## `[run]`", "", *keys_table(RunOptions)]


def formula_rows():
    lines = ["| formula | quantity | symbol | holds | source | outside |", "|---|---|---|---|---|---|"]
    return lines + [
        write_row(formula, r.quantity, r.symbol, r.describe(), r.source, r.outside)
        for formula, ranges in RANGES.items()
        for r in ranges
    ]


def fluid_rows():
    lines = [
        "| name | density, kg/m3 | viscosity, m2/s | expansion, 1/K | what it is | source |",
        "|---|---|---|---|---|---|",
    ]
    return lines + [
        write_row(f"`{name}`", f"{f.density:g}", f"{f.viscosity:.3g}", f"{f.expansion:.3g}", f.state, f.source)
        for name, f in FLUIDS.items()
    ]


def module_rows():
    """One row for each module of the core, those that need least first."""
    package = ROOT / "src" / "driftform"
    needs = find_rooms(read_imports(package))

    def depth(name):
        return max((depth(below) + 1 for below in needs[name]), default=0)

    lines = ["| module | what it is | needs |", "|---|---|---|"]
    for name in sorted(needs, key=lambda n: (depth(n), n)):
        is_package = (package / name).is_dir()
        source = (package / name / "__init__.py" if is_package else package / f"{name}.py").read_text(encoding="utf-8")
        doc = markdown(ast.get_docstring(ast.parse(source)) or "").split("\n")[0]
        needed = ", ".join(f"`{below}`" for below in sorted(needs[name]))
        lines.append(write_row(f"`{name}/`" if is_package else f"`{name}.py`", doc, needed))
    return lines


def material_rows():
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


PARTS = {
    "distributions": plugin_rows,
    "fluids": fluid_rows,
    "formulas": formula_rows,
    "keys": study_keys,
    "materials": material_rows,
    "modules": module_rows,
}


@pytest.mark.parametrize(
    "title", [pytest.param(title, marks=pytest.mark.peers if title == "distributions" else ()) for title in PARTS]
)
def test_a_part_of_a_page_is_what_the_program_says(title, published):
    published(title, PARTS[title]())
