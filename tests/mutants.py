"""Changes of one expression each, all over the house, that ``tests/mutations.py --chosen`` makes: terms that are often zero.

A file is found by its name, or else by the expression, which no other file has; tests by the end of their path.
"""

FILMS = "driftform-calibration/tests/test_calibrate_command.py"

CHOSEN = (
    # A body and its mass.
    ("mass.py", "* density + core.mass * core.cog\n", "* density\n", ("tests/agent",)),
    ("mass.py", "core.mass * core.cog**2 - mass * cog**2", "-mass * cog**2", ("tests/agent",)),
    ("mass_elements.py", "(mass * x - core.mass * core.cog) / hull", "mass * x / hull", ("tests/agent",)),
    ("mass_elements.py", "element.mass * (element.x - x) ** 2", "element.mass * element.x**2", ("tests/agent",)),
    ("clearance.py", "offset @ across + x * sine", "offset @ across - x * sine", ("tests/agent",)),
    ("slices.py", "3 * rb * rb) / 12", "2 * rb * rb) / 12", ("tests/agent",)),
    ("distance.py", "/ square, 0.0), 1.0)", "/ square, 0.0), 9.0)", ("tests/agent",)),
    # Disturbed conditions.
    ("disturbances.py", "(intervals.T - within) / count", "(intervals.T - 0.5) / count", ("test_disturbances.py",)),
    (
        "disturbances.py",
        "+ float(np.rad2deg(condition.yaw))",
        "- float(np.rad2deg(condition.yaw))",
        ("test_disturbances.py",),
    ),
    (
        "disturbances.py",
        "scenario.release_frame().T @ offset",
        "scenario.release_frame() @ offset",
        ("test_disturbances.py",),
    ),
    ("disturbances.py", "flow.swirl + condition.swirl", "condition.swirl", ("test_disturbances.py",)),
    ("prints.py", "-condition.wall if", "condition.wall if", ("water/test_prints.py",)),
    (
        "disturbances.py",
        "float(along.max()) + 2 * straight",
        "float(along.min()) + 2 * straight",
        ("test_disturbances.py",),
    ),
    ("factors.py", "np.where(z > 0, high", "np.where(z < 0, high", ("test_factors.py",)),
    ("factors.py", "value + z / self.quantile *", "value + z *", ("test_factors.py",)),
    # Water.
    ("misfit.py", "share = 0.5 * share", "share = 0.0 * share", ("test_misfit.py",)),
    ("misfit.py", "along + float(np.hypot(*body.outer.T).max()) <=", "along <=", ("test_misfit.py",)),
    ("wetted.py", "flow.speed * flow.speed * area / total", "flow.speed * area / total", ("test_wetted.py",)),
    ("wetted.py", "axis.radii * level).min()", "axis.radii).min()", ("test_wetted.py",)),
    ("regime.py", "reynolds ** (1 / 6)", "reynolds ** (1 / 5)", ("test_regime.py",)),
    ("regime.py", "+ flow.upstream", "+ 0.0", ("test_regime.py",)),
    # Flights.
    ("stability.py", '- n["inverse"][4, 2] * net', "", ("motion/test_stability.py",)),
    ("way.py", "offsets * (through / straight)", "offsets * (straight / through)", ("motion/test_way.py",)),
    (
        "way.py",
        "float(np.hypot(off[1], off[2])) - outlet.opening.radius",
        "float(np.hypot(off[1], off[2]))",
        ("motion/test_way.py",),
    ),
    # The promise, and what it depends on.
    ("misses.py", "share * (len(ordered) + 1)", "share * len(ordered)", ("test_misses.py",)),
    ("misses.py", "len(offsets) - 1 - int(used.sum())", "len(offsets)", ("runs/test_misses.py",)),
    ("misses.py", "slopes[rows] ** 2 - rest / len(offsets)", "slopes[rows] ** 2", ("runs/test_misses.py",)),
    ("finalists.py", "len(targets)), 100.0)", "len(targets)), 95.0)", ("test_finalists.py",)),
    ("finalists.py", "(bound(index, end) >= bars[index])", "(bound(index, end) > bars[index])", ("test_finalists.py",)),
    ("finalists.py", "2 * len(column) > len(fitness)", "len(column) > 0", ("test_finalists.py",)),
    ("finalists.py", "range(robustness.conditions, len", "range(0, len", ("test_finalists.py",)),
    ("finalists.py", "-undisturbed[i], i))", "undisturbed[i], i))", ("test_finalists.py",)),
    ("survey.py", "{count // 4, count // 2, count}", "{count // 2, count}", ("test_survey.py",)),
    ("survey.py", "np.vstack([undisturbed, disturbed])", "np.vstack([disturbed])", ("test_survey.py",)),
    ("disturbed.py", "(study.seed, 1)", "(study.seed, 0)", ("test_survey.py", "test_finalists.py")),
    ("status.py", "enumerate(self._least, start=1)", "enumerate(self._least)", ("test_status.py",)),
    ("coverage.py", "row + 0.5 - self.shape[1] / 2", "row - self.shape[1] / 2", ("runs/test_coverage.py",)),
    ("coverage.py", "inlet.axes[[0, 2, 1]]", "inlet.axes[[0, 1, 2]]", ("runs/test_coverage.py",)),
    # Ballast.
    ("trim.py", "(kit.mass * kit.cog - moment)", "(kit.mass * kit.cog)", ("driftform-kit/tests/test_ballast.py",)),
    ("trim.py", "agent.mass.cob[0] + volume * x)", "agent.mass.cob[0])", ("driftform-kit/tests/test_ballast.py",)),
    ("ballast.py", "axial / 2 + wanted.mass * thick**2 / 12", "axial / 2", ("driftform-kit/tests/test_ballast.py",)),
    ("ballast.py", "+ float(mass @ (self.x - x) ** 2)", "", ("driftform-kit/tests/test_ballast.py",)),
    ("ballast_seat.py", "0.2 * volume * radius**2", "0.4 * volume * radius**2", ("test_ballast_seat.py",)),
    ("ballast_seat.py", "volume * x**2 + own", "own", ("test_ballast_seat.py",)),
    # Search.
    ("tuning.py", "> min(misses[:-1]) / 2", "> min(misses[:-1])", ("test_tuning.py",)),
    ("tuning.py", "min(max(at, 0.02), 0.98)", "at", ("test_tuning.py",)),
    ("tuned.py", "(height - aim.drop) / root", "height / root", ("test_tuned.py",)),
    ("tuned.py", "elite.root * sqrt(shape.size / elite.shape.size)", "elite.root", ("test_tuned.py",)),
    ("evolution.py", ".undo(): (-moved, size)", ".undo(): (moved, size)", ("test_evolution.py",)),
    # Films.
    ("bench.py", "position + late * self.velocity[-1]", "position", ("test_camera.py",)),
    ("fit.py", "sum(problem.counts) - len(problem.parameters)", "sum(problem.counts)", (FILMS,)),
    ("experiment.py", "Calibration.quantile * deviation", "deviation", (FILMS,)),
    # Robots.
    ("plume.py", "eta * eta * twice + whole - 2 * twice", "eta * eta * twice + whole", ("test_plume.py",)),
    ("plume.py", "(-axis, along)", "(-axis, length - along)", ("test_plume.py",)),
    ("sensors.py", "inlet.radius * np.sqrt(1 - slope**2)", "inlet.radius", ("test_sensors.py",)),
    ("uuv.py", "np.arctan2(z, np.hypot(x, y))", "np.arctan2(-z, np.hypot(x, y))", ("test_fossen.py",)),
    # Networks, and the flow around a body.
    ("routing.py", "snapshot.departure - snapshot.exit * retained", "snapshot.departure", ("test_tracers.py",)),
    ("walkers.py", "fresh * (self.high - self.low)", "(self.high - self.low)", ("test_tracers.py",)),
    ("solve.py", "r * (x * nr - r * nx)", "r * x * nr", ("driftform-panels/tests/test_solve.py",)),
)
