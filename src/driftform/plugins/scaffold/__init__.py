"""Creates new plugins for any seams: a small distribution that installs and passes its tests, to be edited.

Each seam has a folder of templates, in which ``string.Template`` fills in names, and ``about.toml`` with the data of
the seam; ``common`` contains the templates that all seams share. The commands that install the result are those of pip or uv.
"""

import json
import keyword
import re
import shlex
import sys
import tomllib
from collections.abc import Iterable, Mapping, Sequence
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


def list_files(parts: Sequence[Names]) -> dict[str, str]:
    """Return the text of each file of a new distribution with a plugin of each seam, by its path inside the folder."""
    first = parts[0]
    package, seams = f"src/{first.package}", _enumerate([part.seam for part in parts])
    dependencies = dict.fromkeys(line for part in parts for line in _read_about(part.seam)["dependencies"])
    summary = _read_about(first.seam)["summary"] if len(parts) == 1 else seams.capitalize()
    words = [
        {
            **asdict(part),
            "summary": _read_about(part.seam)["summary"],
            "table": f"{part.seam}.{part.plugin}" if part.seam in NAMED else part.seam,
            "word": WORD,
        }
        for part in parts
    ]
    shared = {
        **words[0],
        "summary": summary,
        "about": f"{summary}: the {seams}" if len(parts) == 1 else f"The {seams}",
        "interfaces": _enumerate([f"`{_name_interface(part.seam)}`" for part in parts]),
        "dependencies": ", ".join(f'"{line}"' for line in (f"driftform>={__version__}", *dependencies)),
        "hooks": "".join(_fill(_find_hook(line["seam"]), "hook.py.txt", line) for line in words),
        "use": "\n".join(f"$ {line}" for line in list_uses(parts)),
        "study": _merge_studies(
            [_fill(part.seam, "study.toml.txt", line) for part, line in zip(parts, words, strict=True)]
        ),
    }
    files = {
        "pyproject.toml": _fill("common", "pyproject.toml.txt", shared),
        "README.md": _fill("common", "README.md.txt", shared),
        f"{package}/__init__.py": _fill("common", "__init__.py.txt", shared),
    }
    for part, line in zip(parts, words, strict=True):
        place = Template(_read_about(part.seam).get("file", "$seam.py")).substitute(line)
        files[f"{package}/{place}"] = _fill(part.seam, "implementation.py.txt", line)
        files[f"tests/test_{part.seam}.py"] = _fill(part.seam, "test.py.txt", line)
    return {**files, "study.toml": shared["study"]}


def list_uses(parts: Sequence[Names]) -> list[str]:
    """Return commands that use the new plugins, to be run in the distribution's folder."""
    lines: Iterable[str] = dict.fromkeys(
        Template(line).substitute(plugin=part.plugin, word=WORD)
        for part in parts
        for line in _read_about(part.seam)["use"]
    )
    return list(lines)


def _merge_studies(texts: Sequence[str]) -> str:
    """Return one study with the tables of all; each begins with its base, which they share."""
    head = texts[0].partition("\n\n")[0]
    return "\n\n".join([head, *(text.partition("\n\n")[2].rstrip() for text in texts)]) + "\n"


def _name_interface(kind: str) -> str:
    return SEAMS[kind].__name__ if kind in SEAMS else f"driftform_{kind}"


def _find_hook(kind: str) -> str:
    """Return the folder of the template of a hook: that of the kind, if it has one of its own."""
    return kind if (resources.files(__name__) / kind / "hook.py.txt").is_file() else "common"


def _enumerate(words: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def _read_about(seam: str) -> dict[str, Any]:
    return tomllib.loads((resources.files(__name__) / seam / "about.toml").read_text(encoding="utf-8"))


def _fill(folder: str, name: str, words: Mapping[str, str]) -> str:
    text = (resources.files(__name__) / folder / name).read_text(encoding="utf-8")
    return Template(text).substitute(words)


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
