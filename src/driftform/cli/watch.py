"""``driftform watch``."""

from pathlib import Path
from typing import Annotated, Any

import typer

from driftform.cli.display import View, format_failures, format_throughput, progress_line
from driftform.cli.options import Json
from driftform.runs.status import RunStatus, Throughput
from driftform.util.progress import REFRESH

RUNNING, WRITING, FINISHED, STOPPED = "running", "writing the best agents", "finished", "stopped"


def watch(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    once: Annotated[bool, typer.Option("--once", help="Tell where the run stands now, and end.")] = False,
    interval: Annotated[
        float, typer.Option("--interval", metavar="S", min=0.1, help="How often to look, s.")
    ] = 1.0,
    json: Json = False,
) -> None:
    """Look on at a run from another terminal while it goes on, until it ends or Ctrl-C; the run is left alone."""
    from driftform.cli.output import print_json
    from driftform.runs.directory import check_run

    onlooker = RunMonitor(run, check_run(run))
    onlooker.look()
    if json:
        print_json(_facts(onlooker))
    elif once:
        _print_once(onlooker)
    else:
        try:
            _follow(onlooker, interval)
        except KeyboardInterrupt:
            # To look away is no failure, and nothing of the run's.
            return
        print(_last_words(onlooker))


class RunMonitor:
    """Reads what is new of a run, and nothing twice; holds neither its lock nor its database open.

    ``standing`` is where the run stands, ``state`` whether anyone works on it, as of the last :meth:`poll`.
    """

    def __init__(self, directory: Path, database: Path) -> None:
        self.directory = directory
        self.state = STOPPED
        self._database = database
        # Evaluations are stored as they come: all below the first are known, and of those above some.
        self._first = 0
        self._above: set[int] = set()
        self.standing = RunStatus((), 0)
        self.pace = Throughput(0)

    def look(self) -> None:
        """Read what is new.

        Raises
        ------
        InputError
            where the database is damaged.
        """
        from driftform.runs.directory import is_worked_on
        from driftform.runs.store import Store

        # Asked first: who has let go of the run has written all that is read below.
        held = is_worked_on(self.directory)
        with Store.open(self._database, read_only=True, check=False) as store:
            targets, budget = self._of_study(store.read_study())
            begins = not self.standing.targets
            if begins:
                self.standing = RunStatus(targets, budget)
            self.standing.budget = budget
            for brief in store.read_summaries(targets, self._first):
                if brief.index not in self._above:
                    self._above.add(brief.index)
                    self.standing.add(
                        brief.index, brief.generation, brief.population, brief.failed, brief.fitness
                    )
        while self._first in self._above:
            self._above.remove(self._first)
            self._first += 1
        if begins:
            self.pace = Throughput(self.standing.done)
        self.pace.mark(self.standing.done)
        complete = self.standing.done >= budget
        self.state = (WRITING if complete else RUNNING) if held else (FINISHED if complete else STOPPED)

    @property
    def is_over(self) -> bool:
        """Whether nobody works on the run any more."""
        return self.state in (FINISHED, STOPPED)

    def _of_study(self, document: dict[str, Any]) -> tuple[list[str], int]:
        """Targets and budget; a study need not be one that could be carried out here."""
        from driftform.errors import InputError

        try:
            return list(document["targets"].keys()), int(document["run"]["evaluations"])
        except (KeyError, TypeError, AttributeError, ValueError):
            raise InputError(
                f"{self._database}: is damaged: its study has no targets, or no budget"
            ) from None


def _view(onlooker: RunMonitor, fits: bool) -> View:
    standing, pace = onlooker.standing, onlooker.pace
    speed = "" if onlooker.is_over else format_throughput(standing, pace)
    facts = (onlooker.state, speed, format_failures(standing.failed))
    footer = "" if onlooker.is_over else f"{onlooker.directory}: Ctrl-C ends the watching, not the run"
    return View(standing, pace, facts, footer, fits)


def _follow(onlooker: RunMonitor, interval: float) -> None:
    import sys
    import time

    if not sys.stdout.isatty():
        told = -1
        while not onlooker.is_over:
            if onlooker.standing.done > told:
                print(progress_line(onlooker.standing, onlooker.pace), flush=True)
            told = onlooker.standing.done
            time.sleep(interval)
            onlooker.look()
        return
    from rich.live import Live

    with Live(get_renderable=lambda: _view(onlooker, fits=True), refresh_per_second=REFRESH):
        while not onlooker.is_over:
            time.sleep(interval)
            onlooker.look()


def _print_once(onlooker: RunMonitor) -> None:
    import sys

    from rich.console import Console

    # Where no terminal says how wide it is, nothing is cut.
    Console(highlight=False, width=None if sys.stdout.isatty() else 200).print(_view(onlooker, fits=False))
    if onlooker.is_over:
        print(_last_words(onlooker))


def _last_words(onlooker: RunMonitor) -> str:
    from driftform.runs.directory import resume_command

    standing = onlooker.standing
    if onlooker.state == FINISHED:
        return f"finished: {standing.done} evaluations ({standing.failed} failed), best agents in {onlooker.directory}/best/"
    return (
        f"stopped after {standing.done} of {standing.budget} evaluations; "
        f"go on with: {resume_command(onlooker.directory)}"
    )


def _facts(onlooker: RunMonitor) -> dict[str, Any]:
    standing = onlooker.standing
    return {
        "run": str(onlooker.directory),
        "state": onlooker.state,
        "evaluations": standing.done,
        "budget": standing.budget,
        "failed": standing.failed,
        "targets": {
            name: {
                "fitness": target.best if target.index >= 0 else None,
                "error_percent": 100 - target.best if target.index >= 0 else None,
                "evaluation": target.index if target.index >= 0 else None,
                "generation": target.generation if target.generation >= 0 else None,
                "mean_fitness": target.mean,
                "failed": target.failed,
            }
            for name, target in standing.targets.items()
        },
    }
