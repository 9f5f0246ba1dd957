"""Trade fitness against the mass of a print by NSGA-II over B-splines, and draw the front in the report of the run."""

import csv

import driftform as df

study = df.load_study(
    "pipe-inspection",
    ["strategy.algorithm=nsga2", "strategy.objectives=['fitness', 'print_mass']", "strategy.population=25"],
    use={"grammar": "bspline", "strategy": "pymoo"},
    targets=["TP5"],
    run={"seed": 1, "evaluations": 500, "robust": 0},
)
run = df.evolve(study, "runs/front", progress=False)
with (run.path / "strategy" / "front.csv").open() as file:
    rows = sorted(csv.DictReader(file), key=lambda row: float(row["print_mass"]))
for row in rows:
    print(f"{1000 * float(row['print_mass']):5.1f} g printed: fitness {float(row['fitness']):.2f} %")
print(run.report())
