"""A live flight on a real roscore: every message arrives, currents act, services answer, and it ends cleanly."""

import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from json import loads
from pathlib import Path

import numpy as np
import pytest
import yaml
from ros1 import run_master, start

import driftform as df
import driftform_ros
from driftform.util.files import cache_folder
from driftform.util.rotations import matrix_from_quaternion

PROGRAMS = Path(__file__).parent / "programs"
WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
STAMPED = ("/clock", "/tf", "/agent/odom", "/agent/wrench", "/agent/imu", "/agent/pressure", "/agent/range")
PROGRAM = (sys.executable, "-c", "from driftform.cli import main; main()")
OPTIONS = ("--scenario", "paper", "--simulator", "native", "--set", "release.pitch_deg=20")
COMMAND = (*PROGRAM, "ros", WORD, *OPTIONS)
START = 1.0
"""Time of the clock at the release, s."""


@pytest.fixture(scope="session")
def system(tmp_path_factory):
    """The environment of programs of the system; without ROS the test is skipped."""
    if shutil.which("roscore") is None:
        pytest.skip("roscore is not installed")
    home = tmp_path_factory.mktemp("home")
    return {"PATH": "/usr/bin:/bin", "HOME": str(home), "ROS_HOME": str(home), "LC_ALL": "C.UTF-8"}


@pytest.fixture(scope="module")
def master(system):
    with run_master(system) as (found, _):
        yield found


@contextmanager
def fly(environment, *words):
    """The command, in the environment of the tests with the master of a system's; it has said that the agent flies."""
    with start(*COMMAND, *words, env=environment_of(environment), stderr=subprocess.PIPE) as process:
        line = process.stdout.readline()
        assert "flies at http://localhost" in line, process.communicate(timeout=600)
        yield process


def environment_of(system):
    return os.environ | {key: system[key] for key in ("ROS_MASTER_URI", "ROS_HOME")}


@pytest.fixture(scope="module", autouse=True)
def kernels(master):
    """Compile what the command needs, so that none of the tests' commands says that it compiles."""
    with fly(master):
        pass


@contextmanager
def follow(environment, *words):
    with start("/usr/bin/python3", str(PROGRAMS / "follow.py"), *words, env=environment) as process:
        assert process.stdout.readline() == "ready\n"
        yield process


def read(process):
    return loads(process.communicate(timeout=90)[0])


def call(environment, command):
    done = subprocess.run(
        ["bash", "-c", command], env=environment, capture_output=True, encoding="utf-8", timeout=600, check=True
    )
    return yaml.safe_load(done.stdout) or {}


@contextmanager
def launch(environment, *words):
    """roslaunch of the shipped launch file, which has told that the agent flies."""
    path = f"{Path(sys.executable).parent}:{environment['PATH']}"
    own = environment | {
        "ROS_PACKAGE_PATH": driftform_ros.__path__[0],
        "DRIFTFORM_CACHE": str(cache_folder()),
        "PATH": path,
    }
    words = (f"agent:={WORD}", f"options:={' '.join(OPTIONS)}", *words)
    roslaunch = ("/usr/bin/python3", "/usr/bin/roslaunch", "driftform_ros", "live.launch", *words)
    with start(*roslaunch, env=own, stderr=subprocess.STDOUT) as process:
        assert any(" flies at http://localhost" in line for line in process.stdout)
        yield process
    call(environment, "rosparam delete /use_sim_time")


