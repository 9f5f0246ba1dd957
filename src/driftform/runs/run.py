"""A run: the one owner of its directory, its store and its lock."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from driftform.errors import InputError
from driftform.runs.directory import (
    DATABASE,
    check_new,
    check_run,
    is_worked_on,
    lock_run,
    resume_command,
    write_inputs,
)
from driftform.runs.monitor import RunMonitor, read_aims
from driftform.runs.store import Store
from driftform.study import Document, Study, load_study
from driftform.util.files import make_directory


class StoredRun:
    """A run on disk.

    A run that is opened to be read opens its store for each question, so that it sees what another process has
    written since. A run that is created or resumed holds the lock of its directory until its context ends.

    Attributes:
        path: of its directory.
        study: what is searched for: scenario, plugins and their options, seed and budget.
    """

    def __init__(self, path: Path, study: Study) -> None:
        self.path = path
        self.study = study

    @classmethod
    def open(cls, directory: Path, evaluations: int | None = None, *, check: bool = True) -> Self:
        """Open a run to read it, finished or not; ``evaluations`` replace its budget.

        Without ``check`` the database is not searched for damage first; damage is then reported where it is read.

        Raises InputError if the directory is not a run, or its study cannot be carried out here.
        """
        database = check_run(directory)
        with Store.open(database, read_only=True, check=check) as store:
            document = Document(str(database), store.read_study())
        return cls(directory, load_study(document, run={"evaluations": evaluations}))

    @classmethod
    @contextmanager
    def create(cls, directory: Path, study: Study, *, again: bool = False) -> Iterator[Self]:
        """Begin a run in a new or empty directory, and hold its lock; ``again`` continues the run of the study that it holds.

        Raises InputError if the study has no targets, or the directory holds something else.
        """
        study.check_search()
        if not (again and (directory / DATABASE).is_file()):
            check_new(directory)
        make_directory(directory)
        with lock_run(directory):
            if again and (directory / DATABASE).is_file():
                run = cls.open(directory)
                run._check_same(study)
            else:
                # Another process may have been quicker.
                check_new(directory)
                # First, and all at once: whatever stops a run after this line, it can be resumed.
                Store.create(directory / DATABASE, dict(study.document)).close()
                write_inputs(directory, study, study.document)
                run = cls(directory, study)
            yield run

    @classmethod
    @contextmanager
    def resume(cls, directory: Path, evaluations: int | None = None) -> Iterator[Self]:
        """Open a run to continue it, with a larger budget if ``evaluations`` is given, and hold its lock.

        Nothing is written before the run advances.

        Raises InputError if the directory is not a run, another process works on it, or it holds more evaluations
        already.
        """
        check_run(directory)
        with lock_run(directory):
            run = cls.open(directory, evaluations)
            run.study.check_formats()
            if evaluations is not None:
                run._check_budget(evaluations)
            yield run

    def _check_budget(self, evaluations: int) -> None:
        with self.read() as store:
            # Evaluations are stored as they come: there may be gaps below the last of them.
            least = store.last_index() + 1
        if evaluations < least:
            raise InputError(
                f"--evaluations {evaluations} is less than {self.path} holds already; give at least {least}"
            )

    def _check_same(self, study: Study) -> None:
        wanted, stored = study.document, self.study.document
        if wanted != stored:
            differing = sorted(key for key in {*wanted, *stored} if wanted.get(key) != stored.get(key))
            raise InputError(
                f"{self.path}: holds a run with other settings ({', '.join(differing)}); choose another --out"
            )

    @property
    def name(self) -> str:
        """The name of its directory."""
        return self.path.resolve().name

    @property
    def resume_command(self) -> str:
        """The command that continues it."""
        return resume_command(self.path)

    @staticmethod
    def glance(directory: Path) -> dict[str, Any]:
        """Return a few facts of a run, also of one whose study cannot be carried out here.

        Its ``title``, the number of ``targets``, evaluations ``done`` and their ``budget``, and whether it
        ``is_worked_on``.

        Raises InputError if the directory is not a run, or the run is damaged.
        """
        database = check_run(directory)
        with Store.open(database, read_only=True, check=False) as store:
            document, done = store.read_study(), store.count()
        targets, budget = read_aims(database, document)
        return {
            "title": str(document.get("title", "")),
            "targets": len(targets),
            "done": done,
            "budget": budget,
            "is_worked_on": is_worked_on(directory),
        }

    def monitor(self) -> RunMonitor:
        """Return a monitor of it, to follow what other processes write; call its ``poll`` first."""
        return RunMonitor(self.path)

    def read(self, *, check: bool = False) -> Store:
        """Open its store for reading; a context manager that closes it."""
        return Store.open(self.path / DATABASE, read_only=True, check=check)

    @contextmanager
    def write(self) -> Iterator[Store]:
        """Open its store for writing, with the study's budget in it; requires the lock."""
        with Store.open(self.path / DATABASE, check=False) as store:
            document = store.read_study()
            table = document.get("run", {})
            if table.get("evaluations") != self.study.evaluations:
                document = {**document, "run": {**table, "evaluations": self.study.evaluations}}
                store.write_facts("study", document)
            # The database decides: an interruption before this line is repaired by the next call.
            write_inputs(self.path, self.study, document)
            yield store

    def count(self) -> tuple[int, int]:
        """Return the number of evaluations stored, and how many of them failed."""
        with self.read() as store:
            return store.count(), store.count_failed()

    def describe_failures(self) -> dict[str, Any] | None:
        """Return the commonest kind of failure: its first ``reason``, and the ``count``; ``None`` without failures."""
        with self.read() as store:
            reason, count = store.find_commonest_failure()
        return {"reason": reason, "count": count} if count else None

    def refuse_unsound(self) -> InputError:
        """Return the error for a request that needs a successful evaluation, before there is one."""
        return InputError(
            f"{self.path} has no evaluation yet that did not fail; wait, or resume it with: {self.resume_command}"
        )
