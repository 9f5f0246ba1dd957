"""The UUV simulator and gz-sim, reimplemented from their sources and fed with the exported files, against driftform.

Both are written here from the simulators' own code, in their frames and signs, and share nothing with driftform.
"""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from robots import inertia_of, our_accelerations, random_states, still
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from driftform import open_agent
from driftform.agent import slice_solid
from driftform.cli.app import app
from driftform.interfaces import ExportJob
from driftform.motion.forces.inertia import largest_added_mass_ratio
from driftform.motion.path.interpolation import interpolate_positions
from driftform.types import Coefficients
from driftform.water import Fluid, Scenario
from driftform.water.flow import UniformFlow
from driftform.water.scenario import FlightLimits
from driftform_robotics.models.gap import fly_own, fly_reader, read_link
from driftform_robotics.models.link import make_link
from driftform_robotics.models.sdf import SdfExporter, SdfOptions

BODIES = Path(__file__).parents[3] / "docs" / "bodies"

T = np.diag([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def coriolis(M, nu):
    """Fossen 2011, eq. 6.43, as both simulators build it."""
    ab = M @ nu
    return np.block([[np.zeros((3, 3)), -skew(ab[:3])], [-skew(ab[:3]), -skew(ab[3:])]])


def numbers(text):
    return np.array((text or "").split(), dtype=float)


class UuvSimulator:
    """``HMFossen::ApplyHydrodynamicForces`` and ``BuoyantObject::ApplyBuoyancyForce`` with the newest acceleration.

    The simulator uses the smoothed acceleration of the previous step; this is the limit if it converges.
    """

    def __init__(self, folder):
        robot = ET.parse(folder / "urdf/agent.xacro").getroot()
        inertial = robot.find("link/inertial")
        assert numbers(inertial.find("origin").get("xyz")).tolist() == [0, 0, 0]
        self.m = float(inertial.find("mass").get("value"))
        self.I = inertia_of(inertial.find("inertia").get)
        plugin = robot.find("gazebo/plugin[@name='uuv_plugin']")
        self.density = float(plugin.findtext("fluid_density"))
        link = plugin.find("link")
        assert link.get("name") == robot.find("link").get("name") == "$(arg namespace)/base_link"
        self.volume = float(link.findtext("volume"))
        self.height = float(link.findtext("box/height"))
        self.cob = numbers(link.findtext("center_of_buoyancy"))
        model = link.find("hydrodynamic_model")
        assert model.findtext("type") == "fossen"
        self.Ma = numbers(model.findtext("added_mass")).reshape(6, 6)
        self.DLin = numbers(model.findtext("linear_damping")).reshape(6, 6)
        self.DNonLin = np.diag(numbers(model.findtext("quadratic_damping")))
        world = ET.parse(folder / "worlds/pipe.world").getroot().find("world")
        self.g = -numbers(world.findtext("gravity"))[2]
        current = world.find("plugin[@name='underwater_current_plugin']/constant_current")
        speed, horizontal, vertical = (
            float(current.findtext(f"{tag}/mean")) for tag in ("velocity", "horizontal_angle", "vertical_angle")
        )
        self.current = speed * np.array(
            [np.cos(horizontal) * np.cos(vertical), np.sin(horizontal) * np.cos(vertical), np.sin(vertical)]
        )

    def buoyancy(self, z):
        volume = 0.0
        if z + self.height / 2 > 0 and z < 0:
            volume = self.volume * (abs(z) + self.height / 2) / self.height
        elif z + self.height / 2 < 0:
            volume = self.volume
        return volume * self.density * self.g

    def accelerations(self, R, v, w, z):
        relative = R.T @ v - R.T @ self.current
        velRel = T @ np.concatenate((relative, w))
        D = -self.DLin - self.DNonLin * np.abs(velRel)
        known = -D @ velRel - coriolis(self.Ma, velRel) @ velRel
        # velRel' = T [a - w x relative; alpha], with a in body axes.
        known += self.Ma @ T @ np.concatenate((np.cross(w, relative), np.zeros(3)))
        wrench = T @ known
        lift = R.T @ np.array([0, 0, self.buoyancy(z)])
        wrench[:3] += lift + R.T @ np.array([0, 0, -self.m * self.g])
        wrench[3:] += np.cross(self.cob, lift) - np.cross(w, self.I @ w)
        own = np.block([[self.m * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), self.I]])
        return np.linalg.solve(own + T @ self.Ma @ T, wrench)


class GzSim:
    """``Hydrodynamics::PreUpdate``, ``Buoyancy::PreUpdate`` and DART with a spatial inertia, of gz-sim of April 2026.

    Before that it did not have what ``corrects`` switches off.
    """

    corrects = True

    def __init__(self, path):
        folder = path.parent
        world = ET.parse(path).getroot().find("world")
        self.g = -numbers(world.findtext("gravity"))[2]
        systems = {str(plugin.get("name")).rpartition("::")[2]: plugin for plugin in world.iter("plugin")}
        self.density = float(systems["Buoyancy"].findtext("uniform_fluid_density"))
        link = world.find(f"model[@name='{systems['Buoyancy'].findtext('enable')}']/link")
        inertial = link.find("inertial")
        assert inertial.find("pose") is None and link.find("pose") is None
        self.m = float(inertial.findtext("mass"))
        self.I = inertia_of(inertial.find("inertia").findtext)
        self.Ma, self.lagged = np.zeros((6, 6)), np.zeros((6, 6))
        axes = "xyzpqr"
        for element in inertial.find("fluid_added_mass") or ():
            i, j = (axes.index(c) for c in element.tag)
            self.Ma[i, j] = self.Ma[j, i] = float(element.text)
        plugin = systems["Hydrodynamics"]
        assert plugin.findtext("link_name") == link.get("name")
        self.current = numbers(plugin.findtext("default_current"))
        self.disable_coriolis = plugin.findtext("disable_coriolis") == "true"
        # As ``Hydrodynamics::Configure`` composes the names.
        self.linear, self.absolute, self.signed = np.zeros((6, 6)), np.zeros((6, 6, 6)), np.zeros((6, 6, 6))
        for i, j in np.ndindex(6, 6):
            name = "xyzkmn"[i] + "UVWPQR"[j]
            self.lagged[i, j] = float(plugin.findtext(f"{name[0]}Dot{name[1]}", "0"))
            self.linear[i, j] = float(plugin.findtext(name, "0"))
            for k, rate in enumerate("UVWPQR"):
                self.absolute[i, j, k] = float(plugin.findtext(f"{name}abs{rate}", "0"))
                self.signed[i, j, k] = float(plugin.findtext(name + rate, "0"))
        assert not (self.Ma.any() and self.lagged.any()), "added mass would count twice"
        self.volume, moment = 0.0, np.zeros(3)
        for collision in link.findall("collision"):
            mesh, radius = collision.findtext("geometry/mesh/uri"), collision.findtext("geometry/sphere/radius")
            volume = unsigned_volume(folder / mesh) if mesh else 4 / 3 * np.pi * float(radius) ** 3
            self.volume += volume
            moment += volume * numbers(collision.findtext("pose"))[:3]
        self.cob = moment / self.volume

    def damping(self, state):
        return (self.linear + self.absolute @ np.abs(state) + self.signed @ state) @ state

    def accelerations(self, R, v, w):
        absolute = np.concatenate((R.T @ v, w))
        state = np.concatenate((R.T @ (v - self.current), w))
        wrench = self.damping(state)
        if self.corrects:
            wrench -= coriolis(self.Ma, state) @ state - coriolis(self.Ma, absolute) @ absolute
        lift = R.T @ np.array([0, 0, self.density * self.volume * self.g])
        wrench[:3] += lift + R.T @ np.array([0, 0, -self.m * self.g])
        wrench[3:] += np.cross(self.cob, lift)
        own = np.block([[self.m * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), self.I]])
        total = own + self.Ma
        # DART: G V' = F + ad*(V) G V, and V' is the derivative in the body frame: m (a - w x v).
        momentum = total @ absolute
        gyration = np.concatenate(
            (np.cross(momentum[:3], w), np.cross(momentum[3:], w) + np.cross(momentum[:3], absolute[:3]))
        )
        rate = np.linalg.solve(total, wrench + gyration)
        return rate + np.concatenate((np.cross(w, absolute[:3]), np.zeros(3)))


