"""Bags and MCAP files, read back by code that has nothing in common with what wrote them.

MCAP files are read by the package mcap and decoded by mcap-ros2-support; a bag's database is read by sqlite3, and its
metadata as YAML. Both decode CDR by the message definitions in the file.
"""

import json
import sqlite3
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from ruamel.yaml import YAML

from driftform.motion.path.accelerations import accelerations_along, net_wrench
from driftform.plugins.registry import registry
from driftform.testing import RecorderContract
from driftform.testing.renderer import drifting_trajectory
from driftform.types import Trajectory
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Pipe, Scenario, Segment
from driftform_robotics import sensors
from driftform_robotics.options import FlightOptions, Ros2Options
from driftform_robotics.plume import make_plume
from driftform_robotics.recording.recorders import McapRecorder, Rosbag1Recorder, Rosbag2Recorder

KINDS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/agent/markers": "visualization_msgs/msg/MarkerArray",
    "/agent/path": "nav_msgs/msg/Path",
    "/agent/odom": "nav_msgs/msg/Odometry",
    "/agent/wrench": "geometry_msgs/msg/WrenchStamped",
    "/agent/imu": "sensor_msgs/msg/Imu",
    "/agent/pressure": "sensor_msgs/msg/FluidPressure",
    "/agent/range": "sensor_msgs/msg/Range",
    "/agent/clearance": "std_msgs/msg/Float64",
    "/agent/concentration": "std_msgs/msg/Float64",
}
ONCE = {"/tf_static", "/agent/markers", "/agent/path"}


RECORDERS = (McapRecorder(Ros2Options()), Rosbag1Recorder(FlightOptions()), Rosbag2Recorder(Ros2Options()))


class TestRecorders(RecorderContract):
    @pytest.fixture(autouse=True, params=RECORDERS, ids=lambda recorder: recorder.name)
    def _choose(self, request):
        self.chosen = request.param

    def plugin(self):
        return self.chosen


def test_each_recorder_is_found_by_its_name():
    assert all(type(registry().create("recorder", each.name, {})) is type(each) for each in RECORDERS)


@pytest.fixture(scope="module")
def job():
    return replace(RecorderContract().export_job(), document={"format": "driftform-agent", "word": "C"})


@pytest.fixture(scope="module")
def flight():
    return drifting_trajectory()


def messages(path):
    """Times and decoded messages of each topic of an MCAP file."""
    found = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found


@pytest.fixture(scope="module")
def read(job, flight, tmp_path_factory):
    path = tmp_path_factory.mktemp("mcap") / "agent.mcap"
    McapRecorder(Ros2Options(sensor=(0.02, 0.0, 0.01))).write(job, flight, path)
    return messages(path)


def times(flight, start=1.0):
    return [round((start + t) * 1e9) for t in flight.t]


def xyz(value):
    return [value.x, value.y, value.z]


def test_every_topic_has_its_messages_at_the_times_of_the_samples(read, flight):
    assert set(read) == set(KINDS)
    for topic, found in read.items():
        stamps = [stamp for stamp, _ in found]
        expected = times(flight)[:1] if topic in ONCE else times(flight)
        assert np.abs(np.subtract(stamps, expected)).max() <= 1, topic
        for stamp, message in found:
            if hasattr(message, "header"):
                assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp


def test_poses_and_velocities_are_those_of_the_flight(read, flight):
    for i, (_, odometry) in enumerate(read["/agent/odom"]):
        assert odometry.header.frame_id == "world" and odometry.child_frame_id == "agent/base_link"
        assert xyz(odometry.pose.pose.position) == list(flight.position[i])
        turned = odometry.pose.pose.orientation
        assert [turned.w, *xyz(turned)] == list(flight.quaternion[i])
        assert [*xyz(odometry.twist.twist.linear), *xyz(odometry.twist.twist.angular)] == list(flight.velocity[i])
    for (_, moved), (_, odometry) in zip(read["/tf"], read["/agent/odom"], strict=True):
        [transform] = moved.transforms
        assert (transform.header.frame_id, transform.child_frame_id) == ("world", "agent/base_link")
        assert xyz(transform.transform.translation) == xyz(odometry.pose.pose.position)
        assert transform.transform.rotation.w == odometry.pose.pose.orientation.w


@pytest.mark.parametrize("rep105", [False, True])
def test_every_frame_that_a_message_names_hangs_on_the_world_or_on_the_map_by_way_of_the_odometry(
    rep105, job, flight, tmp_path
):
    McapRecorder(Ros2Options(rep105=rep105)).write(job, flight, tmp_path / "agent.mcap")
    read = messages(tmp_path / "agent.mcap")
    world, parent = ("map", "agent/odom") if rep105 else ("world", "world")
    parents = {
        t.child_frame_id: t.header.frame_id
        for topic in ("/tf", "/tf_static")
        for _, message in read[topic]
        for t in message.transforms
    }
    [(_, markers)] = read["/agent/markers"]
    headers = [marker.header for marker in markers.markers]
    headers += [m.header for found in read.values() for _, m in found if hasattr(m, "header")]
    for frame in {header.frame_id for header in headers}:
        while frame != world:
            frame = parents[frame]  # noqa: PLW2901
    assert parents["agent/base_link"] == parent == read["/agent/odom"][0][1].header.frame_id


