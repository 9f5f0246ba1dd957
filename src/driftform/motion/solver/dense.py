"""Dense output: the motion of a body within a step, from the state and its rate at both ends.

Quintic Hermite polynomials of the position and of the body's axis match values, velocities and accelerations at both
ends; the error is h^6 / 46080 of a sixth derivative. They need no stage of the method, so that all methods share them
(Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.6).
"""

from typing import TypeAlias

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.rotations import rotation_from_quaternion
from driftform.util.small_vectors import Vector, add, cross, norm, scale, subtract, to_world

Quintic: TypeAlias = tuple[Vector, Vector, Vector, Vector, Vector, Vector]
"""Coefficients of a polynomial in the share u of a step, the lowest power first."""

Motion: TypeAlias = tuple[Quintic, Quintic]
"""Position (m) and axis of a body within a step, world frame."""

Movement: TypeAlias = tuple[Vector, Vector, Vector]
"""A vector, its rate, and the rate of that."""


@compiled
def quintic_between(start: Movement, end: Movement, h: float) -> Quintic:
    """Return the polynomial with these values, velocities and accelerations at the ends of a step of ``h`` s."""
    (p, v, a), (q, w, b) = start, end
    v, w, a, b = scale(h, v), scale(h, w), scale(0.5 * h * h, a), scale(0.5 * h * h, b)
    gap, bend = subtract(q, add(p, add(v, a))), subtract(b, a)
    turn = subtract(w, add(v, scale(2.0, a)))
    return (
        p,
        v,
        a,
        add(subtract(scale(10.0, gap), scale(4.0, turn)), bend),
        subtract(subtract(scale(7.0, turn), scale(15.0, gap)), scale(2.0, bend)),
        add(subtract(scale(6.0, gap), scale(3.0, turn)), bend),
    )


@compiled
def quintic_point(quintic: Quintic, u: float) -> Vector:
    """Return the value of a polynomial at the share ``u`` of the step."""
    a, b, c, d, e, f = quintic
    return add(a, scale(u, add(b, scale(u, add(c, scale(u, add(d, scale(u, add(e, scale(u, f))))))))))


@compiled
def move_of_origin(y: FloatArray, rate: FloatArray) -> Movement:
    """Return position (m), velocity (m/s) and acceleration (m/s2) of a state with this rate."""
    return (y[0], y[1], y[2]), (y[7], y[8], y[9]), (rate[7], rate[8], rate[9])


@compiled
def move_of_axis(y: FloatArray, rate: FloatArray, spin: float) -> Movement:
    """Return the body's axis in the world frame, its rate (1/s), and the rate of that (1/s2).

    The frame of the state spins about the axis at ``spin`` (rad/s). With the axis e along x, e' = w x e, whose components
    (0, r, -q) change in a frame that turns.
    """
    R = rotation_from_quaternion(y[3], y[4], y[5], y[6])
    turn = (0.0, y[12], -y[11])
    change = add((0.0, rate[12], -rate[11]), cross((spin, y[11], y[12]), turn))
    return (R[0][0], R[1][0], R[2][0]), to_world(R, turn), to_world(R, change)


@compiled
def move_between(
    h: float, y: FloatArray, rate: FloatArray, new: FloatArray, new_rate: FloatArray, spins: tuple[float, float]
) -> Motion:
    """Return the motion within a step of ``h`` s from the state ``y`` to ``new``; ``spins`` of both frames in rad/s."""
    origin = quintic_between(move_of_origin(y, rate), move_of_origin(new, new_rate), h)
    axis = quintic_between(move_of_axis(y, rate, spins[0]), move_of_axis(new, new_rate, spins[1]), h)
    return origin, axis


@compiled
def pose_within(motion: Motion, u: float) -> tuple[Vector, Vector]:
    """Return position (m) and axis, a unit vector, at the share ``u`` of a step."""
    axis = quintic_point(motion[1], u)
    return quintic_point(motion[0], u), scale(1.0 / norm(axis), axis)
