"""An agent as a system of Exudyn: a rigid body with its added mass, weight, buoyancy, and the forces of water and wall."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from driftform.motion import forces
from driftform.types import Agent, FloatArray
from driftform.water import Scenario
from driftform_exudyn.headless import exudyn
from driftform_exudyn.headless import items as typed_items

items: Any = typed_items  # the type hints of exudyn's items do not match their arguments

MAX_TRIES = 5_000
"""Evaluations within one step after which the flight fails.

Halving the longest step down to the shortest takes some 300 evaluations. If forces are unphysically large, Exudyn's
error control can loop for ever, alternating between longer and shorter steps.
"""

NOWHERE = (np.nan,) * 6


@dataclass(frozen=True, eq=False)
class ExudynSystem:
    """A system before it is assembled and solved: Exudyn's ``container`` and ``mbs``, and the forces of water and wall.

    The ``node`` of the rigid body has position and rotation vector, body to world, about the core's centre; the ``body`` has dry
    mass and inertia, and markers of other items refer to it, with lengths in its axes, m. ``tries`` is one number: how often the
    forces were asked for since it was set to 0, which is optional. From :data:`MAX_TRIES` on they are not finite.
    """

    container: Any
    mbs: Any
    node: Any
    body: Any
    water: forces.WaterForces
    tries: list[float]


def exudyn_system(agent: Agent, scenario: Scenario, beside: ExudynSystem | None = None) -> ExudynSystem:
    """Return an agent, released in a scenario, as a system of Exudyn, to which you can add bodies, connectors and sensors.

    It has a rigid body with the dry mass on a Lie-group node; the added mass as a second object on that node, which is what
    calls driftform; and weight and buoyancy as loads at markers of the centres of gravity and buoyancy. Call ``Assemble`` and
    then ``SolveDynamic`` with an explicit integrator, such as DOPRI5. A flight does not end at an outlet by itself. An agent
    ``beside`` another is in the same system; they do not touch each other.
    """
    water = forces.WaterForces.of(agent, scenario)
    container = beside.container if beside else exudyn.SystemContainer()
    mbs = beside.mbs if beside else container.AddSystem()
    node = mbs.AddNode(
        items.NodeRigidBodyRotVecLG(
            referenceCoordinates=[0.0] * 6,
            initialCoordinates=water.coordinates.tolist(),
            initialVelocities=water.rates.tolist(),
        )
    )
    dry = forces.rigid_body_mass(agent.mass)[3:, 3:]
    body = mbs.AddObject(
        items.ObjectRigidBody(
            nodeNumber=node,
            mass=agent.mass.mass,
            centerOfMass=agent.mass.cog.tolist(),
            # About the node.
            inertia=[dry[0, 0], dry[1, 1], dry[2, 2], dry[1, 2], dry[0, 2], dry[0, 1]],
        )
    )
    for place, force in ((agent.mass.cog, -agent.mass.mass * scenario.fluid.gravity), (agent.mass.cob, water.lift)):
        marker = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=place.tolist()))
        mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=[0.0, 0.0, force]))
    tries = [-np.inf]
    _add_water(mbs, node, water, tries)
    return ExudynSystem(container, mbs, node, body, water, tries)


def _add_water(mbs: Any, node: Any, water: forces.WaterForces, tries: list[float]) -> None:
    states = len(water.inner_rates)
    known: tuple[float, ...] | None = None
    added, nothing = np.empty((6, 6)), np.empty(0)

    def inner_rates(_: Any, t: float, __: Any, inner: Any) -> FloatArray:
        nonlocal known
        first = mbs.GetNodeODE2Index(node)
        coordinates = mbs.systemData.GetODE2Coordinates()[first : first + 6]
        rates = mbs.systemData.GetODE2Coordinates_t()[first : first + 6]
        known = water.force(t, coordinates, rates, np.asarray(inner))
        return water.inner_rates

    def force(_: Any, t: float, __: Any, coordinates: Any, rates: Any) -> tuple[float, ...]:
        nonlocal known
        tries[0] += 1
        if tries[0] > MAX_TRIES:
            return NOWHERE
        if known is None:
            return water.force(t, np.asarray(coordinates), np.asarray(rates), nothing)
        # Exudyn asks for the rates of the inner states first, and they are computed together.
        found, known = known, None
        return found

    def mass(_: Any, __: float, ___: Any, coordinates: Any, ____: Any) -> FloatArray:
        water.fill_mass(np.asarray(coordinates), added)
        return added

    mbs.AddObject(
        items.ObjectGenericODE2(
            nodeNumbers=[node], massMatrix=np.eye(6), forceUserFunction=force, massMatrixUserFunction=mass
        )
    )
    if states:
        zeros = [0.0] * states
        inner = mbs.AddNode(
            items.NodeGenericODE1(referenceCoordinates=zeros, initialCoordinates=zeros, numberOfODE1Coordinates=states)
        )
        mbs.AddObject(items.ObjectGenericODE1(nodeNumbers=[inner], rhsUserFunction=inner_rates))
