"""What a simulator with an integrator of its own needs: the rate of a state, and whether the agent has left the pipe."""

import numpy as np

from driftform.motion.flight import has_left_pipe
from driftform.motion.model import FlightModel
from driftform.motion.rates import fill_rate_in_space
from driftform.types import FloatArray


def compute_rate(t: float, state: FloatArray, model: FlightModel) -> FloatArray:
    """Return the time derivative of a state, (13,), or (17,) in gusts.

    Parameters
    ----------
    t
        time since the release, s.
    state
        position (m), quaternion, velocity (m/s) and angular velocity (rad/s, body axes), and in gusts their four numbers, as
        :func:`driftform.motion.release_state` returns it; all but the angular velocity in the world frame.
    model
        an agent in a scenario, from :func:`driftform.motion.flight_model`.
    """
    out = np.empty(len(state))
    fill_rate_in_space(t, state, model, out)
    return out


def has_left(state: FloatArray, model: FlightModel) -> bool:
    """Return whether the agent is past an outlet of the pipe, or more than a radius upstream of its inlet."""
    x, y, z = state[:3].tolist()
    return bool(has_left_pipe((x, y, z), model.pipe, model.fittings))
