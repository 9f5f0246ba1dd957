"""A flight as topics: the messages, their frames and their times."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from driftform.interfaces import ExportJob
from driftform.motion import path
from driftform.types import FloatArray, Trajectory
from driftform.water import Scenario, field
from driftform_robotics import sensors
from driftform_robotics.models.meshes import revolve_contour
from driftform_robotics.models.pipe import list_bores
from driftform_robotics.options import FlightOptions
from driftform_robotics.plume import Plume, make_plume
from driftform_robotics.recording.messages import SECOND

ON_WALL = 0.01
"""Largest distance of a leak from the wall, relative to the bore's radius: such targets are leaks."""

SEGMENTS = 24
"""Corners of the circles of the agent's marker."""

GREY, ORANGE, VERMILLION = (0.6, 0.65, 0.7, 0.15), (0.9, 0.6, 0.0, 1.0), (0.84, 0.37, 0.0, 0.9)


CYLINDER, SPHERE, TEXT, TRIANGLES = 3, 2, 9, 11
"""Types of markers, as ``visualization_msgs/Marker`` has them."""

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
"""No rotation, in the order of ROS: x, y, z, w."""

Values: TypeAlias = dict[str, Any]
"""Fields of a message; see :meth:`~driftform_robotics.recording.messages.Messages.encode`."""


@dataclass(frozen=True, eq=False)
class Topic:
    """A topic: its ``name``, the ``kind`` of its messages, and a function that yields times in ns and ``messages``.

    Later subscribers also receive the last message of a ``latched`` topic.
    """

    name: str
    kind: str
    messages: Callable[[], Iterator[tuple[int, Values]]]
    latched: bool = False