def unsigned_volume(path):
    """``SubMesh::Volume`` of gz-common as it was released up to 2026: tetrahedra without their sign."""
    lines = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    points = np.array([line[1:] for line in lines if line[0] == "v"], dtype=float)
    corners = np.array([[c.split("/")[0] for c in line[1:]] for line in lines if line[0] == "f"], dtype=int) - 1
    a, b, c = points[corners].transpose(1, 0, 2)
    return float(np.abs(np.einsum("ij,ij->i", np.cross(a, b), c)).sum() / 6)


def largest_deviation(found, expected):
    """Over forces and over moments apart, relative to the largest acceleration of each."""
    a, b = np.array(found), np.array(expected)
    return max(np.abs(a[:, part] - b[:, part]).max() / np.abs(b[:, part]).max() for part in (slice(3), slice(3, 6)))


def test_the_uuv_simulators_law_gives_our_accelerations(exact, export):
    simulator = UuvSimulator(export("uuv", exact))
    states = random_states(50)
    found = [simulator.accelerations(s.R, s.velocity, s.omega, -20.0) for s in states]
    assert largest_deviation(found, [our_accelerations(exact, s) for s in states]) < 1e-6


@pytest.mark.parametrize("name", ["random", "another"])
def test_gazebos_law_gives_our_accelerations_in_water_at_rest(name, jobs, export):
    calm = still(jobs[name])
    simulator = GzSim(export("sdf", calm) / "world.sdf")
    states = random_states(50)
    found = [simulator.accelerations(s.R, s.velocity, s.omega) for s in states]
    # Vertices of the meshes have nine digits.
    assert largest_deviation(found, [our_accelerations(calm, s) for s in states]) < 1e-6


