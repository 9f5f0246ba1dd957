"""Evolve agents for two targets, and print how far 9 of 10 flights of each will miss if the print is weighed in water."""

import driftform as df

study = df.load_study("pipe-inspection", targets=["TP1", "TP8"], run={"seed": 1, "evaluations": 150})
run = df.evolve(study, "runs/two-targets", progress=False)

for target, best in run.items():
    undisturbed = best.simulate().closest[target]
    promised = best.result["robust"]["weighed"]["p90"]
    print(
        f"{target}: {1000 * best.mass.mass:.1f} g, {1000 * best.length:.0f} mm long, "
        f"misses by {1000 * undisturbed:.0f} mm undisturbed, 9 of 10 flights by less than {1000 * promised:.0f} mm"
    )
print(run.report())
