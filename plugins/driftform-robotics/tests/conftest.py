"""Specimens of many kinds, their exported folders, and the motion that their files must reproduce."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest

from driftform.agent import mass_properties
from driftform.interfaces import ExportJob
from driftform.study import Document, load_study
from driftform.testing.bodies import hollow_body
from driftform.types import Agent, Coefficients
from driftform.water import Scenario
from driftform.water.flow import UniformFlow
from driftform.water.scenario import Contact, Release
from driftform_robotics.models.fossen import FossenExporter
from driftform_robotics.models.mjcf import MjcfExporter
from driftform_robotics.models.sdf import SdfExporter
from driftform_robotics.models.urdf import UrdfExporter
from driftform_robotics.models.uuv import UuvExporter


@pytest.fixture(scope="session")
def study():
    return load_study("paper", run={"seed": 0})


def _random_agent(study, seed, drag):
    pipeline = load_study(
        Document("test", study.document), [f"hydrodynamics.drag={drag}"], run={"seed": 0}
    ).make_pipeline()
    return pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(seed)))


def _skewed_agent(seed):
    """Nothing on the axis, nothing diagonal; its quadratic damping is what the formats can hold exactly."""
    rng = np.random.default_rng(seed)
    body = hollow_body()
    mass = mass_properties(body)
    skew = rng.normal(size=(3, 3))
    mass = replace(
        mass,
        cog=mass.cog + rng.uniform(-3e-3, 3e-3, 3),
        cob=mass.cob + rng.uniform(-3e-3, 3e-3, 3),
        inertia=mass.inertia + 0.02 * mass.inertia.max() * (skew + skew.T),
    )
    size = np.array([1, 1, 1, 0.02, 0.02, 0.02])
    A, B = (size[:, None] * rng.normal(size=(6, 6)) for _ in range(2))
    coefficients = Coefficients(
        0.02 * A @ A.T,
        origin=mass.cog,
        linear_damping=0.05 * B @ B.T,
        quadratic_damping=np.diag(rng.uniform(0.1, 1.0, 6) * [1, 1, 1, 1e-5, 1e-5, 1e-5]),
    )
    return Agent(body, mass, coefficients)


KINDS = ("random", "another", "dragged", "skewed")


@pytest.fixture(scope="session")
def jobs(study):
    """Agents of the paper's grammar without drag and with it, and one that has no symmetry."""
    pipe = study.scenario.model_copy(update={"contact": Contact(friction=0.3)})
    tilted = pipe.model_copy(update={"release": Release(position=(1.0, 0.2, -0.3), pitch_deg=20.0)})
    return {
        "random": ExportJob("random", _random_agent(study, 3, "none"), pipe),
        "another": ExportJob("an-other 2", _random_agent(study, 4, "none"), tilted),
        "dragged": ExportJob("dragged", _random_agent(study, 5, "strips"), tilted),
        "skewed": ExportJob(
            "skewed",
            _skewed_agent(1),
            Scenario(flow=UniformFlow(speed=0.7), release=Release(pitch_deg=-30, velocity=(0.2, 0.1, -0.3))),
        ),
    }


@pytest.fixture(scope="session", params=KINDS)
def job(request, jobs):
    return jobs[request.param]


@pytest.fixture(scope="session", params=["random", "another", "skewed"])
def exact(request, jobs):
    """A job of which files can hold everything: no drag by strips."""
    return jobs[request.param]


EXPORTERS = {plugin.name: plugin for plugin in (FossenExporter, MjcfExporter, SdfExporter, UrdfExporter, UuvExporter)}


@pytest.fixture(scope="session")
def make_exporter():
    """Make the exporter of a format with options."""
    return lambda format, **options: EXPORTERS[format](EXPORTERS[format].Options(**options))


@pytest.fixture(scope="session")
def export(tmp_path_factory, make_exporter):
    """Export a job; return the folder. The same export is made once."""
    done = {}

    def make(format, job, **options):
        key = (format, id(job), tuple(sorted(options.items())))
        if key not in done:
            exporter = make_exporter(format, **options)
            folder = tmp_path_factory.mktemp(format) / f"agent{exporter.suffix}"
            exporter.write(job, folder)
            # With the job, whose identity must not pass to another.
            done[key] = job, folder
        return done[key][1]

    return make


@pytest.fixture(scope="session")
def system_environment(tmp_path_factory):
    """The environment of programs of the system, without the Python of the tests; ROS writes its logs to its own folder."""
    home = tmp_path_factory.mktemp("home")
    return {"PATH": "/usr/bin:/bin", "HOME": str(home), "ROS_HOME": str(home), "LC_ALL": "C.UTF-8"}


@pytest.fixture(scope="session")
def run_system(system_environment):
    """Run a command of the shell in a folder, by the system's own programs; return what it prints."""

    def run(command, folder, env=system_environment):
        done = subprocess.run(
            ["bash", "-c", command],
            cwd=folder,
            env=env,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=600,
            check=False,
        )
        assert done.returncode == 0, f"{command} ended with {done.returncode}\n{done.stdout}\n{done.stderr}"
        return done.stdout

    return run
