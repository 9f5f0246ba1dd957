"""The force law of a contact: a spring set by the effective mass, and a damper set by the restitution.

A surface that lies at the depth d in the wall is pressed by a spring with twice the energy::

    e = m omega^2 d^2 (1 + (d / STIFF_DEPTH)^4 / 3)

up to DEEPEST; beyond it the force falls as 1 / d^2. m(s) = 1 / (J M^-1 J^T) is the mass that a push there along the wall's
normal moves, added mass included; s is the component of the body's axis along the normal. Several springs together have the energy U = sqrt(sum of e^2) / 2, and
forces and torques are its derivatives: springs return the energy that they take, and many rims that touch at once are
not many times stiffer than one.

The damper multiplies the force of the springs by a factor that depends on a ratio of speeds only: of the approach w to
q = sqrt(2 U / m). In the variables q and w the collisions of all bodies, springs and speeds are one (Antypov and Elliott
2011, EPL 94, 50004, use this for Hertz's law), so that the restitution e depends on none of them. It is
e = e_dry exp(-35 / St) with St = m v / (6 pi mu R^2): the fit of Legendre, Zenit, Daniel and Guiraud
(2006, A note on the modelling of the bouncing of spherical drops or solid spheres on a wall in viscous fluid) to measured
rebounds; their Stokes number includes the added mass.
"""

import math

import numpy as np

from driftform.motion.forces.bore import smoothed_sine
from driftform.motion.forces.fields import LAW, Records
from driftform.types import FloatArray
from driftform.util.compiled import compiled

STIFF_DEPTH = 2e-4
"""Depth (m) beyond which a spring stiffens: an impact at 3 m/s is not much deeper than one at 1 m/s."""

DEEPEST = 1e-3
"""Depth (m) beyond which a spring weakens: impacts below 4 m/s stay above it, but trial steps of an integrator go deeper by far,
and must remain finite."""

# Powers in the source, not in kernels: numba compiles a function for them, which can raise an exception.
_STIFFENING = STIFF_DEPTH**-4
_STIFFEST = (DEEPEST / STIFF_DEPTH) ** 4

ONSET = 0.25
"""The damper sets in where the spring's speed q reaches this share of the speed of approach."""

MAX_LOSS = 2.3
"""Largest -ln e: a damper that leaves less than a tenth of the speed would be much stiffer than the spring."""

LUBRICATION = 35.0
"""-St ln(e / e_dry), Legendre et al. (2006)."""


def contact_law(inverse: FloatArray, frequency: float, restitution: float, viscosity: float, radius: float) -> Records:
    """Return the law of the contacts of a body: one record of :data:`driftform.motion.forces.fields.LAW`, (1,).

    Args:
        inverse: of the total mass matrix about the body's origin, (6, 6).
        frequency: omega, rad/s.
        restitution: e_dry.
        viscosity: dynamic viscosity of the water, Pa s.
        radius: R of the Stokes number, m.
    """
    along, across = inverse[0, 0], 0.5 * (inverse[1, 1] + inverse[2, 2])
    law = np.zeros(1, LAW)
    law["axial"], law["lateral"] = along, across
    law["turning"] = 0.5 * (inverse[4, 4] + inverse[5, 5])
    law["coupling"] = 0.5 * (inverse[1, 5] - inverse[2, 4])
    law["greatest_mass"] = 1.0 / min(along, across) if min(along, across) > 0.0 else math.inf
    law["frequency"], law["dry_loss"] = frequency, -math.log(restitution)
    law["wet_loss"] = LUBRICATION * 6.0 * math.pi * viscosity * radius**2 * math.sqrt(restitution)
    return law


@compiled
def spring(s: float, x: float, r: float, depth: float, law: np.record) -> tuple[float, float, float, float]:
    """Return mass m (kg), twice the energy e (J), half of de/d(depth) (N), and half of de/d(angle) (N m) of a spring.

    The angle is that from the normal's plane to the axis: s = sin(angle). The rim (x, r), m, touches; a dome about x has
    no r. The last two are 0 if the mass is not finite.
    """
    c, arm = math.sqrt(max(0.0, 1.0 - s * s)), r / smoothed_sine(s)
    along = x - arm * s
    lever, change = along * c, -along * s - arm
    mobility = s * s * law.axial + c * c * law.lateral + lever * lever * law.turning + 2.0 * c * lever * law.coupling
    if not mobility > 0.0:
        return math.inf, 0.0, 0.0, 0.0
    slope = s * c * (law.axial - law.lateral) + lever * change * law.turning + (c * change - s * lever) * law.coupling
    mass = 1.0 / mobility
    stiffness, square = mass * law.frequency * law.frequency, depth * depth
    if depth < DEEPEST:
        stiffer = square * square * _STIFFENING
        energy, force = square * (1.0 + stiffer / 3.0), depth * (1.0 + stiffer)
    else:
        ratio, square, stiffer = DEEPEST / depth, DEEPEST * DEEPEST, _STIFFEST
        energy = square * (1.0 + stiffer / 3.0 + 2.0 * (1.0 + stiffer) * (1.0 - ratio))
        force = DEEPEST * (1.0 + stiffer) * ratio * ratio
    energy *= stiffness
    return mass, energy, stiffness * force, -energy * mass * slope


@compiled
def common_mass(pressed: float, power: float, law: np.record) -> float:
    """Return the effective mass (kg) of several springs that press together.

    ``pressed`` is the sum of their forces, and ``power`` the product of the acceleration that they give to the body with their
    wrench. Springs at opposite walls press, but do not accelerate: the mass is at most that of a central push.
    """
    most = float(law.greatest_mass)
    return min(most, pressed * pressed / power) if power > 0.0 else most


@compiled
def damper(square: float, speed: float, mass: float, law: np.record) -> float:
    """Return the factor of a spring's force, at least 0; ``square`` is q^2 = 2 U / m (m2/s2), ``speed`` the approach, m/s.

    The loss -ln e of a collision depends on its speed v, of which the remainder sqrt(q^2 + w^2) is known. The wet loss is
    therefore written for the remainder: with y = 35 sqrt(e_dry) / St(remainder), the rate
    y (1 + 0.33 y) / (1 + 0.7 y + 0.02 y^2) adds up to 35 / St(v) over a collision, within .02 in e for St > 20 and e_dry > 0.5.
    """
    wet = law.wet_loss / (mass * math.sqrt(square + speed * speed))
    loss = min(MAX_LOSS, law.dry_loss + wet * (1.0 + 0.33 * wet) / (1.0 + wet * (0.7 + 0.02 * wet)))
    # A fit to the loss of the collision that this factor makes, within .005 in e: damping ratio by loss.
    ratio = loss * (0.415 + 0.052 * loss * loss)
    return max(0.0, 1.0 + 2.0 * float(ratio) * speed / math.sqrt(square + ONSET * ONSET * speed * speed))
