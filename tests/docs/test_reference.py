"""docs/reference.md has every public name: what users are told to import is there, and says what it is."""

import ast
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from public import MODULES, find_homes

from driftform.interfaces import SEAMS
from driftform.plugins.scaffold import list_files, make_names

ROOT = Path(__file__).parents[2]
FILES = sorted(file for folder in ("src", "plugins/*/src") for file in ROOT.glob(f"{folder}/**/*.py"))

_SHOWN = re.compile(r"^::: (driftform\S*)\n((?: {4}.*\n)*)", re.MULTILINE)


@pytest.fixture(scope="module")
def package() -> Any:
    """The modules of the package by name, as the site reads them: nothing is imported."""
    import griffe

    return griffe.load("driftform", search_paths=[ROOT / "src"]).modules_collection


@pytest.fixture(scope="module")
def shown(pages: dict[str, str]) -> dict[str, list[str]]:
    """The modules that the reference shows, each with the names that it is limited to; none for all that are public."""
    found: dict[str, list[str]] = {}
    for module, options in _SHOWN.findall(pages["reference.md"]):
        found.setdefault(module, []).extend(re.findall(r"^ +- (\w+)$", options, re.MULTILINE))
    return found


INTRODUCTION = """# Python reference

The public interface: plugins and scripts import these modules, and nothing else of driftform. Of a name that is a
module itself, what this page lists is public too: `from driftform.water.field import water_velocity`. This page is made
from the docstrings, which state shapes, units and frames. On GitHub it is a list of names: the source has the same text.
[python.md](python.md) shows how to use the functions, and [dataflow.md](dataflow.md) how the values flow.
"""

WITHOUT_TEXTS = ("driftform.cli.options", "driftform.figures.style")
"""Modules of constants that are explained by their values, or together."""

TEST_WITH = """
## Hooks

::: driftform.plugins.hookspecs

## Bodies, agents and flights to test with

::: driftform.testing.bodies

::: driftform.testing.agents
    options:
      members:
        - Spheroid
        - sphere_agent
        - tumbling_agent

::: driftform.testing.fitness
    options:
      members:
        - PIPE
        - straight_trajectory

::: driftform.testing.simulator
    options:
      members:
        - water_scenario

::: driftform.testing.strategy
    options:
      members:
        - search_space
        - two_target_fitness

::: driftform.testing.renderer
    options:
      members:
        - Frames
        - drifting_trajectory
        - read_film

::: driftform.testing.checker
    options:
      members:
        - write_box
"""


def reference_page() -> str:
    """The page: each public module with its names, grouped by the modules that define them."""
    page = INTRODUCTION
    for module in MODULES:
        page += f"\n## {module}\n"
        groups: dict[str, list[str]] = {}
        for name, home in sorted(find_homes(module).items()):
            if not name.startswith("__"):
                groups.setdefault(home, []).append(name)
        for home, names in sorted(groups.items()):
            if names == [home.rpartition(".")[2]] and home.count(".") > 1:
                page += f"\n::: {home}\n"
                if home in WITHOUT_TEXTS:
                    page += "    options:\n      show_if_no_docstring: true\n"
            else:
                members = "".join(f"        - {name}\n" for name in names)
                page += f"\n::: {home}\n    options:\n      members:\n{members}"
    return page + TEST_WITH


def test_the_page_lists_the_public_interface(up_to_date: Any) -> None:
    up_to_date(ROOT / "docs" / "reference.md", reference_page())


def imports(code: str) -> Iterator[tuple[str, str]]:
    """Module and name of what a piece of Python imports of driftform itself."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and re.match(r"driftform(\.|$)", node.module or ""):
            names = (alias.name for alias in node.names)
            yield from ((str(node.module), name) for name in names if not name.startswith("__"))


def undocumented(module: Any, only: Sequence[str]) -> Iterator[str]:
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


def members_of(module: Any) -> Iterator[tuple[str, Any]]:
    """The public names of a module by ``__all__`` where it has one, and otherwise what is defined in it."""
    for name, member in module.members.items():
        if member.is_alias:
            if name in (module.exports or ()):
                yield name, member.final_target
        elif not (name.startswith("_") or member.is_module or is_type_variable(member)):
            yield name, member


def is_type_variable(member: Any) -> bool:
    return member.is_attribute and str(member.value).startswith(("TypeVar(", "ParamSpec("))


@pytest.mark.peers
def test_every_public_name_of_the_reference_is_documented(package: Any, shown: dict[str, list[str]]) -> None:
    assert len(shown) > 10
    found = [name for module, only in shown.items() for name in undocumented(package[module], only)]
    assert not found, "\n".join(found)


@pytest.mark.peers
def test_what_users_are_told_to_import_is_in_the_reference(
    package: Any, shown: dict[str, list[str]], blocks: list[Any]
) -> None:
    used = {pair: f"imported by {b}" for b in blocks if b.language == "python" for pair in imports(b.text)}
    for seam in SEAMS:
        for path, text in list_files([make_names("driftform-try", seam)]).items():
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


def test_the_site_shows_them_all(package: Any, shown: dict[str, list[str]], site: Path) -> None:
    page = (site / "reference" / "index.html").read_text(encoding="utf-8")
    names = [module for module in shown if not package[module].is_module]
    for module in set(shown) - set(names):
        names += [f"{module}.{name}" for name in shown[module] or dict(members_of(package[module]))]
    assert [name for name in names if f'id="{name}"' not in page] == []


@pytest.mark.peers
def test_the_reference_limits_modules_to_names_that_there_are(package: Any, shown: dict[str, list[str]]) -> None:
    for module, only in shown.items():
        assert set(only) <= set(package[module].members), module


def test_every_public_module_class_and_function_has_a_docstring() -> None:
    assert len(FILES) > 200
    found = []
    for file in FILES:
        tree = ast.parse(file.read_text(encoding="utf-8"))
        path = file.relative_to(ROOT)
        found += [str(path)] if not ast.get_docstring(tree) else []
        found += [f"{path}: {name}" for name in bare(tree)]
    assert not found, "\n".join(found)


def bare(node: ast.Module | ast.ClassDef, inside: str = "") -> Iterator[str]:
    """The public classes, functions and methods without a docstring."""
    for part in node.body:
        if isinstance(part, ast.ClassDef | ast.FunctionDef) and not part.name.startswith("_"):
            if not ast.get_docstring(part):
                yield f"{inside}{part.name}"
            if isinstance(part, ast.ClassDef):
                yield from bare(part, f"{inside}{part.name}.")


@pytest.mark.peers
def test_a_name_without_a_word_would_be_found(tmp_path: Path) -> None:
    import griffe

    (tmp_path / "bad.py").write_text(
        '"""A module."""\n\nLIMIT = 3\n\n\nclass Told:\n    """It has a ``length``."""\n\n'
        "    length: float\n    width: float\n\n    def tell(self): ...\n\n\ndef untold(): ...\n"
    )
    module = griffe.load("bad", search_paths=[tmp_path])
    assert sorted(undocumented(module, [])) == [*("bad.LIMIT", "bad.Told.tell", "bad.Told.width", "bad.untold")]
    assert list(bare(ast.parse((tmp_path / "bad.py").read_text()))) == ["Told.tell", "untold"]
