"""An agent on a tether, by Exudyn: a spring from the pipe's axis holds it in the current, and carries its net weight."""

import exudyn
import numpy as np
from exudyn.itemInterface import MarkerBodyPosition, ObjectConnectorSpringDamper, ObjectGround

import driftform as df
from driftform_exudyn.system import exudyn_system

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
ANCHOR, LENGTH, STIFFNESS = np.array([4.0, 0.0, 0.0]), 0.3, 20.0

exudyn.config.printToConsole = False
agent = df.open_agent(WORD, "release.position=[4, 0, -0.3]", "release.velocity=rest", "flow.speed=0.2")
system = exudyn_system(agent.agent, agent.scenario)
mbs = system.mbs

nose = [float(agent.agent.body.outer[-1, 0]), 0.0, 0.0]
ground = mbs.AddObject(ObjectGround(referencePosition=ANCHOR))
ends = [
    mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground)),
    mbs.AddMarker(MarkerBodyPosition(bodyNumber=system.body, localPosition=nose)),
]
tether = mbs.AddObject(
    ObjectConnectorSpringDamper(markerNumbers=ends, referenceLength=LENGTH, stiffness=STIFFNESS, damping=1.0)
)

mbs.Assemble()
settings = exudyn.SimulationSettings()
settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = 20.0, 2000
settings.solution.file.write = False
mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.DOPRI5)

force = mbs.GetObjectOutput(tether, exudyn.OutputVariableType.Force)
print(f"the tether lifts {abs(force[2]):.4f} N of {abs(agent.net_buoyancy):.4f} N of net weight")