def test_every_message_of_a_launched_flight_arrives_in_real_time_and_a_remapped_current_acts(master):
    with (
        follow(master, "5.0", "4.5", "0.6", "0", "0", "/flow/velocity") as listener,
        launch(master, "name:=flyer", "current:=/flow/velocity") as process,
    ):
        begun = time.monotonic()
        assert "/flyer" in str(call(master, "rosnode list"))
        found = read(listener)
        # The flight began a moment before the command said so; under load the listener is late.
        assert 3.0 < time.monotonic() - begun < 15.0
        assert process.poll() is None
    assert found["currents"] == [[0.6, 0.0, 0.0]]
    expected = START + 0.05 * np.arange(101)
    for topic in STAMPED:
        assert np.array(found["stamps"][topic][:101]) == pytest.approx(expected, abs=1e-6), topic
    # It has no stamps; the listener may stop between two topics of one step.
    assert abs(len(found["stamps"]["/agent/clearance"]) - len(found["stamps"]["/agent/odom"])) <= 1
    assert set(found["markers"]) == {"pipe", "targets", "names", "agent"}
    whole = design_of().trace()
    x = np.interp(expected - START, whole.t, whole.position[:, 0])
    assert np.array(found["places"])[:90, 0] == pytest.approx(x[:90], abs=1e-3)


def test_two_nodes_share_one_clock_that_goes_on_after_a_flight_and_never_back(master):
    """A second clock is refused; a node that follows the first begins at its time."""
    other = ("--set", "recorder.rosbag1.namespace=other")
    with fly(master), follow(master, "10.0") as listener:
        system = environment_of(master)
        refused = subprocess.run((*COMMAND, *other), env=system, capture_output=True, encoding="utf-8", check=False)
        assert refused.returncode == 1
        [line] = split_lines(refused.stderr)
        assert line.startswith("error: /driftform_agent publishes /clock") and "--no-clock" in line
        with fly(master, *other, "--no-clock"):
            found = read(listener)
    clock = np.array(found["stamps"]["/clock"])
    assert np.diff(clock).min() > 0
    assert clock[-1] > START + 10 > found["stamps"]["/agent/odom"][-1]
    # Both agents are in one tree of transforms, at times of one clock.
    assert max(found["stamps"]["/tf"]) > START + 5
    assert np.diff(found["stamps"]["/tf"]).min() > -0.5


@pytest.mark.parametrize(("frame", "speed"), [("agent/base_link", "0.4"), ("world_ned", "0.4"), ("", "99")])
def test_a_current_in_the_frame_of_the_agent_is_turned_and_one_that_cannot_be_is_refused(master, frame, speed):
    words = ("1.0", "0.2", speed, "0", "0", "hydrodynamics/current_velocity", frame)
    with follow(master, *words) as listener, fly(master) as process:
        found = read(listener)
        process.send_signal(signal.SIGINT)
        lines = split_lines(process.communicate(timeout=60)[1])
    if frame == "agent/base_link":
        [current] = found["currents"]
        flown = design_of().trace()
        # tf may be some steps late.
        axes = matrix_from_quaternion(flown.quaternion[flown.t < found["stamps"]["/agent/current"][0] - START])[..., 0]
        assert np.abs(0.4 * axes - current).max(axis=1).min() < 0.01
        assert np.linalg.norm(current) == pytest.approx(0.4)
        assert abs(current[2]) > 0.01
    else:
        assert found["currents"] == []
        assert lines[0].startswith("warning: a current ") and ("world_ned" in lines[0] or "at most 20 m/s" in lines[0])


def design_of(*settings):
    given = ("release.pitch_deg=20", *settings)
    return df.open_agent(WORD, *given, scenario="paper")


def test_a_current_that_arrives_in_flight_moves_the_agent_as_one_that_changes_then(master):
    current = (0.6, 0.1, -0.05)
    with follow(master, "4.0", "2.0", *map(str, current)) as listener, fly(master):
        found = read(listener)
    [changed] = found["stamps"]["/agent/current"]
    assert 2.0 <= changed - START < 2.5
    flight = design_of().fly()
    flight.step(changed - START)
    path = flight.step(4.5 - (changed - START), current=current)
    times = np.array(found["stamps"]["/agent/odom"]) - START
    # A listener under load may hear more than it waits for.
    after = (times > changed - START) & (times < 4.5)
    assert after.sum() > 30
    undisturbed = design_of().trace()

    def find_largest(t, places):
        expected = np.column_stack([np.interp(times[after], t, axis) for axis in places.T])
        return float(np.linalg.norm(np.array(found["places"])[after] - expected, axis=1).max())

    assert find_largest(path.t, path.position) < 0.005
    assert find_largest(undisturbed.t, undisturbed.position) > 0.15


