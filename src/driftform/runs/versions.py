"""The versions of all that affects the outcome of an evaluation."""

import hashlib
import sys
from collections.abc import Mapping
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from driftform import __version__
from driftform.plugins.registry import registry
from driftform.study import SELECTED

PACKAGES = ("numba", "numpy", "scipy")
"""Packages that affect the last digit of a result, as driftform and its plugins do."""


def find_versions(document: Mapping[str, Any]) -> dict[str, str]:
    """Return the versions of all that affects the outcome of an evaluation: driftform, the study's plugins, numerics.

    Of driftform and the plugins it has the digests of their sources too, which may differ within a version.
    """
    found = {"driftform": __version__} | {name: metadata.version(name) for name in PACKAGES}
    modules = {"driftform": "driftform"}
    for seam in SELECTED:
        if seam != "strategy":
            for row in registry().seam(seam):
                if row.name == document[seam]["use"] and row.cls is not None:
                    found[row.distribution] = row.version
                    modules[row.distribution] = row.cls.__module__.partition(".")[0]
    return found | {f"sources of {name}": _hash_sources(module) for name, module in modules.items()}


@cache
def _hash_sources(module: str) -> str:
    """Return a digest of the Python files of a package that is imported, or of a module."""
    digest, file = hashlib.sha256(), Path(str(sys.modules[module].__file__))
    for source in sorted(file.parent.rglob("*.py")) if file.name == "__init__.py" else [file]:
        digest.update(source.relative_to(file.parent).as_posix().encode() + source.read_bytes())
    return digest.hexdigest()[:12]