def test_in_a_current_gazebo_lacks_the_inertia_of_water_that_turns_past_the_body(jobs, export):
    """What docs/robotics.md says of gz-sim: -M_A (w x u) is missing, and nothing else."""
    job = jobs["random"]
    simulator = GzSim(export("sdf", job) / "world.sdf")
    total = simulator.Ma + np.diag([simulator.m] * 3 + [0] * 3)
    total[3:, 3:] += simulator.I
    states, found = random_states(20), []
    for s in states:
        turning = np.concatenate((np.cross(s.omega, s.R.T @ simulator.current), np.zeros(3)))
        lacking = np.linalg.solve(total, -simulator.Ma @ turning)
        found.append(simulator.accelerations(s.R, s.velocity, s.omega) + lacking)
    expected = [our_accelerations(job, s) for s in states]
    assert largest_deviation(found, expected) < 1e-6
    without = [simulator.accelerations(s.R, s.velocity, s.omega) for s in states]
    assert largest_deviation(without, expected) > 1e-3


def flight_by_gazebo(simulator, cog, velocity, times, attitude=None):
    """Places of the core's centre, released (level) at the origin, by Gazebo's law integrated exactly, (k, 3)."""
    attitude = attitude or Rotation.identity()

    def rate(_, y):
        turn, w = Rotation.from_quat(y[3:7]), y[10:]
        R = turn.as_matrix()
        found = simulator.accelerations(R, y[7:10], w)
        x, s = y[3:6], y[6]
        spin = 0.5 * np.array([*(s * w + np.cross(x, w)), -x @ w])
        return np.concatenate((y[7:10], spin, R @ found[:3], found[3:]))

    start = np.concatenate((attitude.as_matrix() @ cog, attitude.as_quat(), velocity, np.zeros(3)))
    solution = solve_ivp(rate, (0, times[-1]), start, t_eval=times, rtol=1e-8, atol=1e-10)
    return np.array([y[:3] - Rotation.from_quat(y[3:7]).as_matrix() @ cog for y in solution.y.T])