def test_services_evaluate_and_release_what_the_parameter_names(master, tmp_path):
    with fly(master, "--rate", "0") as process:
        assert "ends after" in process.stdout.readline()
        own = call(master, "rosservice call /agent/evaluate")
        assert own["success"] and loads(own["message"])["fitness"] == pytest.approx(
            dict(design_of().simulate().fitness)
        )
        call(master, "rosparam set /agent/agent 'addF-tiltn-1-S-moveF'")
        other = call(master, "rosservice call /agent/evaluate")
        assert other["success"] and loads(other["message"])["fitness"] != loads(own["message"])["fitness"]
        released = call(master, "rosservice call /agent/release")
        assert released["success"], released
        # The clock goes on.
        assert float(released["message"].split()[-2]) > START + 5
        assert "ends after" in process.stdout.readline()
        call(master, "rosparam set /agent/agent nonsense")
        for service in ("evaluate", "release"):
            answer = call(master, f"rosservice call /agent/{service}")
            assert not answer["success"] and "nonsense" in answer["message"]
        call(master, "rosparam delete /agent/agent")


def test_it_ends_with_its_flight_if_asked(master):
    with fly(master, "--rate", "0", "--once") as process:
        stdout, stderr = process.communicate(timeout=600)
    assert process.returncode == 0 and not stderr
    assert "outlet" in stdout and len(stdout.splitlines()) == 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_in_one_line_and_leaves_nothing(master, number):
    with fly(master) as process:
        assert "use_sim_time" in str(call(master, "rosparam list"))
        process.send_signal(number)
        seconds = wait_for_end(process)
        _, stderr = process.communicate()
    assert seconds < 60.0
    assert (process.returncode, split_lines(stderr)) == (130, ["interrupted"])
    assert "driftform" not in str(call(master, "rosnode list"))
    assert "use_sim_time" not in str(call(master, "rosparam list"))


def test_it_ends_soon_after_roscore_in_one_line(system):
    with run_master(system) as (environment, core), fly(environment) as process:
        time.sleep(0.5)
        children = Path(f"/proc/{core.pid}/task/{core.pid}/children").read_text(encoding="utf-8").split()
        for pid in (*map(int, children), core.pid):
            os.kill(pid, signal.SIGKILL)
        seconds = wait_for_end(process)
        _, stderr = process.communicate()
    assert process.returncode == 1
    [line] = split_lines(stderr)
    assert "roscore" in line and "does not answer" in line
    assert seconds < 60.0


def wait_for_end(process):
    """Return how long a process takes to end, s, without the time in which it waits for a processor."""
    begun, before, waited = time.monotonic(), find_waiting(process.pid), 0.0
    while process.poll() is None:
        waited = max(waited, find_waiting(process.pid) - before)
        assert time.monotonic() - begun < 120.0
        time.sleep(0.02)
    return time.monotonic() - begun - waited


def split_lines(stderr):
    """The lines of an output, without the warning of a flight that is late, as on a busy machine."""
    return [line for line in stderr.splitlines() if not line.startswith("warning: the flight is ")]


def find_waiting(pid):
    """How long the threads of a process have waited for a processor, which others held, s."""
    found = 0
    for path in Path(f"/proc/{pid}/task").glob("*/schedstat"):
        # A thread may end meanwhile.
        with suppress(OSError):
            found += int(path.read_text(encoding="ascii").split()[1])
    return 1e-9 * found


def test_without_roscore_it_says_what_to_start(refused_master):
    command = (*PROGRAM, "ros", WORD)
    done = subprocess.run(command, env=refused_master, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 1
    [line] = done.stderr.splitlines()
    assert "no roscore answers" in line and "start roscore" in line
    assert not done.stdout


@pytest.fixture
def refused_master(system):
    return os.environ | {"ROS_MASTER_URI": "http://localhost:9", "ROS_HOME": system["ROS_HOME"]}
