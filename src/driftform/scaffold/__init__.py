"""Creates a new plugin for any seam: a small distribution that installs and passes its tests, to be edited.

Each seam has a folder of templates, in which ``string.Template`` fills in names, and ``about.toml`` with the data of
the seam; ``common`` contains the templates that all seams share.
"""

import keyword
import re
import sys
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import resources, util
from string import Template
from typing import Any

from driftform import __version__, interfaces
from driftform.errors import InputError, did_you_mean
from driftform.interfaces import SEAMS
from driftform.registry import registry
from driftform.study import NAMED

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
"""An agent to try a plugin with, as its developed word."""

_MAX_LENGTH = 60


@dataclass(frozen=True)
class Names:
    """The names of a new plugin and its parts.

    Attributes
    ----------
    distribution
        name of the distribution, normalised as in PEP 503: ``driftform-dwell``.
    package
        name of the package: ``driftform_dwell``.
    plugin
        name of the plugin in a study file: ``dwell``.
    class_name, options_name
        names of the implementation and its options: ``DwellFitness``, ``DwellOptions``.
    """

    distribution: str
    package: str
    plugin: str
    class_name: str
    options_name: str


def list_scaffolds() -> tuple[str, ...]:
    """Return the seams that have templates."""
    folders = [folder for folder in resources.files(__name__).iterdir() if (folder / "about.toml").is_file()]
    return tuple(sorted(folder.name for folder in folders))


def make_names(name: str, seam: str) -> Names:
    """Check the name of a new distribution, and return all names that follow from it.

    Raises
    ------
    InputError
        if it is not a valid name of a distribution (PEP 508), or is already taken.
    """
    if seam not in SEAMS:
        raise InputError(f"--seam {seam}: unknown seam{did_you_mean(seam, SEAMS)}")
    if not re.fullmatch(r"[a-z0-9]([a-z0-9._-]*[a-z0-9])?", name, re.IGNORECASE | re.ASCII):
        near = re.sub(r"[^a-z0-9]+", "-", name.lower(), flags=re.ASCII).strip("-")
        raise InputError(
            f"'{name}' is not a valid name of a distribution: use letters and digits, with '-' between them"
            + (f"; did you mean '{near}'?" if near else ", such as driftform-dwell")
        )
    distribution = re.sub(r"[-_.]+", "-", name).lower()
    plugin = distribution.removeprefix("driftform-")
    package = distribution.replace("-", "_")
    camel = "".join(part.capitalize() for part in plugin.split("-"))
    names = Names(distribution, package, plugin, camel + _read_about(seam)["noun"], f"{camel}Options")
    if len(name) > _MAX_LENGTH:
        raise InputError(f"'{name[:20]}...' is longer than {_MAX_LENGTH} characters; choose a shorter name")
    if not names.class_name.isidentifier():
        raise InputError(
            f"'{name}' would give the class '{names.class_name}'; the name of the plugin must begin with a letter"
        )
    if keyword.iskeyword(package) or package in sys.stdlib_module_names or util.find_spec(package):
        raise InputError(f"a module '{package}' already exists; did you mean 'driftform-{distribution}'?")
    if hasattr(interfaces, names.class_name) or hasattr(interfaces, names.options_name):
        raise InputError(
            f"'{name}' would give a class with the name of a class of driftform; choose another name"
        )
    for row in registry().seam(seam):
        if row.name == plugin:
            raise InputError(
                f"{seam} '{plugin}' already exists, from {row.distribution} {row.version}; choose another name"
            )
    return names


def list_files(names: Names, seam: str) -> dict[str, str]:
    """Return the text of each file of a new distribution, by its path inside the distribution's folder."""
    about, package, tests = _read_about(seam), f"src/{names.package}", "tests"
    words = {
        "distribution": names.distribution,
        "package": names.package,
        "plugin": names.plugin,
        "class_name": names.class_name,
        "options_name": names.options_name,
        "seam": seam,
        "interface": SEAMS[seam].__name__,
        "summary": about["summary"],
        "table": f"{seam}.{names.plugin}" if seam in NAMED else seam,
        "dependencies": ", ".join(
            f'"{line}"' for line in (f"driftform>={__version__}", *about["dependencies"])
        ),
        "word": WORD,
    }
    study = _read_template(seam, "study.toml.txt").substitute(words)
    use = "\n".join(f"$ {line}" for line in list_uses(names, seam))
    filled = {
        "pyproject.toml": ("common", "pyproject.toml.txt"),
        "README.md": ("common", "README.md.txt"),
        f"{package}/__init__.py": ("common", "__init__.py.txt"),
        f"{package}/{seam}.py": (seam, "implementation.py.txt"),
        f"{tests}/test_{seam}.py": (seam, "test.py.txt"),
    }
    files = {
        path: _read_template(*source).substitute(words, study=study, use=use)
        for path, source in filled.items()
    }
    return {**files, "study.toml": study}


def list_uses(names: Names, seam: str) -> list[str]:
    """Return commands that use the new plugin, to be run in the distribution's folder."""
    lines: Iterable[str] = _read_about(seam)["use"]
    return [Template(line).substitute(plugin=names.plugin, word=WORD) for line in lines]


def _read_about(seam: str) -> dict[str, Any]:
    return tomllib.loads((resources.files(__name__) / seam / "about.toml").read_text(encoding="utf-8"))


def _read_template(folder: str, name: str) -> Template:
    return Template((resources.files(__name__) / folder / name).read_text(encoding="utf-8"))