@pytest.mark.slow
def test_how_far_gazebo_is_off_in_a_current(study, tmp_path):
    """The numbers of docs/robotics.md: nearly neutral random agents in 1 m/s."""
    pipeline, times = study.make_pipeline(), np.array([1.0, 3.0])
    current = np.array([1.0, 0.0, 0.0])
    offs = {"corrected": [], "uncorrected": [], "drift": []}
    for seed in range(12):
        agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(seed)))
        density = 1.004 * agent.mass.mass / agent.mass.volume
        added = density / study.scenario.fluid.density * agent.coefficients.added_mass
        agent = replace(agent, coefficients=Coefficients(added, agent.coefficients.origin))
        scenario = Scenario(fluid=Fluid(density=density), flight=FlightLimits(horizon=3.0))
        assert np.array_equal(scenario.current(), current)
        folder = tmp_path / f"{seed}-sdf"
        SdfExporter(SdfOptions()).write(ExportJob("agent", agent, scenario), folder)
        ours = interpolate_positions(pipeline.simulator.simulate(agent, scenario), times)
        world, drift = (GzSim(folder / name) for name in ("world.sdf", "drift.sdf"))
        cog = agent.mass.cog
        flights = {
            "corrected": flight_by_gazebo(world, cog, current, times),
            "drift": flight_by_gazebo(drift, cog, 0 * current, times) + times[:, None] * current,
        }
        world.corrects = False
        flights["uncorrected"] = flight_by_gazebo(world, cog, current, times)
        for name, path in flights.items():
            offs[name].append(np.linalg.norm(path - ours, axis=1))
    medians = {name: np.median(found, axis=0) for name, found in offs.items()}
    np.testing.assert_allclose(medians["corrected"], [0.6, 1.8], rtol=0.1)
    np.testing.assert_allclose(medians["uncorrected"], [0.15, 0.4], rtol=0.1)
    assert np.max(offs["drift"]) < 1e-3


@pytest.mark.parametrize("name", ["random", "another"])
def test_seen_from_the_water_gazebo_is_exact_in_a_current_too(name, jobs, export):
    job = jobs[name]
    current = job.scenario.current()
    assert current.any()
    folder = export("sdf", job)
    simulator = GzSim(folder / "drift.sdf")
    states = random_states(50)
    found = [simulator.accelerations(s.R, s.velocity - current, s.omega) for s in states]
    assert largest_deviation(found, [our_accelerations(job, s) for s in states]) < 1e-6
    world = ET.parse(folder / "drift.sdf").getroot().find("world")
    for model in ("pipe", "targets"):
        assert world.find(f"model[@name='{model}']/static") is None
        control = world.find(f"model[@name='{model}']/plugin[@name='gz::sim::systems::VelocityControl']")
        np.testing.assert_allclose(numbers(control.findtext("initial_linear")), -current)
    # Released with the current, the agent is at rest in the water, and needs no push.
    assert not (folder / "push_drift.sh").exists()


def test_the_whole_pipe_is_below_the_uuv_simulators_surface(jobs, export):
    folder = export("uuv", jobs["random"])
    world = ET.parse(folder / "worlds/pipe.world").getroot().find("world")
    planks = [numbers(e.findtext("pose")) for e in world.findall("model[@name='pipe']/link/collision")]
    heights = np.array(planks)[:, 2]
    assert heights.max() < 0
    middle = (heights.max() + heights.min()) / 2
    args = ET.parse(folder / "launch/start.launch").getroot().find(".//node[@name='spawn']").get("args").split()
    place = {key: float(args[args.index(key) + 1]) for key in ("-x", "-y", "-z", "-R", "-P", "-Y")}
    cog = jobs["random"].agent.mass.cog
    assert place["-z"] == pytest.approx(middle)
    assert place["-x"] == pytest.approx(cog[0])


def test_a_pipe_that_rises_above_the_water_is_a_warning(jobs, export):
    folder = export("uuv", jobs["random"], depth=0.5)
    assert "rises 0.5 m above the water" in (folder / "urdf/agent.xacro").read_text(encoding="utf-8")


@pytest.mark.parametrize("share", [0.97, 1.03])
def test_a_warning_appears_if_and_only_if_lagged_added_mass_diverges(share, jobs, export):
    """The simulator's own filter, with the exported matrices: it diverges if and only if the export warns."""
    job = jobs["random"]
    agent = job.agent
    ratio = largest_added_mass_ratio(agent.mass, agent.coefficients)
    scale = share * 17 / 3 / ratio
    coefficients = Coefficients(scale * agent.coefficients.added_mass, agent.coefficients.origin)
    heavy = replace(job, agent=replace(agent, coefficients=coefficients))
    folder = export("uuv", heavy)
    simulator = UuvSimulator(folder)
    own = np.diag([simulator.m] * 3 + [0.0] * 3)
    own[3:, 3:] = simulator.I
    filtered, push = np.zeros(6), np.ones(6)
    for _ in range(2000):
        newest = np.linalg.solve(own, push - simulator.Ma @ filtered)
        filtered = 0.7 * filtered + 0.3 * newest
    settled = np.linalg.solve(own + simulator.Ma, push)
    diverges = bool(np.abs(filtered - settled).max() > np.abs(settled).max())
    assert diverges == (share > 1)
    assert ("UNSTABLE" in (folder / "urdf/agent.xacro").read_text(encoding="utf-8")) == diverges


