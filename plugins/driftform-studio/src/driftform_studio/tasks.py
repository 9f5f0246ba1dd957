"""Long work of the page: it runs in a thread, and the page polls its progress."""

from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from secrets import token_hex
from typing import Any

from driftform.errors import DriftformError, InputError, describe_error
from driftform.util import progress

KEPT = 50
"""Tasks that are remembered; each has a few kB of results."""


Task = dict[str, Any]
"""Work under way, or done, as the page reads it: ``done`` of ``total`` steps of ``what``, and its ``result`` or ``errors``."""


class Tasks:
    """The tasks of a server, two at a time."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(2, thread_name_prefix="task")
        self._tasks: OrderedDict[str, Task] = OrderedDict()

    def start(self, work: Callable[[], Any]) -> str:
        """Begin work, and return the name of its task."""
        name = token_hex(8)
        task: Task = {"what": "", "done": 0, "total": 0, "is_over": False, "errors": [], "result": None}
        self._tasks[name] = task
        while len(self._tasks) > KEPT:
            self._tasks.popitem(last=False)
        self._pool.submit(self._run, task, work)
        return name

    def find(self, name: str) -> Task:
        """Return a task. Raises InputError if no task has this name."""
        if name not in self._tasks:
            raise InputError("the server was started again meanwhile: ask once more")
        return self._tasks[name]

    def close(self) -> None:
        """Begin nothing more."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _run(self, task: Task, work: Callable[[], Any]) -> None:
        def show(what: str, done: int, total: int) -> None:
            task.update(what=what, done=done, total=total)

        try:
            with progress.show_progress(show):
                task["result"] = work()
        except DriftformError as error:
            task["errors"] = [str(line) for line in error.args]
        except Exception as error:
            task["errors"] = [describe_error(error, with_place=True)]
        task["is_over"] = True
