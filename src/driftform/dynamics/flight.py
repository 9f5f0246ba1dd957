"""Raw samples of an integrator -> a trajectory that ends where it should, and says why."""

import numpy as np

from driftform.dynamics.compiled import compiled
from driftform.dynamics.path import hermite_coefficients
from driftform.dynamics.rotations import matrix_from_quaternion, quaternion_from_rotation_vector
from driftform.types import End, FloatArray, Trajectory

SAMPLE = 13
"""Numbers in a raw sample: time, then pose and speed as :func:`driftform.dynamics.equations.accelerations` has them."""


@compiled
def record(sample: FloatArray, t: float, pose: FloatArray, speed: FloatArray, pipe: FloatArray) -> bool:
    """Fill one raw sample (13,), and return whether the flight goes on: it is finite and inside the pipe."""
    sample[0] = t
    total = 0.0
    for i in range(6):
        sample[1 + i] = pose[i]
        sample[7 + i] = speed[i]
        total += pose[i] + speed[i]
    return np.isfinite(total) and not has_left(sample[1:4], pipe)


@compiled
def has_left(position: FloatArray, pipe: FloatArray) -> bool:
    """True where the body's origin is past the outlet, or more than a radius upstream of the inlet."""
    if pipe.shape[0] == 0:
        return False
    first, last = pipe[0], pipe[-1]
    inflow = 0.0
    outflow = 0.0
    square = 0.0
    for i in range(3):
        inflow += (first[3 + i] - first[i]) * (position[i] - first[i])
        square += (first[3 + i] - first[i]) ** 2
        outflow += (last[3 + i] - last[i]) * (position[i] - last[3 + i])
    return outflow >= 0.0 or inflow < -first[6] * np.sqrt(square)


def finished_flight(samples: FloatArray, pipe: FloatArray, horizon: float, step_limit: int) -> Trajectory:
    """Return the trajectory of raw samples (k, 13): all that is finite of it, cut exactly at the outlet.

    A flight that stopped before the horizon for no other reason has not converged, and ends as non-finite.
    """
    finite = np.isfinite(samples).all(axis=1)
    sound = len(samples) if finite.all() else int(np.argmin(finite))
    later = np.concatenate([[True], np.diff(samples[:, 0]) > 0])
    rows = samples[:sound][later[:sound]]
    t, position = rows[:, 0], rows[:, 1:4]
    quaternion = quaternion_from_rotation_vector(rows[:, 4:7])
    R = matrix_from_quaternion(quaternion)
    velocity = np.concatenate([np.einsum("kji,kj->ki", R, rows[:, 7:10]), rows[:, 10:]], axis=1)
    flown = (t, position, quaternion, velocity)
    if sound < len(samples):
        return Trajectory(*flown, end=End.NON_FINITE)
    if has_left(position[-1], pipe):
        outlet = _cut_at_outlet(*flown, pipe)
        return outlet if outlet is not None else Trajectory(*flown, end=End.INLET)
    if t[-1] >= horizon * (1 - 1e-9):
        return Trajectory(*flown, end=End.HORIZON)
    return Trajectory(*flown, end=End.STEP_LIMIT if len(samples) > step_limit else End.NON_FINITE)


def _cut_at_outlet(
    t: FloatArray, position: FloatArray, quaternion: FloatArray, velocity: FloatArray, pipe: FloatArray
) -> Trajectory | None:
    axis = pipe[-1, 3:6] - pipe[-1, :3]
    past = (position - pipe[-1, 3:6]) @ axis
    if past[-1] < 0 or len(t) < 2:
        return None
    R = matrix_from_quaternion(quaternion[-2:])
    world = np.einsum("kij,kj->ki", R, velocity[-2:, :3])
    curve = hermite_coefficients(t[-2:], position[-2:], world)[0]
    along = curve @ axis
    along[0] -= pipe[-1, 3:6] @ axis
    roots = np.roots(along[::-1])
    inside = roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 0) & (roots.real <= 1 + 1e-9)].real
    u = float(inside.min()) if inside.size else 1.0
    # Over one step of the integrator attitude and velocity change so little that a straight line will do.
    turned = (1 - u) * quaternion[-2] + u * quaternion[-1] * np.sign(quaternion[-2] @ quaternion[-1] or 1.0)
    return Trajectory(
        np.append(t[:-1], t[-2] + u * (t[-1] - t[-2])),
        np.vstack([position[:-1], u ** np.arange(4) @ curve]),
        np.vstack([quaternion[:-1], turned / np.linalg.norm(turned)]),
        np.vstack([velocity[:-1], (1 - u) * velocity[-2] + u * velocity[-1]]),
        End.OUTLET,
    )