def gap_in(path):
    """Distances (m) by times (s), and the step (s), of the sentence in a file."""
    text = path.read_text(encoding="utf-8")
    sentence = re.search(r"The path by .*? steps of \S+ s\.", text).group(0)
    found = re.findall(r"(\S+) m after (\d) s", sentence)
    step = float(re.search(r"steps of (\S+) s\.", sentence).group(1))
    return {float(t): float(distance) for distance, t in found}, step


@pytest.mark.parametrize(("name", "world"), [("dragged", "drift.sdf"), ("another", "world.sdf")])
def test_the_gap_in_the_file_is_that_of_gazebos_law_from_our_flight(name, world, jobs, export, study):
    """The law read from the file and integrated exactly; the gap has two digits, and a small error of the step."""
    job = jobs[name]
    current, folder = job.scenario.current(), export("sdf", job)
    in_open = {"pipe": type(job.scenario.pipe)(), "flight": FlightLimits(horizon=3.0)}
    flight = study.make_pipeline().simulator.simulate(job.agent, job.scenario.model_copy(update=in_open))
    gap, step = gap_in(folder / world)
    assert list(gap) == [1.0, 3.0, 5.0]
    assert ET.parse(folder / world).getroot().findtext("world/physics/max_step_size") == f"{step:g}"
    times, passing = np.array([1.0, 3.0]), current if world == "drift.sdf" else 0 * current
    start = Rotation.from_quat(np.roll(flight.quaternion[0], -1))
    simulator = GzSim(folder / world)
    path = flight_by_gazebo(simulator, job.agent.mass.cog, current - passing, times, start)
    ours = interpolate_positions(flight, times) - flight.position[0]
    apart = np.linalg.norm(path + times[:, None] * passing - ours, axis=1)
    np.testing.assert_allclose([gap[t] for t in times], apart, rtol=0.12, atol=0.01)


def steps_by_fortress(law, R, velocity, step, sign=1):
    """Displacement in water at rest after 1, 3 and 5 s by gz-sim 6.18: ``PreUpdate`` and ``buildCoriolisMatrix``.

    A ``sign`` of -1 turns the Coriolis forces of added mass into Kirchhoff's.
    """
    state, x, path = np.concatenate((R.T @ velocity, np.zeros(3))), np.zeros(3), []
    own = np.block([[law.m * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), law.I]])
    inverse, diagonal, previous = np.linalg.inv(own), np.diag(np.diag(law.lagged)), state
    for k in range(round(5 / step)):
        wrench = law.lagged @ (state - previous) / step + law.damping(state)
        if not law.disable_coriolis:
            # Its matrix has the sign of C_A for the negative derivatives that are asked for, so that the force has not.
            wrench -= sign * coriolis(diagonal, state) @ state
        previous = state
        lift = R.T @ np.array([0, 0, law.volume * law.density * law.g])
        wrench[:3] += lift - R.T @ np.array([0, 0, law.m * law.g])
        wrench[3:] += np.cross(law.cob, lift) - np.cross(state[3:], law.I @ state[3:])
        rates = inverse @ wrench
        moving, w = R @ (state[:3] + step * rates[:3]), state[3:] + step * rates[3:]
        x = x + step * moving
        R = R @ Rotation.from_rotvec(step * w).as_matrix()
        state = np.concatenate((R.T @ moving, w))
        if (k + 1) * step in (1.0, 3.0, 5.0):
            path.append(x)
    return np.array(path)


def drift_in_the_sea(folder, hull, *words, density=1030.0):
    """A hull of docs/robotics.md, which drifts in the sea."""
    files = [str(BODIES / f"{hull}.csv"), "--scenario", str(folder / "sea.toml"), "--out", str(folder / "own.json")]
    sea = (BODIES / "open-sea.toml").read_text(encoding="utf-8")
    (folder / "sea.toml").write_text(sea.replace("density = 1030.0", f"density = {density}"), encoding="utf-8")
    assert CliRunner().invoke(app, ["body", *files, *words]).exit_code == 0
    return open_agent(folder / "own.json").export_job()


