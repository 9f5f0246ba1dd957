"""Which points of a pipe can agents pass? Fill the map of the pipe, then ask for an agent for any point."""

import driftform as df

study = df.load_study("paper", use={"strategy": "ribs"}, run={"seed": 1, "evaluations": 500})
run = df.evolve(study, "runs/reach", progress=False)

points = [(x, 0.0, z) for x in (2.0, 4.5, 7.0) for z in (-0.6, -0.2, 0.2, 0.6)]
near = 0
for point in points:
    agent = run.pick(*point)
    distance = agent.result["distance"]
    near += distance < 0.05
    print(f"({point[0]:.1f}, {point[2]:+.1f}) m: evaluation {agent.result['evaluation']}, {1000 * distance:.0f} mm")
print(f"{near} of {len(points)} points within 5 cm; the map: {run.path / 'figures' / 'reach.svg'}")
