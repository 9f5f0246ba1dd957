"""Bodies that travel through a network, and the water and walls that they meet there."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import driftform
from driftform.errors import InputError
from driftform.types import Agent, Body, Coefficients, Core

if TYPE_CHECKING:
    from driftform.interfaces import Simulator
    from driftform.scenario import Scenario

SCENARIO = Path(__file__).with_name("network.toml")
"""The environment of flights in a network, if no other is named."""

_SPHERE = "sphere:"


@dataclass(frozen=True, eq=False)
class Traveller:
    """A body that travels through a network.

    Attributes
    ----------
    name
        its name.
    agent
        the body, with its masses and coefficients.
    scenario
        fluid, wall and flow profile; pipe, speed and release are those of each flight.
    simulator
        flies it.
    """

    name: str
    agent: Agent
    scenario: "Scenario"
    simulator: "Simulator[Any]"

    def hash(self) -> str:
        """Return a hash of all that decides its flights: body, environment, simulator, and the code of driftform."""
        scenario = self.scenario.model_dump(include={"fluid", "flow", "contact"})
        simulator = (self.simulator.name, self.simulator.options.model_dump())
        # The mass properties and coefficients hold what builder and hydrodynamics made of the genome.
        parts = [_plain(self.agent.body), _plain(self.agent.mass), _plain(self.agent.coefficients)]
        content = json.dumps([parts, scenario, simulator, hash_code()], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()

    def is_mixed(self, speed: float) -> bool:
        """Return whether the water mixes the body over the bore like itself, at a mean speed (m/s).

        That is so for a Rouse number w / (kappa u*) below about a quarter, with its terminal speed w, here that of a
        sphere of its diameter, and a friction velocity u* of a twentieth of the mean speed.
        """
        fluid, mass = self.scenario.fluid, self.agent.mass
        area = np.pi / 4 * self.agent.body.max_diameter**2
        terminal = np.sqrt(abs(mass.net_buoyancy(fluid)) / (0.25 * fluid.density * area))
        return bool(terminal < 0.1 * speed / 20)


def open_traveller(text: str, scenario: str | None = None, settings: Sequence[str] = ()) -> Traveller:
    """Open an agent to travel through a network.

    Parameters
    ----------
    text
        AGENT as every command takes it, or ``sphere:5mm`` for a neutral sphere of that diameter.
    scenario
        scenario or study whose environment to use; ``None`` for that of water mains.
    settings
        ``key=value`` of the study, as ``--set`` takes them.

    Raises
    ------
    InputError
        if there is no such agent.
    """
    from driftform.agents.opening import open_agent

    environment = scenario or str(SCENARIO)
    if not text.startswith(_SPHERE):
        design = open_agent(text, environment, settings)
        return Traveller(design.name, design.agent, design.scenario, design.pipeline.simulator)
    from driftform.study import load_study

    pipeline = load_study(environment, settings, run={"seed": 0}).make_pipeline()
    number = text.removeprefix(_SPHERE).removesuffix("mm")
    try:
        diameter = float(number) / 1000
    except ValueError:
        diameter = 0.0
    if not 0.0005 <= diameter <= 2:
        raise InputError(
            f"AGENT '{text}': a sphere is named by its diameter from 0.5 to 2000 mm, such as sphere:5mm"
        )
    agent = make_sphere(diameter, pipeline.scenario)
    return Traveller(text.replace(":", "-"), agent, pipeline.scenario, pipeline.simulator)


def make_sphere(diameter: float, scenario: "Scenario") -> Agent:
    """Return a neutral homogeneous sphere, whose added mass is half of that of the water it displaces."""
    from driftform.geometry import mass_properties
    from driftform.hydrodynamics.drag import estimate_drag

    radius, fluid = diameter / 2, scenario.fluid
    angle = np.linspace(0, np.pi, 65)
    outer = np.column_stack([-radius * np.cos(angle), radius * np.sin(angle)])
    outer[[0, -1], 1] = 0.0
    body = Body(outer, np.zeros((0, 2)), np.array([-radius, radius]), Core(0.0, 0.0), radius, fluid.density)
    mass = mass_properties(body)
    added = np.diag([mass.mass / 2] * 3 + [0.0] * 3)
    return Agent(body, mass, Coefficients(added, drag=estimate_drag(body, fluid.viscosity, 0.0)))


@cache
def hash_code() -> str:
    """Return a hash of the source files that decide how a body flies: results of other versions are not used."""
    core, plugin = Path(driftform.__file__).parent, Path(__file__).parent
    folders = [core / name for name in ("dynamics", "hydrodynamics", "geometry", "trajectory", "scenario")]
    files = [file for folder in folders for file in sorted(folder.glob("*.py"))]
    files += [plugin / name for name in ("bore.py", "flights.py")]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def _plain(value: Any) -> Any:
    """Return a dataclass of arrays as lists and numbers."""
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