@pytest.fixture(scope="module")
def remus(tmp_path_factory):
    words = ("--mass", "30.48", "--cog", "0.611", "--inertia", "0.177", "3.45")
    return drift_in_the_sea(tmp_path_factory.mktemp("remus"), "remus-100", *words)


@pytest.fixture(scope="module")
def lauv(tmp_path_factory):
    """Its mass, centre and water were not noted: these give all four distances, of the server and in the file of 0.2.0."""
    words = ("--mass", "18", "--cog", "0.54")
    return drift_in_the_sea(tmp_path_factory.mktemp("lauv"), "lauv", *words, density=1028.0)


@pytest.mark.parametrize(
    ("name", "measured", "stated"),
    [("remus", (0.375, 2.217), (0.123, 0.273)), ("lauv", (0.029, 0.075), (0.00997, 0.0235))],
)
def test_the_law_of_fortress_flies_hulls_as_a_real_server_did(name, measured, stated, remus, lauv, export):
    """Distances from driftform's path after 3 and 5 s of Gazebo Fortress 6.18 with the file of driftform 0.2.0.

    That file stated those of Coriolis forces with Kirchhoff's sign.
    """
    job = {"remus": remus, "lauv": lauv}[name]
    link, law = make_link(job), GzSim(export("sdf", job, gazebo="fortress") / "drift.sdf")
    law.m, law.I, law.volume, law.cob = link.mass, link.inertia, link.volume, link.buoyancy
    law.signed, law.absolute = np.zeros((6, 6, 6)), np.zeros((6, 6, 6))
    law.absolute[:, range(6), range(6)] = -link.quadratic_damping
    law.lagged, law.disable_coriolis = -link.added_mass, False
    for sign, expected in ((1, measured), (-1, stated)):
        path = steps_by_fortress(law, link.rotation, np.zeros(3), 0.002, sign)
        apart = np.linalg.norm(path - fly_own(job, link, 5.0)[[100, 300, 500]], axis=1)
        assert apart[1:] == pytest.approx(expected, rel=0.01)


@pytest.fixture(scope="module")
def pocketed():
    """A sealed agent with trim pockets, whose outer volume is not what it displaces."""
    word = "-".join(["addF-tiltp-0-L-moveF"] * 5 + ["addB-tiltn-1-L-moveB"] * 3)
    core = ("builder.core=custom", "builder.core_radius=0.01", "builder.core_mass=0.0125")
    job = open_agent(word, "builder.pockets.diameter=0.008", *core).export_job()
    outer = float(slice_solid(job.agent.body.outer, 1)[0, 1])
    assert outer - job.agent.mass.volume > 5e-7
    return job


@pytest.mark.parametrize("gazebo", ["harmonic", "fortress"])
def test_water_in_pockets_weighs_nothing_in_gazebo(pocketed, export, tmp_path, gazebo):
    facts = SdfExporter(SdfOptions(gazebo=gazebo)).write(pocketed, tmp_path / "stated")[0].facts
    mass = pocketed.agent.mass
    assert (facts["cog_mm"], facts["cob_mm"]) == pytest.approx((1e3 * mass.cog[0], 1e3 * mass.cob[0]))
    for file in ("world.sdf", "drift.sdf"):
        law = GzSim(export("sdf", pocketed, gazebo=gazebo) / file)
        net = mass.mass - law.density * mass.volume
        assert law.m - law.density * law.volume == pytest.approx(net, abs=2e-5)


@pytest.mark.parametrize("name", ["remus", "lauv", "dragged", "pocketed"])
def test_the_gap_of_fortress_is_that_of_its_law_and_small(name, remus, lauv, pocketed, jobs, export):
    """What lags is stable for bodies that have more added than own mass."""
    job = {"remus": remus, "lauv": lauv, "pocketed": pocketed, **jobs}[name]
    link, file = make_link(job), export("sdf", job, gazebo="fortress") / "drift.sdf"
    gap, step = gap_in(file)
    path = steps_by_fortress(GzSim(file), link.rotation, link.velocity - job.scenario.current(), step)
    apart = np.linalg.norm(path - fly_own(job, link, 5.0)[[100, 300, 500]], axis=1)
    np.testing.assert_allclose(list(gap.values()), apart, rtol=0.05, atol=1e-4)
    assert apart.max() < 0.1


