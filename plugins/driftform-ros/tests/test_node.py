"""A live flight on a bus that keeps every message: what does not need ROS."""

import math
import threading
import time
from collections import defaultdict

import numpy as np
import pytest

import driftform as df
from driftform.errors import WorkFailedError
from driftform.types import End
from driftform_robotics.options import FlightOptions
from driftform_robotics.recording.messages import full_name, make_messages
from driftform_ros.node import LiveNode
from driftform_ros.rospy_bus import RospyBus

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


def make_design(*settings):
    given = ("release.pitch_deg=20", *settings)
    return df.open_agent(WORD, *given, scenario="paper")


class MemoryBus(RospyBus):
    """ROS that ends after some messages of the odometry."""

    def __init__(self, odometries, has_clock=True, parameter=None):
        self.address, self.left, self.has_clock, self.parameter = "memory", odometries, has_clock, parameter
        self.lost, self.ros = "memory does not answer", make_messages(None)
        self.kinds = {}
        self.messages = defaultdict(list)
        self.services = {}
        self.take = lambda _: None
        self.acts = {}

    def advertise(self, topic, kind, latched):
        self.kinds[topic] = kind

    def publish(self, topic, message):
        self.messages[topic].append(self.ros.store.deserialize_ros1(message, full_name(self.kinds[topic])))
        if topic == "agent/odom":
            self.left -= 1
            self.acts.pop(len(self.messages[topic]), lambda: None)()

    def check_clock(self):
        pass

    def receive_currents(self, world, take):
        self.take = take

    def serve(self, name, answer):
        self.services[name] = answer

    def read_parameter(self, name):
        return self.parameter

    def read_time(self):
        return 500.0

    def is_alive(self):
        return self.left > 0


def run(bus, design, *, once=False, **options):
    node = LiveNode(bus, make_design, FlightOptions(**options), 0.05, 0.0, 20.0)
    if once:
        node.run(design, once)
        return
    with pytest.raises(WorkFailedError, match="memory does not answer"):
        node.run(design, once)


def stamps_of(bus, topic):
    stamps = [message.header.stamp for message in bus.messages[topic]]
    return np.array([stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps])


@pytest.fixture(scope="module")
def design():
    yield make_design()


def test_without_a_clock_of_its_own_it_begins_at_the_time_of_ros(design):
    bus = MemoryBus(5, has_clock=False)
    run(bus, design)
    assert "/clock" not in bus.kinds
    assert stamps_of(bus, "agent/odom") == pytest.approx(500 + 0.05 * np.arange(5))
    bus = MemoryBus(5)
    run(bus, design, start=3.0)
    assert len(bus.messages["/clock"]) == 5
    assert stamps_of(bus, "agent/odom")[0] == pytest.approx(3.0)


def test_each_reading_has_noise_of_its_own(design):
    noisy, exact = MemoryBus(60), MemoryBus(60)
    run(noisy, design, pressure_noise=10.0)
    run(exact, design)
    noise = np.array([a.fluid_pressure for a in noisy.messages["agent/pressure"]]) - [
        b.fluid_pressure for b in exact.messages["agent/pressure"]
    ]
    assert noise.std() == pytest.approx(10.0, rel=0.4)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.4


def test_the_same_current_again_changes_nothing_and_one_that_is_no_number_is_ignored(design, capsys):
    bus = MemoryBus(8)
    bus.acts = {
        2: lambda: bus.take((0.5, 0.0, 0.0)),
        4: lambda: bus.take((0.5, 0.0, 0.0)),
        6: lambda: bus.take((math.nan, 0.0, 0.0)),
        7: lambda: bus.take((1e3, 0.0, 0.0)),
    }
    run(bus, design)
    [message] = bus.messages["agent/current"]
    assert message.twist.linear.x == 0.5
    assert message.header.frame_id == "world"
    assert stamps_of(bus, "agent/current") == pytest.approx([1.05])
    assert len(capsys.readouterr().err.splitlines()) == 2


def test_a_release_that_is_refused_leaves_the_flight_alone(design):
    bus = MemoryBus(170, parameter="flow.kind=turbulent")
    answers = []

    def ask():
        answers.append(bus.services["agent/release"]())

    bus.acts = {3: threading.Thread(target=ask).start, 150: lambda: time.sleep(0.5)}
    run(bus, design)
    [(success, message)] = answers
    assert not success and "gusts" in message and "\n" not in message
    assert np.diff(stamps_of(bus, "agent/odom")) == pytest.approx(0.05)


def test_a_flight_that_fails_is_an_error_if_it_is_the_only_one(design, monkeypatch):
    other = make_design()
    step = other.pipeline.simulator.step

    def fail(agent, scenario, flown, duration):
        found = step(agent, scenario, flown, duration)
        object.__setattr__(found, "end", End.NON_FINITE if flown.t[-1] > 0.1 else found.end)
        return found

    monkeypatch.setattr(type(other.pipeline.simulator), "step", staticmethod(fail))
    with pytest.raises(WorkFailedError, match="ended after"):
        run(MemoryBus(10**6), other, once=True)
