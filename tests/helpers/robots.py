"""Motion and files of agents that tests of models for other simulators share."""

import subprocess
import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace

import numpy as np

from driftform.motion.forces.equations import accelerations
from driftform.motion.forces.model import flight_model
from driftform.util.rotations import rotation_from_quaternion
from driftform.water import Fluid, Scenario
from driftform.water.flow import UniformFlow


def check_sdf(program, path):
    """Check an SDF file by Ignition's program; bytes of the output that are not UTF-8 are replaced."""
    command = [program, "sdf", "-k", path]
    return subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", timeout=600, check=False)


@dataclass(frozen=True)
class State:
    """A rigid body somewhere: rotation R (body to world), velocity of the COG (world), angular velocity (body)."""

    R: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray


def random_states(count):
    rng = np.random.default_rng(17)
    found = []
    for _ in range(count):
        R = np.array(rotation_from_quaternion(*rng.normal(size=4)))
        found.append(State(R, rng.uniform(-1.5, 1.5, 3), rng.uniform(-8, 8, 3)))
    return found


def our_accelerations(job, state):
    """Acceleration of the COG (in body axes) and of rotation, (6,), by driftform, clear of any wall."""
    model = flight_model(job.agent, job.scenario)
    R, omega, cog = state.R, state.omega, job.agent.mass.cog
    rows = tuple(tuple(row) for row in R.tolist())
    position = np.array([4.0, 0.0, 0.0])
    velocity = state.velocity - R @ np.cross(omega, cog)
    a, alpha = accelerations(0.0, tuple(position), rows, tuple(velocity.tolist()), tuple(omega.tolist()), model)
    at_cog = R.T @ np.array(a) + np.cross(alpha, cog) + np.cross(omega, np.cross(omega, cog))
    return np.concatenate((at_cog, alpha))


def inertia_of(get):
    """The inertia of an element or of attributes: ixx, ixy, ..., (3, 3)."""
    entries = {(i, j): float(get(f"i{'xyz'[min(i, j)]}{'xyz'[max(i, j)]}")) for i in range(3) for j in range(3)}
    return np.array([[entries[i, j] for j in range(3)] for i in range(3)])


def still(job):
    """The same agent in open water that is at rest."""
    release = job.scenario.release.model_copy(update={"velocity": "rest"})
    return replace(job, scenario=Scenario(flow=UniformFlow(speed=0.0), release=release, fluid=Fluid()))


def model_of(path, name):
    """The agent's model in an SDF file."""
    found = ET.parse(path).getroot().find(f".//model[@name='{name}']")
    assert found is not None
    return found
