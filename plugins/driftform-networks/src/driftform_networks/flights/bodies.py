"""Bodies that travel through a network, and the water and walls that they meet there."""

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import driftform
from driftform.agent import mass_properties
from driftform.errors import InputError
from driftform.types import Agent
from driftform_networks.cache import hash_content

if TYPE_CHECKING:
    from driftform import Design
    from driftform.interfaces import Simulator
    from driftform.water import Scenario

SCENARIO = Path(__file__).with_name("network.toml")
"""The environment of flights in a network, if no other is named."""

FLOWN_BY = ("agent", "water", "motion")
"""Packages of driftform whose code decides how a body flies."""

LEAD_DENSITY = 11_340.0
"""Density of the heaviest core, kg/m3."""

SCALE = 0.00005
"""Step of the scale that weighs a body, and of its ballast, kg, as in disturbed flights."""

ALIKE = 0.05
"""Deviation of the net buoyancy, relative to it, up to which bodies travel alike."""

_SPHERE = "sphere:"


@dataclass(frozen=True, eq=False)
class Traveller:
    """A body that travels through a network.

    Attributes:
        agent: the body, with its masses and coefficients.
        scenario: fluid, wall and flow profile; pipe, speed and release are those of each flight.
        simulator: flies it.
        design: what its files are made of; ``None`` for a sphere.
        error: standard deviation of its net buoyancy, N, such as ``replace(traveller, error=0.0)``; ``None`` for what :func:`buoyancy_error` says.
    """

    name: str
    agent: Agent
    scenario: "Scenario"
    simulator: "Simulator[Any]"
    design: "Design | None" = None
    error: float | None = None

    @cached_property
    def drawn(self) -> tuple["Traveller", ...]:
        """Bodies that stand for its net buoyancy as it is made, as many of each: a standard deviation lighter, and heavier.

        So the formula of Gauss and Hermite with two points draws from a normal distribution (Abramowitz and Stegun 25.4.46). Its third
        point would be the design itself, which water may mix, and of which hardly a body is made.
        """
        fluid, body = self.scenario.fluid, self.agent.body
        error = buoyancy_error(self.agent, self.scenario) if self.error is None else self.error
        if error <= ALIKE * abs(self.net_buoyancy):
            return (self,)
        # A light body is weighed on a finer scale.
        extra = min(error / fluid.gravity, self.agent.mass.mass / 2)
        made = [replace(body, core=replace(body.core, mass=body.core.mass + sign * extra)) for sign in (-1, 1)]
        agents = (replace(self.agent, body=one, mass=mass_properties(one)) for one in made)
        return tuple(replace(self, agent=agent, error=0.0) for agent in agents)

    @cached_property
    def hash(self) -> str:
        """Hash of all that decides its flights: body, environment, simulator, and the code of driftform."""
        scenario = self.scenario.model_dump(include={"fluid", "flow", "gusts", "contact"})
        simulator = (self.simulator.name, self.simulator.options.model_dump())
        # The mass properties and coefficients hold what builder and hydrodynamics made of the genome.
        parts = [asdict(part) for part in (self.agent.body, self.agent.mass, self.agent.coefficients)]
        return hash_content([parts, scenario, simulator, hash_code()])

    @cached_property
    def width(self) -> float:
        """Greatest diameter, m."""
        return self.agent.body.max_diameter

    @cached_property
    def net_buoyancy(self) -> float:
        """Net buoyancy in its water, N."""
        return self.agent.mass.net_buoyancy(self.scenario.fluid)

    def name_file(self, **flights: list[Any]) -> str:
        """Return the name of the file that keeps some flights of this body, which plain values describe."""
        return f"{hash_content({'body': self.hash, **flights})}.npz"

    def place(self, bore: float, speed: float) -> "Scenario":
        """Return its scenario in a straight pipe of a bore (m), with the mean speed of its water (m/s)."""
        from driftform.water import Pipe, Segment

        pipe = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(1.0, 0.0, 0.0), radius=bore / 2),))
        flow = self.scenario.flow.model_copy(update={"speed": speed})
        return self.scenario.model_copy(update={"pipe": pipe, "flow": flow})

    def is_mixed(self, speed: float) -> bool:
        """Return whether the water mixes the body over the bore like itself, at a mean speed (m/s)."""
        return abs(self.net_buoyancy) < self.mixing_limit(speed)

    def mixing_limit(self, speed: float) -> float:
        """Return the net buoyancy (N) up to which the water mixes the body over the bore like itself, at a mean speed (m/s).

        It is that of a Rouse number w / (kappa u*) of a quarter, with its terminal speed w, here that of a sphere of its
        diameter, and a friction velocity u* of a twentieth of the mean speed.
        """
        return float(0.25 * self.scenario.fluid.density * np.pi / 4 * self.width**2 * (0.1 * speed / 20) ** 2)


