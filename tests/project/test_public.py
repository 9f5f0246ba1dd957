"""The public interface: what plugins may import of the core, ours included, and how large it is."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from public import list_public

ROOT = Path(__file__).parents[2]
PLUGINS = sorted(path.parent for path in ROOT.glob("plugins/*/src/*/__init__.py"))

MOST_MODULES, MOST_NAMES = 12, 120


def find_private_imports(source: str, public: dict[str, list[str]]) -> Iterator[str]:
    """What a source imports of the core beside public names, one line each."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "driftform" and alias.name not in public:
                    yield f"line {node.lineno}: {alias.name}"
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "driftform":
            for alias in node.names:
                if alias.name not in public.get(node.module or "", ()):
                    yield f"line {node.lineno}: {node.module}.{alias.name}"


def test_the_public_interface_is_small() -> None:
    public = list_public()
    count = sum(len(names) for names in public.values())
    print(f"{count} public names in {len(public)} modules")
    assert len(public) <= MOST_MODULES and count <= MOST_NAMES


@pytest.mark.parametrize("package", PLUGINS, ids=lambda path: path.name)
def test_a_plugin_imports_public_names_alone(package: Path) -> None:
    public = list_public()
    found = [
        f"{file.relative_to(ROOT)} {line}"
        for file in sorted(package.rglob("*.py"))
        for line in find_private_imports(file.read_text(encoding="utf-8"), public)
    ]
    assert found == []


def test_the_templates_of_new_plugins_import_public_names_alone() -> None:
    public = list_public()
    for file in ROOT.glob("src/driftform/scaffold/*/implementation.py.txt"):
        source = re.sub(r"\$(\w+)", r"\1", file.read_text(encoding="utf-8"))
        if not source.startswith("title ="):
            assert list(find_private_imports(source, public)) == [], file.parent.name


def test_an_import_of_a_private_module_is_found() -> None:
    source = "from driftform.water import Scenario\ndef fly():\n    from driftform.motion.flight import SAMPLE\n"
    found = list(find_private_imports(source, list_public()))
    assert found == ["line 3: driftform.motion.flight.SAMPLE"]
