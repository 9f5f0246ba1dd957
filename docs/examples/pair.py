"""Two agents in one system of Exudyn, tied by a spring: one with ballast, and one that it drags down."""

import exudyn
from exudyn.itemInterface import MarkerBodyPosition, ObjectConnectorSpringDamper

import driftform as df
from driftform_exudyn.system import exudyn_system

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"

exudyn.config.printToConsole = False
calm = ("release.velocity=rest", "flow.speed=0.001", "pipe.segments=[]", "targets={}", "hydrodynamics.drag=strips")
upper = df.open_agent(WORD, "release.position=[0, 0, 0.15]", *calm, scenario="paper")
lower = df.open_agent(WORD, "release.position=[0, 0, -0.15]", "release.ballast=0.02", *calm, scenario="paper")
first = exudyn_system(upper.agent, upper.scenario)
second = exudyn_system(lower.agent, lower.scenario, beside=first)
mbs = first.mbs

ends = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=system.body)) for system in (first, second)]
tie = mbs.AddObject(ObjectConnectorSpringDamper(markerNumbers=ends, referenceLength=0.3, stiffness=20.0, damping=2.0))

mbs.Assemble()
settings = exudyn.SimulationSettings()
settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = 6.0, 6000
settings.solution.file.write = False
mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.DOPRI5)

force = mbs.GetObjectOutput(tie, exudyn.OutputVariableType.Force)
half = (upper.net_buoyancy - lower.net_buoyancy) / 2
print(f"the tie pulls with {abs(force[2]):.3f} N; with equal drag it would be {half:.3f} N")