def test_the_wrench_is_that_of_newton_and_euler(read, job, flight):
    moved_by = accelerations_along(flight, job.agent, job.scenario)
    wrench = net_wrench(flight, moved_by, job.agent.mass)
    found = [[*xyz(m.wrench.force), *xyz(m.wrench.torque)] for _, m in read["/agent/wrench"]]
    assert np.array_equal(found, wrench)
    assert {m.header.frame_id for _, m in read["/agent/wrench"]} == {"agent/cog"}


def test_sensors_read_what_their_functions_say(read, job, flight):
    point, scenario = np.array([0.02, 0.0, 0.01]), job.scenario
    there = sensors.point_positions(flight, point)
    moved_by = accelerations_along(flight, job.agent, scenario)
    force = sensors.specific_force(flight, moved_by, point, scenario.fluid.gravity)
    assert [xyz(m.linear_acceleration) for _, m in read["/agent/imu"]] == force.tolist()
    assert [xyz(m.angular_velocity) for _, m in read["/agent/imu"]] == flight.velocity[:, 3:].tolist()
    depth = 1.0 - there[:, 2]
    assert [m.fluid_pressure for _, m in read["/agent/pressure"]] == pytest.approx(101_325 + 1024 * 9.81 * depth)
    assert [m.range for _, m in read["/agent/range"]] == pytest.approx(
        1.0 - np.hypot(there[:, 1], there[:, 2]), rel=1e-6
    )
    plume = make_plume(scenario, scenario.targets["leak"], 0.001)
    assert [m.data for _, m in read["/agent/concentration"]] == plume.concentration(there).tolist()


def test_markers_show_the_pipe_the_targets_and_the_agent(read, job):
    [(_, message)] = read["/agent/markers"]
    by_group = {marker.ns: marker for marker in message.markers}
    assert set(by_group) == {"pipe", "targets", "names", "agent"}
    assert len({marker.id for marker in message.markers}) == len(message.markers)
    pipe, target, agent = by_group["pipe"], by_group["targets"], by_group["agent"]
    turned = pipe.pose.orientation
    assert matrix_from_quaternion(np.array([turned.w, *xyz(turned)])) @ [0, 0, 1] == pytest.approx([1, 0, 0])
    assert xyz(pipe.pose.position) == [4.5, 0.0, 0.0] and xyz(pipe.scale) == pytest.approx([2.0, 2.0, 9.0])
    assert xyz(target.pose.position) == [0.1, 0.0, -1.0] and by_group["names"].text == "leak"
    corners = np.array([xyz(point) for point in agent.points]).reshape(-1, 3, 3)
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(job.agent.mass.volume, rel=1e-6)
    assert agent.header.frame_id == "agent/base_link" and agent.frame_locked


def test_a_database_holds_the_same_bytes_as_the_mcap_file(job, flight, tmp_path):
    options = Ros2Options()
    folder, file = tmp_path / "agent-rosbag2", tmp_path / "agent.mcap"
    Rosbag2Recorder(options).write(job, flight, folder)
    McapRecorder(Ros2Options()).write(job, flight, file)
    with sqlite3.connect(f"file:{folder / 'agent-rosbag2.db3'}?mode=ro", uri=True) as database:
        topics = {i: (name, kind) for i, name, kind in database.execute("SELECT id, name, type FROM topics")}
        rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp").fetchall()
        definitions = dict(database.execute("SELECT topic_type, encoded_message_definition FROM message_definitions"))
    database.close()
    assert dict(topics.values()) == KINDS
    with file.open("rb") as stream:
        other = Counter(
            (channel.topic, message.log_time, message.data)
            for _, channel, message in make_reader(stream).iter_messages()
        )
    assert Counter((topics[topic][0], stamp, data) for topic, stamp, data in rows) == other
    # The messages are decoded by the definitions in the database itself.
    odometry = [(stamp, data) for topic, stamp, data in rows if topics[topic][0] == "/agent/odom"]
    text = definitions["nav_msgs/msg/Odometry"].encode()
    decode = DecoderFactory().decoder_for("cdr", Schema(1, text, "ros2msg", "nav_msgs/msg/Odometry"))
    places = [xyz(decode(data).pose.pose.position) for _, data in odometry]
    assert np.array_equal(places, flight.position)


