"""A flight that advances step by step in water that another program may change, for co-simulation."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from driftform.errors import InputError, WorkFailedError
from driftform.interfaces import Simulator
from driftform.pipeline import require_success
from driftform.types import Agent, End, FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Scenario
from driftform.water.flow import UniformFlow

MAX_DURATION, MAX_SPEED = 1e5, 100.0
"""Longest step, s, and fastest current, m/s."""


class LiveFlight:
    """An agent in flight.

    Attributes:
        name: of the agent.
        agent: what flies.
        scenario: the water as it is now.
        latest: the trajectory of the last step, with times since the release; before the first step, the release
            alone.
        end: why the flight has ended: at an outlet or the inlet; ``None`` while it continues.
    """

    def __init__(self, name: str, agent: Agent, scenario: Scenario, simulator: Simulator[Any]) -> None:
        from driftform.motion import forces, path

        if scenario.has_gusts:
            raise InputError(f"{name}: gusts outlast a step; set gusts.strength = 0 to fly step by step")
        if (misfit := scenario.find_misfit(agent.body)) is not None:
            raise WorkFailedError(f"{name}: {misfit}")
        self.name, self.agent, self.scenario, self._simulator = name, agent, scenario, simulator
        self.end: End | None = None
        model = forces.flight_model(agent, scenario)
        release = np.array([[0.0, *forces.release_state(model, scenario)]])
        self.latest = path.finish_trajectory(release, model, 0.0, 1)

    @property
    def time(self) -> float:
        """Since the release, s."""
        return float(self.latest.t[-1])

    @property
    def position(self) -> FloatArray:
        """Of the core's centre, world frame, m, (3,)."""
        return np.asarray(self.latest.position[-1])

    @property
    def quaternion(self) -> FloatArray:
        """The attitude, from body to world, (4,)."""
        return np.asarray(self.latest.quaternion[-1])

    @property
    def velocity(self) -> FloatArray:
        """Over ground, in body axes: surge, sway, heave (m/s), roll, pitch, yaw (rad/s), (6,)."""
        return np.asarray(self.latest.velocity[-1])

    def step(self, duration: float, current: Sequence[float] | None = None) -> Trajectory:
        """Fly on for ``duration`` (s), and return the trajectory of this step; it is shorter if the agent leaves the pipe.

        Args:
            current: velocity of the water (m/s, world frame, three numbers), everywhere in place of the scenario's
                from now on, in later steps too; ``None`` to leave the water as it is. Its pressure gradient and the
                added mass move the agent at once, as in water that accelerates for a moment.

        Raises:
            InputError: if an argument is not sound, or the flight has ended.
            WorkFailedError: if the step fails; the flight remains where it was.
        """
        if self.end is not None:
            raise InputError(f"{self.name}: the flight has ended after {self.time:.3g} s: {self.end}")
        if not 0 < duration <= MAX_DURATION:
            raise InputError(f"duration = {duration:g}: a step takes more than 0 and at most {MAX_DURATION:g} s")
        scenario, flown = self.scenario, self.latest
        if current is not None:
            scenario, flown = self._meet_current(np.asarray(current, dtype=np.float64))
        found = self._simulator.step(self.agent, scenario, flown, duration)
        require_success(found, self.name)
        self.scenario, self.latest = scenario, found
        self.end = None if found.end is End.HORIZON else found.end
        return found

    def _meet_current(self, current: FloatArray) -> tuple[Scenario, Trajectory]:
        from driftform.motion.path.continuation import change_current
        from driftform.water import field

        if current.shape != (3,) or not (np.abs(current) <= MAX_SPEED).all():
            raise InputError(
                f"current = {current.tolist()}: expected three numbers from -{MAX_SPEED:g} to {MAX_SPEED:g}, m/s"
            )
        cob = self.position + rotations.matrix_from_quaternion(self.quaternion) @ self.agent.mass.cob
        change = current - field.water_velocity(cob, self.time, self.scenario)[0]
        x, y, z = current.tolist()
        scenario = self.scenario.model_copy(update={"flow": UniformFlow(speed=0.0, added=(x, y, z))})
        if not change.any():
            return scenario, self.latest
        return scenario, change_current(self.latest, self.agent, scenario, change)
