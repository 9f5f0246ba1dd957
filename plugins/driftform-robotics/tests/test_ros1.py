"""ROS 1: catkin builds the package for the UUV simulator, roslaunch reads it, and rospy receives what bags hold."""

import xml.etree.ElementTree as ET
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import yaml
from ros1 import listen, run_master, start

from driftform.testing import RecorderContract
from driftform.testing.renderer import drifting_trajectory
from driftform_robotics.options import FlightOptions
from driftform_robotics.recording.recorders import Rosbag1Recorder

# Stand-ins for packages that Debian does not have. The last xacro of ROS 1 is not on PyPI: that of ROS 2 finds packages
# by the index of ament.
MANIFEST = """<package format="2">
  <name>{name}</name><version>1.0.0</version><description>Stand-in</description>
  <maintainer email="driftform@example.org">driftform</maintainer><license>MIT</license>
  <buildtool_depend>catkin</buildtool_depend>
</package>
"""
WORLD = """<launch>
  <arg name="world_name"/><arg name="paused"/><arg name="use_sim_time"/><arg name="gui"/>
  <param name="/use_sim_time" value="$(arg use_sim_time)"/>
  <param name="/world" textfile="$(arg world_name)"/>
</launch>
"""
XACRO = """#!/usr/bin/python3
import sys
sys.path.append({packages!r})
import rospkg, xacro, xacro.substitution_args
xacro.substitution_args._eval_find = rospkg.RosPack().get_path
xacro.main()
"""


def add_stand_in(source, name, path, text):
    file = source / name / path
    file.parent.mkdir(parents=True)
    file.write_text(text, encoding="utf-8")
    file.chmod(0o755)
    (source / name / "package.xml").write_text(MANIFEST.format(name=name), encoding="utf-8")
    build = f"cmake_minimum_required(VERSION 3.0.2)\nproject({name})\nfind_package(catkin REQUIRED)\ncatkin_package()\n"
    (source / name / "CMakeLists.txt").write_text(build, encoding="utf-8")


@pytest.fixture(scope="module")
def workspace(jobs, export, requires_program, run_system, tmp_path_factory):
    """A workspace of catkin with the packages of all agents, built."""
    requires_program("catkin_make")
    folder = tmp_path_factory.mktemp("catkin")
    for name, job in jobs.items():
        (folder / "src").mkdir(exist_ok=True)
        (folder / "src" / name).symlink_to(export("uuv", job))
    add_stand_in(folder / "src", "gazebo_ros", "launch/empty_world.launch", WORLD)
    spec = find_spec("xacro")
    packages = str(Path(spec.origin).parents[1])
    add_stand_in(folder / "src", "xacro", "xacro", XACRO.format(packages=packages))
    run_system("catkin_make", folder)
    return folder


def test_roslaunch_finds_every_file_and_xacro_makes_a_description_that_urdfdom_reads(workspace, jobs, run_system):
    for name, job in jobs.items():
        package = ET.parse(workspace / "src" / name / "package.xml").getroot().findtext("name")
        launch = f"source devel/setup.bash && roslaunch {package} start.launch"
        nodes = run_system(f"{launch} --nodes", workspace).split()
        assert nodes == [f"/{package}/spawn", f"/{package}/robot_state_publisher"]
        stated = yaml.safe_load(run_system(f"{launch} --dump-params", workspace))
        assert stated["/use_sim_time"] and "uuv_underwater_current" in "".join(stated["/world"])
        description = workspace / f"{name}.urdf"
        description.write_text(stated[f"/{package}/robot_description"], encoding="utf-8")
        robot = ET.parse(description).getroot()
        mass = robot.find("link/inertial/mass")
        assert mass is not None and float(mass.get("value", "")) == pytest.approx(job.agent.mass.mass)
        for mesh in robot.iter("mesh"):
            assert Path(mesh.get("filename", "").removeprefix("file://")).is_file()
        assert "Successfully Parsed XML" in run_system(f"check_urdf {description}", workspace)


