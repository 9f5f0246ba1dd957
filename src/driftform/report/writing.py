"""A run -> its page as a file."""

from pathlib import Path

from driftform.report.contents import Contents, collect_contents
from driftform.report.page import page_html
from driftform.runs.run import Run
from driftform.util.files import make_directory, write_text


def write_report(run: Run, path: Path | None = None) -> tuple[Contents, Path]:
    """Write the page of a run, by default ``report.html`` in it; return what it holds, and its path.

    Raises
    ------
    InputError
        if the run is damaged.
    WorkFailedError
        if no evaluation succeeded yet.
    """
    contents = collect_contents(run)
    path = path or run.path / "report.html"
    make_directory(path.parent)
    write_text(path, page_html(contents))
    return contents, path
