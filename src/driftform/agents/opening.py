"""Open an agent by what names it: the path of an agent.json, RUN:TARGET, or the text of a genome."""

import hashlib
import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from driftform.agents.design import Design, ignore
from driftform.errors import DriftformError, InputError, did_you_mean
from driftform.geometry import hull_volume
from driftform.interfaces import Printer, PrintJob
from driftform.printing.check import (
    check_print_job,
    extract_attachment,
    require_judgement,
    sum_volumes,
    write_files,
)
from driftform.printing.exporter_settings import KIT_FILE, list_kit_settings, read_kit_settings
from driftform.runs.agent_file import StoredAgent, read_agent
from driftform.runs.directory import DATABASE
from driftform.runs.run import Run
from driftform.seams import require_genome
from driftform.study import load_study
from driftform.types import Finding
from driftform.util.files import is_directory, is_file


def open_agent(
    text: str,
    scenario: str | None = None,
    settings: Sequence[str] = (),
    use: Mapping[str, str | None] | None = None,
) -> Design:
    """Find the agent that ``text`` names and build it.

    Raises
    ------
    InputError
        if there is none; the message says what was looked for.
    WorkFailedError
        if no body can be built.
    """
    design = Design.build(_find(text, scenario, settings, use), _shorten(text), scenario, settings, use)
    name = text if text == _shorten(text) else design.opened_as
    return replace(design, opened_as=name_agent(name, settings))


def name_agent(text: str, settings: Sequence[str]) -> str:
    """Return the arguments that open an agent again with the same settings, but for those of exporters."""
    kept = (setting for setting in settings if not setting.lstrip().startswith("exporter."))
    return shlex.join([text, *(word for setting in kept for word in ("--set", setting))])


def open_best(run: Run, target: str) -> StoredAgent:
    """Return the best agent of a run for a target, named after both.

    Raises
    ------
    InputError
        if the run has no such target, or no evaluation yet that did not fail.
    """
    names = run.study.scenario.target_names
    if target not in names:
        raise InputError(f"{run.path} has no target '{target}'{did_you_mean(target, names)}")
    best = run.find_best(target)
    if best is None:
        raise run.refuse_unsound()
    return replace(best, name=f"{run.name}-{target}")


def check_file(
    path: str | os.PathLike[str],
    agent: str | None = None,
    settings: Sequence[str] = (),
    *,
    printer: Printer | None = None,
    kit: bool = False,
    programs: bool = True,
    attached: bool = False,
    on_program: Callable[[str], None] = ignore,
) -> list[Finding]:
    """Return what the installed checkers find about a printable file.

    Parameters
    ----------
    path
        of the file.
    agent
        what the file is to be of; ``None`` for the agent.json that is attached to it or lies beside it, if any.
    settings
        ``key=value`` of the study, as ``--set`` takes them.
    attached
        whether OpenSCAD source that is attached to the file, or lies beside it under its name, is rendered: source may
        read files, and take all time and memory that OpenSCAD is given.
    printer, kit, programs, on_program
        as for :meth:`driftform.agents.design.Design.check`. A 3MF file of a kit says itself that it is one, for which printer,
        and with which options it was made; ``settings`` come before these.

    Raises
    ------
    InputError
        if the file cannot be read, or the agent of a kit is not known.
    WorkFailedError
        if nothing could be checked.
    """
    path = Path(path)
    with TemporaryDirectory() as name:
        folder = Path(name)
        known = agent or extract_attachment(path, "agent.json", folder) or path.with_name("agent.json")
        inside, beside = extract_attachment(path, ".scad", folder), path.with_suffix(".scad")
        source = inside or (beside if is_file(beside) and beside != path else None)
        where = "attached to it" if inside else f"beside it, {beside.name},"
        job = PrintJob(
            (path,),
            printer or Printer(),
            source=source if attached else None,
            withheld=None if source is None or attached else f"OpenSCAD source {where}",
        )
        if agent is None and not is_file(Path(known)):
            if kit:
                raise InputError(f"--kit: the agent of {path} is not known; name it with --agent")
            study = load_study(None, settings, run={"seed": 0})
        else:
            format = path.suffix[1:].lower()
            if (options := extract_attachment(path, KIT_FILE, folder)) is not None:
                kit = True
                settings = [*read_kit_settings(options, f"{path}: its {KIT_FILE}", format), *settings]
            elif kit:
                settings = [*settings, *list_kit_settings((format,), job.printer)]
            design = open_agent(str(known), settings=settings)
            study, export = design.study, design.export_job()
            volume = hull_volume(design.agent.body)
            if kit:
                # In a format that holds one solid there is a file for each part.
                written = write_files(study, export, format, folder)
                named = [file for file in written if Path(file.path).name == path.name]
                volume = sum_volumes(named or written) or volume
            if options is not None and printer is None:
                made = study.make_exporter(format).options
                job = replace(job, printer=Printer(made.nozzle, made.bed))
            job = replace(job, export=export, volume=volume)
        findings = list(check_print_job(job, study, programs, on_program))
    require_judgement(findings)
    return findings


def _find(
    text: str, scenario: str | None, settings: Sequence[str], use: Mapping[str, str | None] | None
) -> StoredAgent:
    path = Path(text)
    if is_file(path):
        return read_agent(path)
    left, colon, right = text.rpartition(":")
    # The rules of a genotype have colons too, and so have some directories.
    if colon and (is_directory(Path(left)) or not any(c in text for c in " |")):
        return open_best(Run.open(Path(left)), right)
    if text and is_directory(path):
        if (path / DATABASE).is_file():
            raise InputError(f"AGENT '{text}' is a run: name one of its targets too, such as {text}:TP1")
        raise InputError(f"AGENT '{text}' is a directory, and holds no run")
    if path.suffix == ".json" or "/" in text or "\\" in text:
        raise InputError(f"AGENT '{_shorten(text)}': no such file")
    study = load_study(scenario, settings, use=use)
    grammar = study.make_plugin("grammar")
    try:
        genome = require_genome(grammar.parse(text), grammar, "parse")
    except DriftformError as error:
        raise InputError(
            f"AGENT '{_shorten(text)}' is not a file, not RUN:TARGET and not a genome: {_shorten(str(error), 300)}"
        ) from None
    name = "word-" + hashlib.sha256(" ".join(genome.symbols).encode()).hexdigest()[:8]
    return StoredAgent(name, genome, study.environment(), {})


def _shorten(text: str, length: int = 60) -> str:
    return text if len(text) <= length else f"{text[: length - 4]} ..."