class FlightTopics:
    """All topics of one flight, or of a ``part`` of it, which has its own noise.

    ``plumes`` are by default those of the targets on the wall.
    """

    def __init__(
        self,
        job: ExportJob,
        trajectory: Trajectory,
        options: FlightOptions,
        part: int = 0,
        plumes: list[Plume] | None = None,
    ) -> None:
        self.job, self.trajectory, self.options, self.part = job, trajectory, options, part
        self.plumes = list_plumes(job.scenario, options) if plumes is None else plumes
        self.stamps = [round(options.start * SECOND) + round(float(t) * SECOND) for t in trajectory.t]
        self.turns = np.roll(trajectory.quaternion, -1, axis=1)
        self.world, self.base = options.world, f"{options.namespace}/base_link"
        # By REP 105 the pose is in a frame of the agent's own, which is where the map is.
        self.parent = f"{options.namespace}/odom" if options.rep105 else self.world

    def list_topics(self) -> list[Topic]:
        """Return the topics that have messages."""
        name = self.options.namespace
        found = [
            Topic("/clock", "rosgraph_msgs/Clock", self._make_clock),
            Topic("/tf_static", "tf2_msgs/TFMessage", self._make_static_tf, latched=True),
            Topic("/tf", "tf2_msgs/TFMessage", self._make_tf),
            Topic(f"/{name}/markers", "visualization_msgs/MarkerArray", self._make_markers, latched=True),
            Topic(f"/{name}/path", "nav_msgs/Path", self._make_path, latched=True),
            Topic(f"/{name}/odom", "nav_msgs/Odometry", self._make_odometry),
            Topic(f"/{name}/wrench", "geometry_msgs/WrenchStamped", self._make_wrenches),
            Topic(f"/{name}/imu", "sensor_msgs/Imu", self._make_imu),
            Topic(f"/{name}/pressure", "sensor_msgs/FluidPressure", self._make_pressures),
        ]
        if self.job.scenario.pipe.straight is not None:
            found += [
                Topic(f"/{name}/range", "sensor_msgs/Range", self._make_ranges),
                Topic(f"/{name}/clearance", "std_msgs/Float64", self._make_clearances),
            ]
        if self.plumes:
            found.append(Topic(f"/{name}/concentration", "std_msgs/Float64", self._make_concentrations))
        return found

    @cached_property
    def accelerations(self) -> FloatArray:
        """Accelerations by the equations of motion, (k, 6)."""
        return path.accelerations_along(self.trajectory, self.job.agent, self.job.scenario)

    @cached_property
    def sensor_positions(self) -> FloatArray:
        """Positions of the sensors, world frame, m, (k, 3)."""
        return sensors.point_positions(self.trajectory, np.array(self.options.sensor))

    def _make_rng(self, sensor: int) -> np.random.Generator:
        # The noise of a sensor does not depend on the other sensors.
        return np.random.default_rng((self.options.seed, sensor, self.part))

    def _list_poses(self) -> Iterator[tuple[int, FloatArray, FloatArray]]:
        return zip(self.stamps, self.trajectory.position, self.turns, strict=True)

    def _make_clock(self) -> Iterator[tuple[int, Values]]:
        for stamp in self.stamps:
            yield stamp, {"clock": divmod(stamp, SECOND)}

    def _make_tf(self) -> Iterator[tuple[int, Values]]:
        for stamp, place, turned in self._list_poses():
            yield stamp, {"transforms": [make_transform(stamp, self.parent, self.base, place, turned)]}

    def _make_static_tf(self) -> Iterator[tuple[int, Values]]:
        mass, stamp = self.job.agent.mass, self.stamps[0]
        points = {"cog": mass.cog, "cob": mass.cob, "sensors": np.array(self.options.sensor)}
        fixed = [
            make_transform(stamp, self.base, f"{self.options.namespace}/{name}", point, LEVEL)
            for name, point in points.items()
        ]
        if self.parent != self.world:
            fixed.append(make_transform(stamp, self.world, self.parent, np.zeros(3), LEVEL))
        yield stamp, {"transforms": fixed}

    def _make_odometry(self) -> Iterator[tuple[int, Values]]:
        for (stamp, *pose), velocity in zip(self._list_poses(), self.trajectory.velocity, strict=True):
            yield (
                stamp,
                {
                    "header": make_header(stamp, self.parent),
                    "child_frame_id": self.base,
                    "pose": {"pose": pose},
                    "twist": {"twist": np.split(velocity, 2)},
                },
            )

    def _make_path(self) -> Iterator[tuple[int, Values]]:
        poses = [{"header": make_header(stamp, self.parent), "pose": pose} for stamp, *pose in self._list_poses()]
        yield self.stamps[0], {"header": make_header(self.stamps[0], self.parent), "poses": poses}

    def _make_wrenches(self) -> Iterator[tuple[int, Values]]:
        found = path.net_wrench(self.trajectory, self.accelerations, self.job.agent.mass)
        for stamp, values in zip(self.stamps, found, strict=True):
            yield stamp, {"header": make_header(stamp, f"{self.options.namespace}/cog"), "wrench": np.split(values, 2)}

    def _make_imu(self) -> Iterator[tuple[int, Values]]:
        options, rng = self.options, self._make_rng(0)
        gravity = self.job.scenario.fluid.gravity
        force = sensors.specific_force(self.trajectory, self.accelerations, np.array(options.sensor), gravity)
        force = sensors.add_noise(force, options.acceleration_noise, rng)
        rates = sensors.add_noise(self.trajectory.velocity[:, 3:], options.rate_noise, rng)
        covariances = {
            "linear_acceleration_covariance": (options.acceleration_noise**2 * np.eye(3)).ravel(),
            "angular_velocity_covariance": (options.rate_noise**2 * np.eye(3)).ravel(),
        }
        for stamp, turned, f, w in zip(self.stamps, self.turns, force, rates, strict=True):
            given = {"orientation": turned, "angular_velocity": w, "linear_acceleration": f}
            yield stamp, {"header": self._make_sensor_header(stamp), **given, **covariances}

    def _make_pressures(self) -> Iterator[tuple[int, Values]]:
        scenario, options = self.job.scenario, self.options
        surface = sensors.surface_height(scenario)
        found = sensors.pressure(self.sensor_positions[:, 2], surface, scenario.fluid, options.atmosphere)
        return self._make_readings("fluid_pressure", found, options.pressure_noise, 1)

    def _make_ranges(self) -> Iterator[tuple[int, Values]]:
        scenario, noise = self.job.scenario, self.options.distance_noise
        found = np.maximum(field.wall_distance(self.sensor_positions, scenario), 0.0)
        # All directions: the distance is that of the nearest point of the wall.
        seen = {"field_of_view": 2 * np.pi, "max_range": scenario.pipe.layout.inlet.radius}
        return self._make_readings("range", found, noise, 2, **seen)

    def _make_clearances(self) -> Iterator[tuple[int, Values]]:
        found = path.wall_clearances(self.trajectory, self.job.scenario, self.job.agent)
        return self._make_readings("data", found, self.options.distance_noise, 3)

    def _make_concentrations(self) -> Iterator[tuple[int, Values]]:
        found = np.sum([plume.concentration(self.sensor_positions) for plume in self.plumes], axis=0)
        return self._make_readings("data", found, self.options.concentration_noise, 4)

    def _make_readings(
        self, field: str, values: FloatArray, noise: float, sensor: int, **more: float
    ) -> Iterator[tuple[int, Values]]:
        """Yield a reading with noise in a ``field`` of each message, with a header and its variance if the kind has them."""
        readings = sensors.add_noise(values, noise, self._make_rng(sensor))
        for stamp, value in zip(self.stamps, readings.tolist(), strict=True):
            yield stamp, {"header": self._make_sensor_header(stamp), field: value, "variance": noise**2, **more}

    def _make_sensor_header(self, stamp: int) -> Values:
        return make_header(stamp, f"{self.options.namespace}/sensors")

    def _make_markers(self) -> Iterator[tuple[int, Values]]:
        from scipy.spatial.transform import Rotation

        scenario, stamp, found = self.job.scenario, self.stamps[0], list[Values]()

        def mark(group: str, shape: int, colour: tuple[float, ...], pose: Any, size: FloatArray, **more: Any) -> None:
            header = make_header(stamp, self.base if shape == TRIANGLES else self.world)
            marker = {"header": header, "ns": group, "id": len(found), "type": shape, "frame_locked": True}
            found.append({**marker, "pose": pose, "scale": size, "color": colour, **more})

        for bore in list_bores(scenario.pipe):
            # The axis of a cylinder is its z, and that of a bore its x.
            turned = Rotation.from_matrix(bore.rotation[:, [1, 2, 0]]).as_quat()
            size = np.array([2 * bore.radius, 2 * bore.radius, bore.length])
            mark("pipe", CYLINDER, GREY, (bore.position, turned), size)
        size = np.full(3, 0.05 * (1.0 if scenario.pipe.is_open else scenario.pipe.layout.narrowest))
        for name, point in scenario.target_points().items():
            mark("targets", SPHERE, VERMILLION, (point, LEVEL), size)
            above = np.add(point, [0.0, 0.0, 1.2 * size[2]])
            mark("names", TEXT, VERMILLION, (above, LEVEL), size, text=name)
        mesh = revolve_contour(self.job.agent.body.outer, SEGMENTS)
        corners = mesh.vertices[mesh.triangles.ravel()]
        mark("agent", TRIANGLES, ORANGE, (np.zeros(3), LEVEL), np.ones(3), points=corners)
        yield stamp, {"markers": found}


def make_header(stamp: int, frame: str) -> Values:
    """Return a header; ``stamp`` is in ns."""
    return {"stamp": divmod(stamp, SECOND), "frame_id": frame}


def make_transform(stamp: int, parent: str, child: str, place: FloatArray, turned: FloatArray) -> Values:
    """Return a transform with a header; ``turned`` is in the order of ROS."""
    return {"header": make_header(stamp, parent), "child_frame_id": child, "transform": (place, turned)}


def list_plumes(scenario: Scenario, options: FlightOptions) -> list[Plume]:
    """Return the plumes of the targets on the wall; none if the water is at rest, or the pipe is not straight."""
    straight = scenario.pipe.straight
    if not scenario.targets or scenario.flow.speed == 0 or straight is None:
        return []
    gaps = field.wall_distance(scenario.target_array(), scenario)
    return [
        make_plume(scenario, point, options.leak_rate, options.diffusivity)
        for point, gap in zip(scenario.target_points().values(), gaps, strict=True)
        if gap < ON_WALL * straight.radius
    ]
