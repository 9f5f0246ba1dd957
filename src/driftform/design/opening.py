"""Open an agent by what names it: the path of an agent.json, RUN:TARGET, the text of a genome, or a neutral sphere."""

import hashlib
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from driftform.design.design import Design
from driftform.errors import DriftformError, InputError, did_you_mean
from driftform.motion.forces import make_sphere
from driftform.plugins.genome_text import read_genome
from driftform.runs.agent_file import StoredAgent
from driftform.runs.directory import DATABASE
from driftform.runs.run import StoredRun
from driftform.search.advance import find_best
from driftform.study import Study, load_study
from driftform.types import Genome
from driftform.util.files import is_directory, is_file


def open_agent(
    text: str, scenario: str | None = None, settings: Sequence[str] = (), use: Mapping[str, str | None] | None = None
) -> Design:
    """Find the agent that ``text`` names and build it.

    Raises InputError if it does not exist; the message says what was looked for. Raises WorkFailedError if no body can be built.
    """
    design = Design.build(_find(text, scenario, settings, use), _shorten(text), scenario, settings, use)
    name = text if text == _shorten(text) else design.opened_as
    return replace(design, opened_as=name_agent(name, settings))


def name_agent(text: str, settings: Sequence[str]) -> str:
    """Return the arguments that open an agent again with the same settings, but for those of exporters."""
    kept = (setting for setting in settings if not setting.lstrip().startswith("exporter."))
    return shlex.join([text, *(word for setting in kept for word in ("--set", setting))])


def open_best(run: StoredRun, target: str) -> StoredAgent:
    """Return the best agent of a run for a target, named after both.

    Raises InputError if the run has no such target, or no evaluation yet that did not fail.
    """
    names = run.study.scenario.target_names
    if target not in names:
        raise InputError(f"{run.path} has no target '{target}'{did_you_mean(target, names)}")
    best = find_best(run, target)
    if best is None:
        raise run.refuse_unsound()
    return replace(best, name=f"{run.name}-{target}")


def _find(
    text: str, scenario: str | None, settings: Sequence[str], use: Mapping[str, str | None] | None
) -> StoredAgent:
    path = Path(text)
    if is_file(path):
        return StoredAgent.read(path)
    if text.startswith("sphere:"):
        return _make_sphere(text, load_study(scenario, settings, use=use))
    left, colon, right = text.rpartition(":")
    # The rules of a genotype have colons too, and so have some directories.
    if colon and (is_directory(Path(left)) or not any(c in text for c in " |")):
        return open_best(StoredRun.open(Path(left)), right)
    if text and is_directory(path):
        if (path / DATABASE).is_file():
            raise InputError(f"AGENT '{text}' is a run: name one of its targets too, such as {text}:TP1")
        raise InputError(f"AGENT '{text}' is a directory, and holds no run")
    if path.suffix == ".json" or "/" in text or "\\" in text:
        raise InputError(f"AGENT '{_shorten(text)}': no such file")
    study = load_study(scenario, settings, use=use)
    grammar = study.make_plugin("grammar")
    try:
        genome = read_genome(grammar, text)
    except DriftformError as error:
        raise InputError(
            f"AGENT '{_shorten(text)}' is not a file, not RUN:TARGET and not a genome: {_shorten(str(error), 300)}"
        ) from None
    name = "word-" + hashlib.sha256(" ".join(genome.symbols).encode()).hexdigest()[:8]
    return StoredAgent(name, genome, study.environment(), {})


def _make_sphere(text: str, study: Study) -> StoredAgent:
    """Return a homogeneous sphere, neutral in the water of a study, as a body of one's own."""
    size = re.fullmatch(r"sphere:(\d+\.?\d*)mm", text)
    if not 0.0005 <= (diameter := float(size[1]) / 1000 if size else 0.0) <= 2:
        raise InputError(f"AGENT '{text}': a sphere is named by its diameter from 0.5 to 2000 mm, such as sphere:60mm")
    sphere = make_sphere(diameter, study.scenario.fluid)
    profile = (sphere.body.outer[::-1] * [-1.0, 1.0] + [diameter / 2, 0.0]).clip(min=0.0).round(9).tolist()
    builder = {"use": "profile", "profile": profile, "mass": sphere.mass.mass, "cog": diameter / 2}
    environment = {**study.environment(), "grammar": {"use": "fixed"}, "builder": builder}
    return StoredAgent(text.replace(":", "-"), Genome("fixed", ()), environment, {})


def _shorten(text: str, length: int = 60) -> str:
    return text if len(text) <= length else f"{text[: length - 4]} ..."
