"""An agent by what names it: the path of an agent.json, RUN:TARGET, or the text of a genome."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from driftform.errors import DriftformError, InputError, WorkFailedError, did_you_mean
from driftform.interfaces import ExportJob
from driftform.pipeline import Pipeline
from driftform.runs.agent_file import StoredAgent, agent_document, read_agent
from driftform.runs.directory import DATABASE, check_run, find_best_agent, resume_command
from driftform.runs.store import Store
from driftform.study import Document, Study, load_study
from driftform.types import Agent, Trajectory
from driftform.util.files import is_directory, is_file, safe_stem


@dataclass(frozen=True, eq=False)
class Opened:
    """An agent, built: its ``name`` is safe for files, ``stored`` serves for an agent.json."""

    name: str
    stored: StoredAgent
    study: Study
    pipeline: Pipeline
    agent: Agent

    def export_job(self) -> ExportJob:
        """The agent as exporters receive it."""
        return ExportJob(self.name, self.agent, self.study.scenario, agent_document(self.stored))

    def fly(self) -> Trajectory:
        """The agent's flight through its scenario.

        Raises
        ------
        WorkFailedError
            where there is none; a flight that ended by a failure is one.
        """
        try:
            [flight] = self.pipeline.fly([self.agent])
        except (ArithmeticError, RuntimeError) as error:
            raise WorkFailedError(f"{self.name}: cannot be flown: {type(error).__name__}: {error}") from None
        return flight


def open_agent(
    text: str,
    scenario: str | None = None,
    settings: Sequence[str] = (),
    use: Mapping[str, str | None] | None = None,
) -> Opened:
    """Find the agent that ``text`` names and build it.

    Raises
    ------
    InputError
        where there is none; the message says what was looked for.
    """
    return build_stored(_stored(text, scenario), _short(text), scenario, settings, use)


def build_stored(
    stored: StoredAgent,
    label: str,
    scenario: str | None = None,
    settings: Sequence[str] = (),
    use: Mapping[str, str | None] | None = None,
) -> Opened:
    """Build an agent in its environment, or in another; ``label`` names it in errors.

    Raises
    ------
    InputError
        where the environment is not sound, or the genome does not belong to it.
    WorkFailedError
        where it makes no body.
    """
    source: str | Document = Document(label, stored.environment)
    if scenario is not None:
        # The agent stays what it is; only its surroundings change.
        other = load_study(scenario).document
        made = {
            seam: stored.environment[seam] for seam in ("grammar", "builder") if seam in stored.environment
        }
        source = Document(scenario, {**other, **made})
    study = load_study(source, settings, use=use, run={"seed": 0})
    pipeline = study.make_pipeline()
    if stored.genome.grammar != pipeline.grammar.name:
        raise InputError(
            f"{label}: is a genome of grammar '{stored.genome.grammar}', its study uses '{pipeline.grammar.name}'"
        )
    try:
        agent = pipeline.make_agent(stored.genome)
    except ValueError as error:
        raise InputError(f"{label}: {error}") from None
    except (ArithmeticError, RuntimeError) as error:
        # Options that are sound one by one can still ask together for what cannot be computed.
        raise WorkFailedError(f"{label}: cannot be built: {type(error).__name__}: {error}") from None
    return Opened(safe_stem(stored.name), stored, study, pipeline, agent)


def _stored(text: str, scenario: str | None) -> StoredAgent:
    path = Path(text)
    if is_file(path):
        return read_agent(path)
    left, colon, right = text.rpartition(":")
    # The rules of a genotype have colons too, and so have some directories.
    if colon and (is_directory(Path(left)) or not any(c in text for c in " |")):
        return _of_run(Path(left), right)
    if text and is_directory(path):
        if (path / DATABASE).is_file():
            raise InputError(f"AGENT '{text}' is a run: name one of its targets too, such as {text}:TP1")
        raise InputError(f"AGENT '{text}' is a directory, and holds no run")
    if path.suffix == ".json" or "/" in text or "\\" in text:
        raise InputError(f"AGENT '{_short(text)}': no such file")
    study = load_study(scenario)
    grammar = study.make_plugin("grammar")
    try:
        genome = grammar.parse(text)
    except DriftformError as error:
        raise InputError(
            f"AGENT '{_short(text)}' is no file, no RUN:TARGET, and no word: {_short(str(error), 300)}"
        ) from None
    name = "word-" + hashlib.sha256(" ".join(genome.symbols).encode()).hexdigest()[:8]
    return StoredAgent(name, genome, study.environment(), {})


def _of_run(directory: Path, target: str) -> StoredAgent:
    database = check_run(directory)
    with Store.open(database, read_only=True) as store:
        study = load_study(Document(str(database), store.read_study()))
        names = study.scenario.target_names
        if target not in names:
            raise InputError(f"{directory} has no target '{target}'{did_you_mean(target, names)}")
        best = find_best_agent(study, store, target)
        if best is None:
            raise InputError(
                f"{directory} has no evaluation yet that did not fail; wait, or go on with it by: "
                f"{resume_command(directory)}"
            )
    return replace(best, name=f"{directory.resolve().name}-{target}")


def _short(text: str, length: int = 60) -> str:
    return text if len(text) <= length else f"{text[: length - 4]} ..."
