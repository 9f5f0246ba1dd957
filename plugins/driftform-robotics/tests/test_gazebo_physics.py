"""Gazebo's physics engine, with the plugin that Gazebo loads, reads every SDF file and steps it."""

import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from robots import inertia_of, model_of

from driftform.water.scenario import Contact

SOURCE = Path(__file__).parent / "programs" / "fall.cc"
LIBRARIES = (
    "ignition-physics5-sdf",
    "ignition-physics5-mesh",
    "ignition-plugin1-loader",
    "ignition-common4-graphics",
    "sdformat12",
)
ENGINE = "ignition-physics5-dartsim-plugin"


@pytest.fixture(scope="session")
def fall(requires_program, tmp_path_factory):
    """Load a file and let it fall for 1 s; return what the program prints, by the first word of each line."""
    package, compiler = requires_program("pkg-config"), requires_program("g++")
    program = tmp_path_factory.mktemp("fall") / "fall"

    def ask(*options):
        done = subprocess.run([package, *options], capture_output=True, encoding="utf-8", check=False)
        if done.returncode:
            pytest.skip(f"{ENGINE} is not installed: {done.stderr.strip()}")
        return done.stdout.split()

    [folder] = ask("--variable=libdir", ENGINE)
    flags = [f'-DDART="{folder}/lib{ENGINE}.so"', *ask("--cflags", "--libs", *LIBRARIES)]
    built = subprocess.run(
        [compiler, str(SOURCE), *flags, "-o", str(program)], capture_output=True, encoding="utf-8", check=False
    )
    assert built.returncode == 0, built.stderr

    def run(path, model, steps):
        done = subprocess.run(
            [program, path, model, str(steps)],
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=600,
            check=False,
        )
        assert done.returncode == 0, f"ended with {done.returncode}\n{done.stderr}"
        # Of several programs at once only one can have the port of the profiler.
        errors = [line for line in done.stderr.splitlines() if "[Err]" in line and "Remotery" not in line]
        assert not errors
        rows = {}
        for line in done.stdout.splitlines():
            name, *values = line.split()
            rows.setdefault(name, []).append([float(value) for value in values])
        return {name: np.squeeze(values) for name, values in rows.items()}

    return run


def copy_for_fortress(folder, target):
    """Copy the SDF files; the library here reads SDF 1.9 at most, which lacks added mass and no other tag of ours."""
    copies = []
    (target / "meshes").symlink_to(folder / "meshes")
    for path in sorted(folder.glob("*.sdf")):
        tree = ET.parse(path)
        tree.getroot().set("version", "1.9")
        for inertial in tree.getroot().iter("inertial"):
            for added in inertial.findall("fluid_added_mass"):
                inertial.remove(added)
        tree.write(target / path.name, encoding="utf-8")
        copies.append(target / path.name)
    return copies


@pytest.mark.parametrize(
    ("kind", "gazebo"),
    [("random", "harmonic"), ("another", "fortress"), ("dragged", "fortress"), ("skewed", "harmonic")],
)
def test_dart_steps_every_file_and_finds_mass_inertia_and_free_fall(kind, gazebo, jobs, export, fall, tmp_path):
    # With friction DART solves three equations for each of the many contacts of an impact in air: a step takes minutes.
    scenario = jobs[kind].scenario.model_copy(update={"contact": Contact(friction=0.0)})
    job = replace(jobs[kind], scenario=scenario)
    folder = export("sdf", job, gazebo=gazebo, step=0.002)
    paths = copy_for_fortress(folder, tmp_path) if gazebo == "harmonic" else sorted(folder.glob("*.sdf"))
    assert len(paths) == len(list(folder.glob("*.sdf"))) > 1
    name = ET.parse(folder / "model.sdf").getroot()[0].get("name")
    mass, pieces = job.agent.mass, len(list(folder.glob("meshes/piece_*.obj")))
    for path in paths:
        world = ET.parse(path).getroot().find("world")
        step = 0.001 if world is None else float(world.findtext("physics/max_step_size"))
        found = fall(path, name, round(1 / step))
        assert found["models"] == (1 if world is None else len(world.findall("model")))
        assert found["meshes"] == pieces
        # For Fortress a part of the added mass is in both.
        inertial = model_of(path, name).find("link/inertial")
        inertia = inertia_of(inertial.find("inertia").findtext)
        assert gazebo == "fortress" or (float(inertial.findtext("mass")) == pytest.approx(mass.mass, rel=1e-9))
        assert found["mass"] == pytest.approx(float(inertial.findtext("mass")), rel=1e-9)
        np.testing.assert_allclose(found["inertia"].reshape(3, 3), inertia, atol=1e-7 * inertia.max())
        # Before the wall of the pipe is near.
        gravity = 9.80665 if world is None else job.scenario.fluid.gravity
        start = 0.0 if world is None else float(world.findtext(f"model[@name='{name}']/pose").split()[2])
        t, z, v = found["fall"][:2].T
        np.testing.assert_allclose(v, -gravity * t, rtol=1e-9)
        np.testing.assert_allclose(z - start, -gravity * t * (t + step) / 2, rtol=1e-6)
        assert np.isfinite(found["end"]).all()
        # What is inside of a pipe at rest cannot fall through its wall.
        if path.name == "world.sdf" and not job.scenario.pipe.is_open:
            assert found["fall"][-1, 1] > -9.81 / 2 + 1
