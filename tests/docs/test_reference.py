"""docs/reference.md has every public name: what users are told to import is there, and says what it is."""

import ast
import re
import subprocess
from pathlib import Path

import pytest
from public import MODULES, find_homes

from driftform.interfaces import SEAMS
from driftform.plugins.scaffold import list_files, make_names

ROOT = Path(__file__).parents[2]

_ROLE = re.compile(r":(?:mod|class|func|meth|attr|data|exc):`~?([^`]+)`")

TEST_WITH = {
    "driftform_frusta.csg": (),
    "driftform.plugins.hookspecs": (),
    "driftform.testing.bodies": (),
    "driftform.testing.agents": ("Spheroid", "sphere_agent", "tumbling_agent"),
    "driftform.testing.fitness": ("PIPE", "straight_trajectory"),
    "driftform.testing.simulator": ("water_scenario",),
    "driftform.testing.strategy": ("search_space", "two_target_fitness"),
    "driftform.testing.renderer": ("Frames", "drifting_trajectory", "read_film"),
    "driftform.testing.checker": ("write_box",),
}
"""The trees of solids, the hooks, and bodies, agents and flights to test with: modules, and their names, or none for all that are public."""


@pytest.fixture(scope="module")
def package():
    """The modules of the package by name, as the page is made: nothing is imported."""
    import griffe

    found = griffe.load("driftform", search_paths=[ROOT / "src"]).modules_collection
    griffe.load("driftform_frusta", search_paths=[ROOT / "plugins/driftform-frusta/src"], modules_collection=found)
    return found


@pytest.fixture(scope="module")
def shown():
    """The modules that the reference shows, each with the names that it is limited to; none for all that are public."""
    found = {}
    for module in MODULES:
        for name, home in sorted(find_homes(module).items(), key=lambda item: (item[1], item[0])):
            if not name.startswith("__"):
                is_module = home.rpartition(".")[2] == name and home.count(".") > 1
                found.setdefault(home, []).extend(() if is_module else (name,))
    for module, names in TEST_WITH.items():
        found.setdefault(module, []).extend(names)
    return found


INTRODUCTION = """# Python reference

The public interface: plugins and scripts import these modules, and nothing else of driftform. Of a name that is a
module itself, what this page lists is public too: `from driftform.water.field import water_velocity`. This page is made
from the docstrings, which state shapes, units and frames.
[python.md](python.md) shows how to use the functions, and [dataflow.md](dataflow.md) how the values flow.
"""


def tell(member):
    """A docstring as Markdown: sections are lists."""
    if member.docstring is None:
        return ""
    text = ""
    for section in member.docstring.parse("google", warnings=False):
        if section.kind.value == "text":
            text += f"{mark_code(section.value)}\n\n"
        elif section.kind.value == "examples":
            text += "".join(f"```pycon\n{part}\n```\n\n" for _, part in section.value)
        else:
            text += f"{section.kind.value.capitalize()}:\n\n"
            for item in section.value if isinstance(section.value, list) else [section.value]:
                name = getattr(item, "name", "") or getattr(item, "annotation", "") or "note"
                said = getattr(item, "description", "") or getattr(item, "contents", "")
                text += f"- `{name}`: {mark_code(' '.join(said.split()))}\n"
            text += "\n"
    return text


def mark_code(text):
    """Text of a docstring with roles and double backticks as Markdown."""
    return _ROLE.sub(r"`\1`", text).replace("``", "`")


def sign(member):
    """The signature of a function, the head of a class, or a name with its type and a short value."""
    if member.is_function:
        line = f"def {member.signature()}"
        if len(line) <= 100:
            return line
        command = ["ruff", "format", "--line-length", "100", "-"]
        done = subprocess.run(command, input=f"{line}: ...\n", capture_output=True, text=True, check=True)
        return done.stdout.rstrip().removesuffix(": ...")
    if member.is_class:
        return f"class {member.name}" + (f"({', '.join(map(str, member.bases))})" if member.bases else "")
    value = f" = {member.value}" if member.value is not None and len(str(member.value)) < 60 else ""
    return member.name + (f": {member.annotation}" if member.annotation else "") + value