def buoyancy_error(agent: Agent, scenario: "Scenario") -> float:
    """Return the standard deviation of the net buoyancy (N) of a body that was weighed in water and trimmed, with two digits.

    As in disturbed flights of such bodies, the errors of scale and ballast lie evenly within a :data:`SCALE`, bubbles cling to the
    body, and its hull takes up water, only more and never less: half of a normal distribution.
    """
    robustness, fluid = scenario.robustness, scenario.fluid
    absorbed = np.sqrt(1 - 2 / np.pi) * robustness.absorbed * (agent.mass.mass - agent.body.core.mass)
    parts = (SCALE / np.sqrt(6), fluid.density * robustness.bubble, absorbed)
    return float(f"{fluid.gravity * np.linalg.norm(parts):.2g}")


def open_traveller(
    text: str, scenario: str | None = None, settings: Sequence[str] = (), buoyancy: float | None = None
) -> Traveller:
    """Open an agent to travel through a network.

    Args:
        text: AGENT as every command takes it, or ``sphere:5mm`` for a homogeneous sphere of that diameter.
        scenario: scenario or study whose environment to use; ``None`` for that of water mains.
        settings: ``key=value`` of the study, as ``--set`` takes them.
        buoyancy: net buoyancy to which ballast or core trims it, N, upward positive; ``None`` for that of its design, and
            for 0 of a sphere.

    Raises InputError if there is no such agent, or neither gives it that buoyancy.
    """
    from driftform import open_agent

    environment = scenario or str(SCENARIO)
    if not text.startswith(_SPHERE):
        return trim_design(open_agent(text, *settings, scenario=environment), buoyancy)
    from driftform import load_study
    from driftform.motion import forces

    pipeline = load_study(environment, settings, run={"seed": 0}).make_pipeline()
    number = text.removeprefix(_SPHERE).removesuffix("mm")
    try:
        diameter = float(number) / 1000
    except ValueError:
        diameter = 0.0
    if not 0.0005 <= diameter <= 2:
        raise InputError(f"AGENT '{text}': a sphere is named by its diameter from 0.5 to 2000 mm, such as sphere:5mm")
    agent = forces.make_sphere(diameter, pipeline.scenario.fluid, buoyancy or 0.0)
    if agent.mass.mass <= 0:
        raise InputError(f"--buoyancy {buoyancy:g}: {text} displaces too little water for it")
    name = text.replace(":", "-") + (_name_trim(buoyancy) if buoyancy else "")
    return Traveller(name, agent, pipeline.scenario, pipeline.simulator)


def trim_design(design: "Design", buoyancy: float | None) -> Traveller:
    """Return an agent that travels as designed, or trimmed to a net buoyancy (N): by its tuning, or else by its core.

    Raises InputError if no tuning gives it that buoyancy, or if it is too heavy for it without a core, or too light
    with one of lead.
    """
    if buoyancy is None:
        return Traveller(design.name, design.agent, design.scenario, design.pipeline.simulator, design)
    environment, genome = design.study.environment(), design.stored.genome
    if genome.tuning:
        genome = replace(genome, tuning=_find_tuning(design, buoyancy))
    else:
        core, missing = design.agent.body.core, design.agent.mass.net_buoyancy(design.scenario.fluid) - buoyancy
        mass, heaviest = core.mass + missing / design.scenario.fluid.gravity, LEAD_DENSITY * core.volume
        if not 0 <= mass <= heaviest:
            raise InputError(
                f"--buoyancy {buoyancy:g}: {design.name} needs a core of {1000 * mass:.1f} g for it; one of "
                f"{2000 * core.radius:.0f} mm in lead has {1000 * heaviest:.1f} g: choose another agent"
            )
        environment = {**environment, "builder": {**environment["builder"], "core": "custom", "core_mass": mass}}
    name = design.name + _name_trim(buoyancy)
    stored = replace(design.stored, name=name, genome=genome, environment=environment, result={})
    return trim_design(type(design).build(stored, name), None)


def _find_tuning(design: "Design", buoyancy: float) -> float:
    """Return the tuning that gives a tuned agent a net buoyancy, N."""
    from scipy.optimize import brentq

    morphology, pipeline, fluid = design.agent.morphology, design.pipeline, design.scenario.fluid
    assert morphology is not None

    def find_excess(tuning: float) -> float:
        return pipeline.realise(replace(morphology, tuning=tuning)).mass.net_buoyancy(fluid) - buoyancy

    bounds = pipeline.builder.find_tunings(morphology) or (morphology.tuning, morphology.tuning)
    least, most = sorted(map(find_excess, bounds))
    if not least <= 0 <= most:
        room = f"from {least + buoyancy:.3g} to {most + buoyancy:.3g} N"
        raise InputError(f"--buoyancy {buoyancy:g}: {design.name} can be tuned {room}: choose another agent")
    return float(brentq(find_excess, *bounds))


def _name_trim(buoyancy: float) -> str:
    if not buoyancy:
        return "-neutral"
    return f"-{'light' if buoyancy > 0 else 'heavy'}-{1000 * abs(buoyancy):g}mN"


@cache
def hash_code() -> str:
    """Return a hash of the source files that decide how a body flies: results of other versions are not used."""
    core, plugin = Path(driftform.__file__).parent, Path(__file__).parent
    files = [file for name in FLOWN_BY for file in sorted((core / name).rglob("*.py"))]
    files += [plugin / name for name in ("bore.py", "straight.py", "tees.py")]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()
