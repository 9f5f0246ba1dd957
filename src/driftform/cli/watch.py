"""``driftform watch``."""

from types import SimpleNamespace
from typing import TYPE_CHECKING

from driftform.cli.options import FILE, declare

if TYPE_CHECKING:
    from driftform.cli.display import View
    from driftform.runs.monitor import RunMonitor


@declare(FILE, "run", "once", "interval", "json")
def watch(given: SimpleNamespace) -> None:
    """Show the progress of a run from another terminal until the run ends or you press Ctrl-C; changes no file."""
    from driftform.cli.output import print_json
    from driftform.runs.monitor import RunMonitor

    monitor = RunMonitor(given.run)
    monitor.poll()
    if given.json:
        print_json(monitor.document())
    elif given.once:
        import sys

        from rich.console import Console

        # Off a terminal the width is unknown, so nothing is cut.
        Console(highlight=False, width=None if sys.stdout.isatty() else 1000).print(_view(monitor, fits=False))
        if monitor.is_over:
            print(monitor.describe_end())
    else:
        try:
            _follow(monitor, given.interval)
        except KeyboardInterrupt:
            # Stopping the watch is not a failure, and does not affect the run.
            return
        print(monitor.describe_end())


def _view(monitor: "RunMonitor", fits: bool) -> "View":
    from driftform.cli.display import View, format_failures, format_throughput

    status, throughput = monitor.status, monitor.throughput
    speed = "" if monitor.is_over else format_throughput(status, throughput)
    facts = (monitor.state, speed, format_failures(status.failed))
    footer = "" if monitor.is_over else f"{monitor.directory}: Ctrl-C ends watching, not the run"
    return View(status, throughput, facts, footer, fits)


def _follow(monitor: "RunMonitor", interval: float | None) -> None:
    import sys
    import time

    from driftform.cli.display import progress_line
    from driftform.util.progress import LINE_EVERY_S, REFRESH

    live = sys.stdout.isatty()
    interval = interval or (1.0 if live else LINE_EVERY_S)
    if not live:
        printed = -1
        while not monitor.is_over:
            if monitor.status.done > printed:
                print(progress_line(monitor.status, monitor.throughput), flush=True)
            printed = monitor.status.done
            time.sleep(interval)
            monitor.poll()
        return
    from rich.live import Live

    with Live(get_renderable=lambda: _view(monitor, fits=True), refresh_per_second=REFRESH):
        while not monitor.is_over:
            time.sleep(interval)
            monitor.poll()
