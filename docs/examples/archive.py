"""Fill an archive of masses and lengths by CMA-ME over B-splines, and draw it in the report of the run."""

import csv

import driftform as df

study = df.load_study(
    "pipe-inspection",
    [
        "strategy.emitter=cma-me",
        "strategy.archive=grid",
        "strategy.cells=100",
        "strategy.measures={mass=[0.05, 0.25], length=[0.05, 0.25]}",
    ],
    use={"grammar": "bspline", "strategy": "ribs"},
    targets=["TP5"],
    run={"seed": 1, "evaluations": 500, "robust": 0},
)
run = df.evolve(study, "runs/archive", progress=False)
with (run.path / "strategy" / "archive.csv").open() as file:
    rows = list(csv.DictReader(file))
best = max(rows, key=lambda row: float(row["fitness"]))
print(
    f"{len(rows)} of 100 cells are filled; the best has {float(best['mass']):.3f} kg and {float(best['length']):.3f} m"
)
print(run.report())
