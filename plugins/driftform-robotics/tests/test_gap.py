"""How far the path by a file's equations lies from driftform's: the paths, the choice of the step, and where it is stated."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from driftform.util.rotations import matrix_from_quaternion
from driftform.water.scenario import FlightLimits
from driftform_robotics.models.gap import STEPS, fly_own, fly_reader, measure_gap, read_link
from driftform_robotics.models.link import make_link

SENTENCE = re.compile(r"The path by [^<\n]*?, with steps of (\S+) s\.")


@pytest.mark.parametrize("name", ["dragged", "another"])
def test_our_path_is_that_of_a_flight_in_open_water_with_the_current(name, jobs, study):
    job = jobs[name]
    in_open = {"pipe": type(job.scenario.pipe)(), "flight": FlightLimits(horizon=2.0)}
    flight = study.make_pipeline().simulator.simulate(job.agent, job.scenario.model_copy(update=in_open))
    first, last = (
        x + matrix_from_quaternion(q) @ job.agent.mass.cog
        for x, q in zip(flight.position[[0, -1]], flight.quaternion[[0, -1]], strict=True)
    )
    assert job.scenario.current().any()
    path = fly_own(job, make_link(job), 2.0)
    assert path[0].tolist() == [0, 0, 0]
    np.testing.assert_allclose(path[-1], last - first - 2.0 * job.scenario.current(), atol=1e-3)


def test_a_program_with_our_equations_and_short_steps_has_our_path(jobs):
    """Nothing is replaced in the damping of this agent; the error of the step is of first order."""
    job = jobs["skewed"]
    link = make_link(job)
    reader = read_link("Gazebo", link, job.scenario.fluid.density)
    ours = fly_own(job, link, 1.0)
    apart = [np.linalg.norm(fly_reader(reader, job, link, 1.0, s) - ours, axis=1).max() for s in (4e-4, 2e-4)]
    assert apart[1] < 0.6 * apart[0] < 0.05
    assert np.linalg.norm(ours[-1]) > 0.2


def test_the_step_is_the_longest_whose_error_is_small_beside_the_gap(jobs):
    found = {}
    for name, job in jobs.items():
        link = make_link(job)
        reader = read_link("Gazebo", link, job.scenario.fluid.density)
        gap = measure_gap(reader, job, link)
        fine, path = (fly_reader(reader, job, link, 5.0, s)[[100, 300, 500]] for s in (1e-5, gap.step))
        accepted = max(0.01, 0.1 * max(gap.distances.values()))
        if gap.step > STEPS[-1]:
            assert np.linalg.norm(path - fine, axis=1).max() < 1.5 * accepted
        found[name] = gap.step
    assert found["dragged"] > found["random"]


def test_a_lag_that_diverges_with_every_step_is_described_and_costs_no_short_steps(jobs):
    job = jobs["random"]
    link = make_link(job)
    assert link.added_mass_ratio > 1
    gap = measure_gap(replace(read_link("Gazebo", link, job.scenario.fluid.density), smoothing=1.0), job, link)
    assert gap.step == 0.001 and gap.describe().startswith("The path by Gazebo diverges, with steps of 0.001 s.")


HEADERS = {"sdf": ("world.sdf", "drift.sdf", "model.sdf"), "uuv": ("urdf/agent.xacro",), "mjcf": ("agent.xml",)}


@pytest.mark.parametrize(
    ("format", "options"), [("sdf", {}), ("sdf", {"gazebo": "fortress"}), ("uuv", {}), ("mjcf", {})]
)
def test_the_gap_is_in_the_header_and_in_the_readme(format, options, jobs, export):
    for job in jobs.values():
        folder = export(format, job, **options)
        sentences = set()
        for name in HEADERS[format]:
            if (folder / name).exists():
                stated = SENTENCE.search((folder / name).read_text(encoding="utf-8"))
                assert stated is not None, name
                sentences.add(stated.group(0))
        if format != "mjcf":
            readme = (folder / "README.md").read_text(encoding="utf-8")
            # Gazebo and the UUV simulator do not run here.
            assert "not checked by the program" in readme
            assert all(sentence in readme for sentence in sentences)


def test_the_step_of_a_world_is_that_of_its_sentence_and_can_be_given(job, export):
    def step_of(folder, world):
        return float(ET.parse(folder / world).getroot().findtext("world/physics/max_step_size"))

    for format, world, header in (
        ("sdf", "world.sdf", "world.sdf"),
        ("sdf", "drift.sdf", "drift.sdf"),
        ("uuv", "worlds/pipe.world", "urdf/agent.xacro"),
    ):
        for options, allowed in (({}, STEPS), ({"step": 0.004}, (0.004,))):
            folder = export(format, job, **options)
            stated = SENTENCE.search((folder / header).read_text(encoding="utf-8"))
            assert step_of(folder, world) == float(stated.group(1)) and step_of(folder, world) in allowed
