"""Trade the 90 % miss against the mass of a print by NSGA-II over B-splines, and draw the front in the report of the run."""

import csv

import driftform as df

study = df.load_study(
    "pipe-inspection",
    [
        "strategy.algorithm=nsga2",
        "strategy.objectives=['-fitness_90', 'print_mass']",
        "strategy.population=25",
        "robustness.survey=10",
    ],
    use={"grammar": "bspline", "strategy": "pymoo"},
    targets=["TP5"],
    run={"seed": 1, "evaluations": 300, "robust": 20},
)
run = df.evolve(study, "runs/front", progress=False)
with (run.path / "strategy" / "front.csv").open() as file:
    rows = sorted(csv.DictReader(file), key=lambda row: float(row["print_mass"]))
for row in rows:
    grams, miss = 1000 * float(row["print_mass"]), 100 - float(row["fitness_90"])
    print(f"{grams:5.1f} g printed: nine of ten flights within {miss:.2f} % of the farthest distance")
print(run.report())
