"""From filmed flights to factors on the model: tracks, camera, fit, intervals, and the next experiment."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    import typer

    from driftform.interfaces import Reporter


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform drop`` and ``driftform calibrate``."""
    from driftform_calibration.calibrate_command import calibrate
    from driftform_calibration.drop_command import drop

    app.command("drop")(drop)
    app.command("calibrate")(calibrate)


@hookimpl
def driftform_reporter() -> "type[Reporter[Any]]":
    """The factors of a calibrated model, on the page of a run."""
    from driftform_calibration.reporter import CalibrationReporter

    return CalibrationReporter
