"""The public interface: what plugins may import of the core, ours included, and how large it is."""

import ast
import importlib
import inspect
import re
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest
from public import list_public

ROOT = Path(__file__).parents[2]
PLUGINS = sorted(path.parent for path in ROOT.glob("plugins/*/src/*/__init__.py"))

MAX_MODULES, MAX_NAMES = 16, 165


def is_public(module, name, public):
    """Whether a name is of a public module, or of a module that is a public name itself, such as `driftform.water.field`."""
    package, _, last = module.rpartition(".")
    return name in public.get(module, ()) or (last in public.get(package, ()) and name in list_names(module))


@cache
def list_names(module):
    """The public names of a module that is a public name itself: its ``__all__``, or all that it defines."""
    found = importlib.import_module(module)
    if hasattr(found, "__all__"):
        return frozenset(found.__all__)
    names = []
    for node in ast.parse(inspect.getsource(found)).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.append(node.name)
        for target in getattr(node, "targets", [getattr(node, "target", None)]):
            names += [part.id for part in ast.walk(target or ast.Pass()) if isinstance(part, ast.Name)]
    return frozenset(name for name in names if not name.startswith("_"))


def find_private_imports(source, public):
    """What a source imports of the core beside public names, or uses of a public module, one line each."""
    tree = ast.parse(source)
    modules = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "driftform" and alias.name not in public:
                    yield f"line {node.lineno}: {alias.name}"
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "driftform":
            for alias in node.names:
                if not is_public(str(node.module), alias.name, public):
                    yield f"line {node.lineno}: {node.module}.{alias.name}"
                elif isinstance(getattr(importlib.import_module(str(node.module)), alias.name), ModuleType):
                    modules[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules:
            module = modules[node.value.id]
            if node.attr not in list_names(module):
                yield f"line {node.lineno}: {module}.{node.attr}"


def test_the_public_interface_is_small():
    public = list_public()
    count = sum(len(names) for names in public.values())
    print(f"{count} public names in {len(public)} modules")
    assert len(public) <= MAX_MODULES and count <= MAX_NAMES


@pytest.mark.parametrize("package", PLUGINS, ids=lambda path: path.name)
def test_a_plugin_imports_public_names_alone(package):
    public = list_public()
    found = [
        f"{file.relative_to(ROOT)} {line}"
        for file in sorted(package.rglob("*.py"))
        for line in find_private_imports(file.read_text(encoding="utf-8"), public)
    ]
    assert found == []


def test_the_templates_of_new_plugins_import_public_names_alone():
    public = list_public()
    for file in ROOT.glob("src/driftform/plugins/scaffold/*/implementation.py.txt"):
        source = re.sub(r"\$(\w+)", r"\1", file.read_text(encoding="utf-8"))
        if not source.startswith("title ="):
            assert list(find_private_imports(source, public)) == [], file.parent.name


@pytest.mark.parametrize(
    "page", [*ROOT.glob("docs/*.md"), *ROOT.glob("docs/examples/*.py")], ids=lambda path: path.name
)
def test_what_the_docs_show_imports_public_names_alone(page):
    text = page.read_text(encoding="utf-8")
    blocks = [text] if page.suffix == ".py" else re.findall(r"```python[^\n]*\n(.*?)```", text, re.DOTALL)
    # What tests of plugins may use beside the contracts has sections of its own in the reference.
    testing = "driftform.testing."
    assert [x for b in blocks for x in find_private_imports(b, list_public()) if testing not in x] == []


def test_a_module_that_is_public_shows_its_public_names_alone():
    source = "from driftform.motion import forces\nforces.{}"
    assert list(find_private_imports(source.format("flight_model"), list_public())) == []
    [found] = find_private_imports(source.format("fill_rate"), list_public())
    assert found == "line 2: driftform.motion.forces.fill_rate"
