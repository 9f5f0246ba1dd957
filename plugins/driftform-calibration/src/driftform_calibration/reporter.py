"""The section of a report that shows the factors by which a run's model was calibrated."""

from driftform.interfaces import Reporter, ReportJob, Table
from driftform_calibration.interval_figure import intervals_svg


class CalibrationReporter(Reporter[Table]):
    """The factors on the model of a run, with the intervals that hold them with a probability of 90 %."""

    name = "calibration"
    heading = "Calibration"

    def write(self, job: ReportJob) -> str:
        """Return the picture of the factors as SVG; nothing for a model that was not calibrated."""
        calibration = job.scenario.calibration
        if not calibration.intervals:
            return ""
        count = calibration.tracks
        return intervals_svg(
            calibration.intervals, f"Calibration by {count} filmed flights" if count else "Calibration"
        )