def test_the_metadata_of_a_bag_describes_its_contents(job, flight, tmp_path):
    folder = tmp_path / "agent-rosbag2"
    written = Rosbag2Recorder(Ros2Options()).write(job, flight, folder)
    metadata = YAML(typ="safe").load(folder / "metadata.yaml")["rosbag2_bagfile_information"]
    assert metadata["storage_identifier"] == "sqlite3"
    assert metadata["duration"]["nanoseconds"] == pytest.approx(flight.t[-1] * 1e9, abs=1)
    assert metadata["starting_time"]["nanoseconds_since_epoch"] == 10**9
    topics = {t["topic_metadata"]["name"]: t for t in metadata["topics_with_message_count"]}
    assert {name: t["topic_metadata"]["type"] for name, t in topics.items()} == KINDS
    assert {name: t["message_count"] for name, t in topics.items()} == {
        name: 1 if name in ONCE else len(flight.t) for name in KINDS
    }
    for name, topic in topics.items():
        [quality] = YAML(typ="safe").load(topic["topic_metadata"]["offered_qos_profiles"])
        # 1 is "transient local" and 2 "volatile" in the numbers of ROS.
        assert quality["durability"] == (1 if name in ONCE else 2), name
    assert [(folder / name).is_file() for name in metadata["relative_file_paths"]] == [True]
    assert json.loads(metadata["custom_data"]["document"]) == job.document
    facts = [file.facts for file in written if file.facts]
    assert [fact["messages"] for fact in facts] == [metadata["message_count"]]


def test_topics_without_data_are_left_out(job, flight, tmp_path):
    path = tmp_path / "agent.mcap"
    McapRecorder(Ros2Options()).write(replace(job, scenario=Scenario()), flight, path)
    missing = {"/agent/range", "/agent/clearance", "/agent/concentration"}
    assert set(messages(path)) == set(KINDS) - missing
    inside = job.scenario.model_copy(update={"targets": {"middle": (0.1, 0.0, 0.0)}})
    McapRecorder(Ros2Options()).write(replace(job, scenario=inside), flight, path)
    assert set(messages(path)) == set(KINDS) - {"/agent/concentration"}


def test_the_name_of_the_agent_can_be_chosen(job, flight, tmp_path):
    path = tmp_path / "agent.mcap"
    McapRecorder(Ros2Options(namespace="diver", start=5.0)).write(job, flight, path)
    found = messages(path)
    assert set(found) == {topic.replace("/agent/", "/diver/") for topic in KINDS}
    assert found["/tf"][0][0] == 5 * 10**9
    assert found["/tf"][0][1].transforms[0].child_frame_id == "diver/base_link"


def test_noise_is_as_large_as_asked_for_and_comes_again_with_its_seed(job, flight, tmp_path):
    def pressures(name, **options):
        path = tmp_path / name
        McapRecorder(Ros2Options(**options)).write(job, long, path)
        return np.array([m.fluid_pressure for _, m in messages(path)["/agent/pressure"]])

    t = np.linspace(0, 0.4, 200)
    long = Trajectory(t, np.zeros((200, 3)), np.tile([1.0, 0, 0, 0], (200, 1)), np.zeros((200, 6)), flight.end)
    clean, noisy = pressures("clean.mcap"), pressures("noisy.mcap", pressure_noise=30.0)
    assert np.std(noisy - clean) == pytest.approx(30, rel=0.25)
    assert np.mean(noisy - clean) == pytest.approx(0, abs=9)
    assert np.array_equal(noisy, pressures("again.mcap", pressure_noise=30.0))
    assert not np.array_equal(noisy, pressures("other.mcap", pressure_noise=30.0, seed=1))


@pytest.mark.parametrize("release", ["humble", "kilted", "lyrical"])
def test_other_releases_have_their_own_definitions(release, job, flight, tmp_path):
    path = tmp_path / "agent.mcap"
    McapRecorder(Ros2Options(release=release)).write(job, flight, path)
    _, first = messages(path)["/agent/range"][0]
    # The message Range has had a variance since Iron.
    assert hasattr(first, "variance") == (release != "humble")


def test_a_tilted_pipe_is_drawn_as_it_lies(job, flight, tmp_path):
    path, start, end = tmp_path / "agent.mcap", (1.0, 2.0, 3.0), (2.0, 4.0, 1.0)
    pipe = Pipe(segments=(Segment(start=start, end=end, radius=0.5),))
    tilted = Scenario(pipe=pipe)
    McapRecorder(Ros2Options()).write(replace(job, scenario=tilted), flight, path)
    [(_, message)] = messages(path)["/agent/markers"]
    drawn = next(marker for marker in message.markers if marker.ns == "pipe")
    turned = drawn.pose.orientation
    axis = matrix_from_quaternion(np.array([turned.w, *xyz(turned)])) @ [0, 0, 1]
    assert axis == pytest.approx(np.array([1, 2, -2]) / 3)
    assert drawn.scale.z == pytest.approx(3.0)
