"""From filmed flights to factors on the model: tracks, camera, fit, intervals, and the next experiment."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from driftform import hookimpl

if TYPE_CHECKING:
    import typer

    from driftform.interfaces import ReportJob


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform drop`` and ``driftform calibrate``."""
    from driftform_calibration.commands import calibrate, drop

    app.command("drop", rich_help_panel="Workshop")(drop)
    app.command("calibrate", rich_help_panel="Workshop")(calibrate)


@hookimpl
def driftform_report(job: "ReportJob") -> Mapping[str, str]:
    """Return a table of the factors on the model of a run; nothing for a model that was not calibrated."""
    calibration = job.scenario.calibration
    if not calibration.intervals:
        return {}
    from driftform.util import notebook

    rows = [(name, f"{v:.3g}", f"{low:.3g} to {high:.3g}") for name, (v, low, high) in calibration.intervals.items()]
    title = f"By {calibration.tracks} filmed flights" if calibration.tracks else ""
    return {"Calibration": notebook.show_table(("factor", "value", "90 % interval"), rows, title)}