def test_roslaunch_reads_the_release(workspace, run_system):
    launch = "source devel/setup.bash && roslaunch skewed release.launch"
    assert run_system(f"{launch} --nodes", workspace).split() == ["/release"]
    [program, call, wait, service, state] = run_system(f"{launch} --args /release", workspace).split(" ", 4)
    assert Path(program).name == "rosservice" and (call, wait) == ("call", "--wait")
    assert service == "/gazebo/set_model_state"
    stated = yaml.safe_load(state.partition("__name")[0].strip().strip("'"))["model_state"]
    assert stated["twist"]["linear"] == {"x": 0.2, "y": 0.1, "z": -0.3}


@pytest.fixture(scope="module")
def environment(requires_program, system_environment):
    """The environment of ROS with a master that runs."""
    requires_program("roscore")
    with run_master(system_environment) as (found, _):
        yield found


def test_rospy_receives_every_message_of_a_bag_and_tf2_the_poses(environment, run_system, tmp_path):
    job, flight = RecorderContract().export_job(), drifting_trajectory()
    bag = tmp_path / "agent.bag"
    [file] = Rosbag1Recorder(FlightOptions()).write(job, flight, bag)
    expected = file.facts["topics"]
    info = yaml.safe_load(run_system(f"rosbag info --yaml {bag}", tmp_path))
    assert {t["topic"]: t["messages"] for t in info["topics"]} == expected
    assert info["duration"] == pytest.approx(flight.t[-1], abs=1e-6)
    topics = [f"{topic['topic']}:{topic['type']}" for topic in info["topics"]]
    times = [str(1 + t) for t in flight.t[:-1]]
    run_system("rosparam set /use_sim_time true", tmp_path, env=environment)
    options = ("--messages", str(sum(expected.values())), "--frames", "world", "agent/base_link", "--times", *times)
    # A player that has ended may take its last message with it.
    play = ("--quiet", "--keep-alive", "--wait-for-subscribers", "--queue", "10000", "--delay", "0.5", str(bag))
    with (
        listen(environment, *topics, *options) as finish,
        start("/usr/lib/rosbag/play", *play, cwd=tmp_path, env=environment),
    ):
        received = finish()
    assert received["counts"] == expected
    assert set(expected) >= {"/clock", "/tf", "/agent/markers", "/agent/range", "/agent/odom"}
    assert received["clock"] == pytest.approx(1 + flight.t[-1], abs=1e-6)
    poses = np.array(received["poses"])
    assert poses[:, :3] == pytest.approx(flight.position[:-1], abs=1e-6)
    assert np.abs((poses[:, 3:] * flight.quaternion[:-1]).sum(axis=1)) == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("joint", ["floating", "fixed"])
def test_robot_state_publisher_leaves_the_pose_of_the_agent_to_others(
    joint, environment, jobs, export, run_system, tmp_path
):
    """It publishes fixed joints, and no floating one."""
    text = (export("urdf", jobs["another"]) / "agent.urdf").read_text(encoding="utf-8")
    assert text.count('type="floating"') == 1
    description = tmp_path / "agent.urdf"
    description.write_text(text.replace('type="floating"', f'type="{joint}"'), encoding="utf-8")
    parsed = run_system(f"check_urdf {description}", tmp_path)
    assert "Successfully Parsed XML" in parsed and "child(1):  base_link" in parsed
    run_system("rosparam set /use_sim_time false", tmp_path, env=environment)
    run_system(f"rosparam set /robot_description --textfile {description}", tmp_path, env=environment)
    topic = "/tf_static:tf2_msgs/TFMessage"
    options = ("--messages", "1", "--frames", "world", "base_link")
    with start("/usr/lib/robot_state_publisher/robot_state_publisher", env=environment):
        # roscpp sends a latched message twice to a listener that joins while it is published: the second joins later.
        for _ in range(2):
            with listen(environment, topic, *options) as finish:
                received = finish()
    assert received["counts"] == {"/tf_static": 1}
    assert received["poses"] == ([None] if joint == "floating" else [[0, 0, 0, 1, 0, 0, 0]])