@pytest.mark.parametrize("pitch", [20.0, -20.0])
@pytest.mark.parametrize("name", ["remus", "dragged"])
def test_from_other_releases_the_same_file_flies_nearly_as_well_in_fortress(name, pitch, remus, jobs, export):
    """The fit has seen one release."""
    job = {"remus": remus, **jobs}[name]
    file = export("sdf", job, gazebo="fortress") / "drift.sdf"
    law, (_, step), release = GzSim(file), gap_in(file), job.scenario.release
    turned = release.model_copy(update={"pitch_deg": release.pitch_deg + pitch})
    other = replace(job, scenario=job.scenario.model_copy(update={"release": turned}))
    link = make_link(other)
    path = steps_by_fortress(law, link.rotation, link.velocity - other.scenario.current(), step)
    apart = np.linalg.norm(path - fly_own(other, link, 5.0)[[100, 300, 500]], axis=1)
    assert apart.max() < 0.1


def steps_by_the_uuv_simulator(simulator, R, velocity, step):
    """Displacement relative to the water after each step of 1 s, with the filtered acceleration of the step before."""
    nu, x, filtered, path = np.concatenate((R.T @ velocity, np.zeros(3))), np.zeros(3), np.zeros(6), []
    own = np.diag([simulator.m] * 3 + [0.0] * 3)
    own[3:, 3:] = simulator.I
    for _ in range(round(1 / step)):
        v, w, relative = nu[:3], nu[3:], T @ nu
        known = (simulator.DLin + simulator.DNonLin * np.abs(relative)) @ relative
        wrench = T @ (known - coriolis(simulator.Ma, relative) @ relative - simulator.Ma @ filtered)
        lift = R.T @ np.array([0, 0, simulator.buoyancy(-20.0)])
        wrench[:3] += lift + R.T @ np.array([0, 0, -simulator.m * simulator.g])
        wrench[3:] += np.cross(simulator.cob, lift) - np.cross(w, simulator.I @ w)
        felt = np.linalg.solve(own, wrench)
        filtered = 0.7 * filtered + 0.3 * T @ (felt - np.concatenate((np.cross(w, v), np.zeros(3))))
        moving, w = R @ (v + step * felt[:3]), w + step * felt[3:]
        x = x + step * moving
        R = R @ Rotation.from_rotvec(step * w).as_matrix()
        nu = np.concatenate((R.T @ moving, w))
        path.append(x)
    return np.array(path)


@pytest.mark.parametrize("name", ["dragged", "another"])
def test_the_gap_of_the_uuv_simulator_has_the_lag_of_its_added_mass(name, jobs, export):
    job, step = jobs[name], 0.002
    link, folder = make_link(job), export("uuv", job, step=0.002)
    simulator = UuvSimulator(folder)
    path = steps_by_the_uuv_simulator(simulator, link.rotation, link.velocity - simulator.current, step)
    diagonal = replace(link, quadratic_damping=np.diag(np.diag(link.quadratic_damping)))
    reader = replace(read_link("", diagonal, simulator.density), smoothing=0.3)
    emulated = fly_reader(reader, job, link, 1.0, step)
    assert np.linalg.norm(path[-1]) > 0.1
    np.testing.assert_allclose(emulated[1:], path, atol=1e-6)
    gap, stated = gap_in(folder / "urdf/agent.xacro")
    ours = fly_own(job, link, 5.0)[100]
    assert stated == step and gap[1.0] == pytest.approx(np.linalg.norm(path[-1] - ours), rel=0.06)


def test_the_angles_of_a_current_are_those_by_which_the_simulator_turns_it(jobs, export):
    current = (0.3, -0.4, 0.2)
    flow = UniformFlow(speed=0.0, added=current)
    job = replace(jobs["skewed"], scenario=jobs["skewed"].scenario.model_copy(update={"flow": flow}))
    assert UuvSimulator(export("uuv", job)).current == pytest.approx(current, rel=1e-9)
