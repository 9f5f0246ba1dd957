"""Fit the model to the track of a film: a sphere of 15 mm that settles in silicon oil (Ten Cate and others 2002)."""

from pathlib import Path

import driftform as df
from driftform_calibration.films import calibrate_design

TRACKS = Path(__file__).parent.parent / "tracks"

# `C` is the core alone; the study next to the track has the oil, and a core of the sphere's size.
sphere = df.open_agent("C", scenario=str(TRACKS / "ten-cate-e4.toml"))
found = calibrate_design(sphere, TRACKS / "ten-cate-e4.csv", printed_mass=0.0019792)

drag = found.factors["cross_drag"]
print(f"drag {drag.value:.2f} times the model's, 90 % interval {drag.low:.2f} to {drag.high:.2f}")
print(f"root mean square distance of film and flight: {1000 * found.residual:.1f} mm")
