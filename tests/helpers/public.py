"""The public interface: the modules that plugins may import, the names that they offer, and where these are defined."""

import ast
import importlib
from pathlib import Path

ROOT = Path(__file__).parents[2]

MODULES = (
    "driftform",
    "driftform.interfaces",
    "driftform.types",
    "driftform.errors",
    "driftform.agent",
    "driftform.water",
    "driftform.water.parts",
    "driftform.motion",
    "driftform.motion.forces",
    "driftform.motion.solver",
    "driftform.motion.path",
    "driftform.search",
    "driftform.figures",
    "driftform.util",
    "driftform.cli",
    "driftform.testing",
)
"""The public modules, in the order of the reference: what their ``__all__`` names is public."""


def list_public():
    """The public names of each public module."""
    return {name: sorted(importlib.import_module(name).__all__) for name in MODULES}


def find_homes(module):
    """The module that defines each public name of a module; for a name that is a module itself, that name."""
    folder = ROOT / "src" / Path(*module.split("."))
    stub = folder / "__init__.pyi"
    file = stub if stub.is_file() else folder / "__init__.py"
    if not file.is_file():
        file = folder.with_suffix(".py")
    homes = dict.fromkeys(importlib.import_module(module).__all__, module)
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            place = f"{module}.{node.module or ''}".rstrip(".") if node.level else str(node.module)
            for alias in node.names:
                if alias.name in homes and place.split(".")[0] == "driftform":
                    homes[alias.name] = f"{place}.{alias.name}" if node.module is None else place
    return homes
