"""The node of ROS 2 on a stand-in of rclpy, which is not in Debian: the calls are those of its documentation, and were not run."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from driftform.cli.app import app
from driftform_robotics.recording.messages import full_name, make_messages

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
COMMAND = ("ros", WORD, "--scenario", "paper", "--simulator", "native", "--rate", "0", "--once")


class Node:
    """What driftform asks of a node of rclpy: bytes are published, and a current comes with the third odometry."""

    def __init__(self, name):
        self.sent, self.qualities, self.clocks = {}, {}, [name]
        self.services, self.take = [], None
        self.declare_parameter = lambda name, value: None

    def get_publishers_info_by_topic(self, topic):
        return [SimpleNamespace(node_name=name) for name in self.clocks]

    def create_publisher(self, kind, topic, quality):
        self.qualities[topic] = quality
        store, kept = make_messages("jazzy").store, self.sent.setdefault(topic, [])

        def publish(message):
            kept.append(store.deserialize_cdr(message, kind))
            if topic == "agent/odom" and len(kept) == 3 and self.take:
                twist = SimpleNamespace(linear=SimpleNamespace(x=0.5, y=0.0, z=0.0))
                self.take(SimpleNamespace(header=SimpleNamespace(frame_id="world"), twist=twist))

        return SimpleNamespace(publish=publish)

    def create_subscription(self, kind, topic, take, depth):
        assert (kind, topic) == (full_name("geometry_msgs/TwistStamped"), "hydrodynamics/current_velocity")
        self.take = take

    def create_service(self, kind, name, respond):
        self.services.append(name)


@pytest.fixture
def ros2(monkeypatch):
    node = Node("driftform_agent")
    found = SimpleNamespace(node=node, arguments=None)

    def init(args, signal_handler_options):
        found.arguments = args

    none, ok = (lambda *_, **__: None), (lambda: True)
    modules = {
        "rclpy": {"init": init, "create_node": lambda name: node, "ok": ok, "spin": none, "try_shutdown": none},
        "rclpy.signals": {"SignalHandlerOptions": SimpleNamespace(NO=0)},
        "rclpy.qos": {
            "QoSProfile": lambda **given: given,
            "DurabilityPolicy": SimpleNamespace(TRANSIENT_LOCAL="latched", VOLATILE="volatile"),
        },
        "rclpy.time": {"Time": none},
        "tf2_ros": {"Buffer": none, "TransformListener": none, "TransformException": LookupError},
        "rosidl_runtime_py.utilities": {"get_message": lambda name: name},
        "std_srvs.srv": {"Trigger": None},
    }
    for name, members in modules.items():
        monkeypatch.setitem(sys.modules, name, module := ModuleType(name))
        vars(module).update(members)
    monkeypatch.setenv("ROS_VERSION", "2")
    monkeypatch.setenv("ROS_DISTRO", "jazzy")
    return found


def test_the_same_node_flies_in_ros_2_and_takes_remaps_and_currents(ros2):
    done = CliRunner().invoke(app, [*COMMAND, "--ros-args", "-r", "__ns:=/fleet"])
    assert done.exit_code == 0, done.output
    node = ros2.node
    assert ros2.arguments == ["--ros-args", "-r", "__ns:=/fleet"]
    odometry = node.sent["agent/odom"]
    stamps = [message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec for message in odometry]
    assert np.diff(stamps)[:-1] == pytest.approx(0.05)
    assert len(node.sent["/clock"]) == len(odometry) > 100
    assert node.qualities["agent/markers"] == {"depth": 1, "durability": "latched"}
    assert [message.twist.linear.x for message in node.sent["agent/current"]] == [0.5]
    assert node.services == ["agent/release", "agent/evaluate"]


def test_another_clock_is_refused_in_ros_2(ros2):
    ros2.node.clocks.append("gazebo")
    done = CliRunner().invoke(app, COMMAND)
    assert done.exit_code == 1
    [line] = done.stderr.splitlines()
    assert "driftform_agent, gazebo publish /clock" in line and "--no-clock" in line