def describe(member, path):
    """A public name: its signature and docstring; of a class also its fields and methods."""
    text = f'<a id="{path}"></a>\n\n### {member.name}\n\n'
    fields, methods = [], []
    if member.is_class:
        for name, part in member.all_members.items():
            if not name.startswith("_") and not part.is_alias:
                (methods if part.is_function or "property" in part.labels else fields).append(part)
    lines = [sign(member), *(f"    {sign(part)}" for part in fields)]
    text += "```py\n" + "\n".join(lines) + f"\n```\n\n{tell(member)}"
    text += "".join(f"`{part.name}`: {tell(part)}" for part in fields if part.docstring)
    return text + "".join(f"```py\n{sign(part)}\n```\n\n{tell(part)}" for part in methods)


def reference_page(package, shown):
    """The page: the modules that define public names, with these."""
    page = INTRODUCTION
    for home, names in shown.items():
        module = package[home]
        found = dict(members_of(module)) if module.is_module else {module.name: module}
        page += f"\n## {home}\n\n" + (tell(module) if module.is_module and not names else "")
        prefix = f"{home}." if module.is_module else home.removesuffix(module.name)
        page += "".join(describe(found[name], prefix + name) for name in names or found)
    return page.rstrip() + "\n"


@pytest.mark.peers
def test_the_page_shows_the_public_interface(package, shown, up_to_date):
    up_to_date(ROOT / "docs" / "reference.md", reference_page(package, shown))


def imports(code):
    """Module and name of what a piece of Python imports of driftform itself."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and re.match(r"driftform(\.|$)", node.module or ""):
            names = (alias.name for alias in node.names)
            yield from ((str(node.module), name) for name in names if not name.startswith("__"))


def undocumented(module, only):
    """The public names of a module, and of its classes, that nothing is told of; or a single name."""
    if not module.is_module:
        yield from () if module.docstring else (module.path,)
        return
    # The text below the last of several constants describes all of them; an option of the command line has its help.
    texts = " ".join(m.docstring.value for m in module.members.values() if not m.is_alias and m.docstring)
    for name, member in members_of(module):
        if only and name not in only:
            continue
        helps = re.search(r"help=|make_option\(", str(getattr(member, "value", "")))
        told = member.docstring or f"``{name}``" in texts or helps
        if not told:
            yield f"{module.path}.{name}"
        if member.is_class:
            text = member.docstring.value if member.docstring else ""
            inherited = {n for base in member.mro() for n in base.members}
            for field, value in member.members.items():
                # Options tell their help; what a class has of its base is told there.
                told = (
                    value.docstring
                    or field in inherited
                    or re.search(r"option\(|description=", str(getattr(value, "value", "")))
                )
                if not (field.startswith("_") or value.is_alias or told or re.search(rf"\b{field}\b", text)):
                    yield f"{module.path}.{name}.{field}"


def members_of(module):
    """The public names of a module by ``__all__`` where it has one, and otherwise what is defined in it."""
    for name, member in module.members.items():
        if member.is_alias:
            if name in (module.exports or ()):
                yield name, member.final_target
        elif not (name.startswith("_") or member.is_module or is_type_variable(member)):
            yield name, member


def is_type_variable(member):
    return member.is_attribute and str(member.value).startswith(("TypeVar(", "ParamSpec("))


@pytest.mark.peers
def test_every_public_name_of_the_reference_is_documented(package, shown):
    assert len(shown) > 10
    found = [name for module, only in shown.items() for name in undocumented(package[module], only)]
    assert not found, "\n".join(found)


@pytest.mark.peers
def test_what_users_are_told_to_import_is_in_the_reference(package, shown, blocks):
    used = {pair: f"imported by {b}" for b in blocks if b.language == "python" for pair in imports(b.text)}
    for seam in SEAMS:
        for path, text in list_files(make_names("driftform-try", seam)).items():
            if path.endswith(".py"):
                used |= dict.fromkeys(imports(text), f"imported by the {path} of a {seam}")
    homes = {module: find_homes(module) for module in MODULES}
    missing = []
    for (module, name), place in used.items():
        home = homes.get(module, {}).get(name, module)
        only = shown.get(home)
        if (
            home not in shown
            or (only and home != f"{module}.{name}" and name not in only)
            or (module not in homes and name not in dict(members_of(package[home])))
        ):
            missing.append(f"{module}.{name}: {place}")
    assert not missing, "\n".join(missing)
