"""Creates new plugins for any seam: a small distribution that installs and passes its tests, to be edited.

Each seam has a folder of templates, in which ``string.Template`` fills in names, and ``about.toml`` with the data of
the seam; ``common`` contains the templates that all seams share. The commands that install the result are those of pip or uv.
"""

import json
import keyword
import re
import shlex
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib import metadata, resources, util
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

from driftform import __version__, interfaces
from driftform.errors import InputError, did_you_mean
from driftform.interfaces import NAMED, SEAMS
from driftform.plugins.registry import registry

KINDS = (*SEAMS, "commands", "scenarios")
"""What a new distribution can bring: a plugin of a seam, commands, or scenarios."""

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
"""An agent to try a plugin with, as its developed word."""

_MAX_LENGTH = 60


@dataclass(frozen=True)
class Names:
    """The names of a new plugin of one seam and its parts.

    Attributes:
        seam: what it implements: ``fitness``.
        distribution: name of the distribution, normalised as in PEP 503: ``driftform-dwell``.
        package: name of the package: ``driftform_dwell``.
        plugin: name of the plugin in a study file: ``dwell``.
        class_name, options_name: names of the implementation and its options: ``DwellFitness``, ``DwellOptions``.
    """

    seam: str
    distribution: str
    package: str
    plugin: str
    class_name: str
    options_name: str


def make_names(name: str, seam: str) -> Names:
    """Check the name of a new distribution, and return all names that follow from it.

    Raises InputError if it is not a valid name of a distribution (PEP 508), or is already taken.
    """
    if seam not in KINDS:
        raise InputError(f"--seam {seam}: unknown seam{did_you_mean(seam, KINDS)}")
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
    names = Names(seam, distribution, package, plugin, camel + _read_about(seam)["noun"], f"{camel}Options")
    if len(name) > _MAX_LENGTH:
        raise InputError(f"'{name[:20]}...' is longer than {_MAX_LENGTH} characters; choose a shorter name")
    if not names.class_name.isidentifier():
        raise InputError(
            f"'{name}' would give the class '{names.class_name}'; the name of the plugin must begin with a letter"
        )
    if keyword.iskeyword(package) or package in sys.stdlib_module_names or util.find_spec(package):
        raise InputError(f"a module '{package}' already exists; did you mean 'driftform-{distribution}'?")
    if hasattr(interfaces, names.class_name) or hasattr(interfaces, names.options_name):
        raise InputError(f"'{name}' would give a class with the name of a class of driftform; choose another name")
    for row in registry().seam(seam) if seam in SEAMS else ():
        if row.name == plugin:
            raise InputError(
                f"{seam} '{plugin}' already exists, from {row.distribution} {row.version}; choose another name"
            )
    return names


def list_files(names: Names) -> dict[str, str]:
    """Return the text of each file of a new distribution, by its path inside the folder."""
    seam, package, about = names.seam, f"src/{names.package}", _read_about(names.seam)
    dependencies = [f"driftform>={__version__}", *about["dependencies"]]
    words = {
        **asdict(names),
        "summary": about["summary"],
        "interface": SEAMS[seam].__name__ if seam in SEAMS else f"driftform_{seam}",
        "dependencies": ", ".join(f'"{line}"' for line in dependencies),
        "table": f"{seam}.{names.plugin}" if seam in NAMED else seam,
        "use": "\n".join(f"$ {line}" for line in list_uses(names)),
        "word": WORD,
    }
    # Some kinds have a hook of their own.
    has_hook = (resources.files(__name__) / seam / "hook.py.txt").is_file()
    words["hook"] = _fill(seam if has_hook else "common", "hook.py.txt", words)
    words["study"] = _fill(seam, "study.toml.txt", words)
    return {
        "pyproject.toml": _fill("common", "pyproject.toml.txt", words),
        "README.md": _fill("common", "README.md.txt", words),
        f"{package}/__init__.py": _fill("common", "__init__.py.txt", words),
        f"{package}/{_substitute(about.get('file', '$seam.py'), words)}": _fill(seam, "implementation.py.txt", words),
        f"tests/test_{seam}.py": _fill(seam, "test.py.txt", words),
        "study.toml": words["study"],
    }


def list_uses(names: Names) -> list[str]:
    """Return commands that use the new plugin, to be run in the distribution's folder."""
    return [_substitute(line, {"plugin": names.plugin, "word": WORD}) for line in _read_about(names.seam)["use"]]


def _substitute(text: str, words: Mapping[str, str]) -> str:
    return Template(text).substitute(words)


def _read_about(seam: str) -> dict[str, Any]:
    return tomllib.loads((resources.files(__name__) / seam / "about.toml").read_text(encoding="utf-8"))


def _fill(folder: str, name: str, words: Mapping[str, str]) -> str:
    return _substitute((resources.files(__name__) / folder / name).read_text(encoding="utf-8"), words)


def list_installation() -> list[str]:
    """Return the commands that install a new distribution where driftform is and run its tests, from its folder.

    An environment with pip takes it as any other. One without was made by uv. If it is that of a clone of driftform, the
    distribution gets an environment of its own, so that ``uv sync`` of the clone does not uninstall it.
    """
    if util.find_spec("pip") is not None:
        return ['pip install -e ".[test]"', "pytest"]
    clone = _find_clone()
    if clone is not None:
        return [f"uv add --editable {shlex.quote(str(clone))}", "uv run --extra test pytest"]
    return ['uv pip install -e ".[test]"', "pytest"]


def _find_clone() -> Path | None:
    """Return the folder of driftform's source if this environment is in it."""
    text = metadata.distribution("driftform").read_text("direct_url.json")
    origin = json.loads(text) if text else {}
    if not origin.get("dir_info", {}).get("editable"):
        return None
    folder = Path(url2pathname(urlsplit(origin["url"]).path))
    return folder if Path(sys.prefix).is_relative_to(folder) else None
