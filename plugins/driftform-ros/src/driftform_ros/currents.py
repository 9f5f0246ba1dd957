"""Messages of a current -> its velocity in the frame of the flight."""

import sys
from typing import Any

import numpy as np

from driftform.util import rotations

TOPIC = "hydrodynamics/current_velocity"
"""Topic of the velocity of the water, as the UUV simulator has it: ``geometry_msgs/TwistStamped``."""

Current = tuple[float, float, float]


def turn_current(message: Any, world: str, buffer: Any, latest: Any) -> Current | None:
    """Return the velocity of a ``geometry_msgs/TwistStamped`` in the frame ``world``, m/s.

    ``buffer`` is that of ``tf2_ros``, and ``latest`` its time for the latest transform. A frame that it does not know gives a
    warning, and ``None``; no frame is that of the flight.
    """
    from tf2_ros import TransformException

    frame, linear = message.header.frame_id.lstrip("/"), message.twist.linear
    velocity = np.array([linear.x, linear.y, linear.z], dtype=np.float64)
    if frame not in ("", world):
        try:
            turn = buffer.lookup_transform(world, frame, latest).transform.rotation
        except TransformException:
            print(
                f"warning: a current in the frame '{frame}' is refused: tf does not know it in '{world}'",
                file=sys.stderr,
            )
            return None
        velocity = rotations.matrix_from_quaternion(np.array([turn.w, turn.x, turn.y, turn.z])) @ velocity
    x, y, z = velocity.tolist()
    return x, y, z
