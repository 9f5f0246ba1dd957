"""An agent, with the pipe and the water around it, in the files of other simulators.

In all of them the one link of the agent has its origin at the centre of gravity and its axes along the body's:
inertia, added mass and damping then refer to one point, about which programs disagree where it is another.
"""
