"""Models of an agent, the pipe and the water for other simulators.

In all of them the agent is one link with its origin at the centre of gravity and its axes along those of the body.
Inertia, added mass and damping then refer to the same point. Programs disagree about how to read matrices that refer to
any other point.
"""
