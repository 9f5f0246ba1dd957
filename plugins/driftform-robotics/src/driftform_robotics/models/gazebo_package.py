"""The ROS 2 package of a Gazebo model: its launch file, its bridge to ROS, and its README."""

from collections.abc import Sequence

from driftform_robotics.models.exporter import Model
from driftform_robotics.models.ros2 import Bridge, list_items, make_package, read_template

WORLD = "driftform"
"""Name of the world in Gazebo."""

_DRIFT = """\
- `drift.sdf` (the default) is in the frame of the water: the pipe and the targets move past water at rest. The motion
  relative to the pipe is that in the current, and exact. **The pose in the pipe is the pose of `{title}` less the
  position of the model `pipe`**; the velocity over ground is the velocity there plus the current, {current} m/s.
- `world.sdf` has the pipe at rest and a current (`world:=world.sdf`): Gazebo's forces on a turning agent are incomplete
  there.
"""

_PUSH = """\
- `push.sh` gives the agent the velocity of its release in `world.sdf`, and there only: start it by
  `ros2 launch {package} start.launch.py world:=world.sdf paused:=true`, run `ros2 run {package} push.sh`, then press play.
"""

_STILL = "- `world.sdf` has the pipe, and the water at rest.\n"


def gazebo_package(
    model: Model, files: Sequence[str], messages: str, program: str, warnings: Sequence[str]
) -> dict[str, str]:
    """Return the files that make the folder of a Gazebo model a ROS 2 package.

    Parameters
    ----------
    model
        the agent.
    files
        paths of the other files in the folder.
    messages
        package of Gazebo's messages, such as ``gz.msgs``.
    program
        Gazebo's program.
    warnings
        what the files cannot represent.
    """
    name, title = f"{model.title}_gazebo", model.title
    first = "drift.sdf" if "drift.sdf" in files else "world.sdf"
    push = {"drift.sdf": "push_drift.sh", "world.sdf": "push.sh"}[first]
    bridges = _list_bridges(title, messages)
    launch = read_template("start.launch.py.in").replace("PACKAGE", name).replace("FIRST", first)
    current = " ".join(f"{u:g}" for u in model.job.scenario.current().tolist())
    readme = read_template("gazebo-readme.md.in").format(
        package=name,
        agent=model.job.name,
        title=title,
        program=program,
        sim="sim" if program == "gz" else "gazebo",
        first=first,
        start=(
            f"Gazebo starts paused. Give the agent the velocity of its release by `ros2 run {name} {push}`, then press play.\n"
            if push in files
            else "The simulation runs at once; `paused:=true` starts it paused.\n"
        ),
        worlds=(_DRIFT.format(title=title, current=current) if first == "drift.sdf" else _STILL)
        + (_PUSH.format(package=name) if first == "drift.sdf" and "push.sh" in files else ""),
        topics="\n".join(f"| `{b.ros}` | `{b.ros_type}` | {_WAYS[b.direction]} |" for b in bridges),
        warnings=list_items(warnings),
    )
    return make_package(
        name,
        f"The agent {model.job.name} of driftform in its pipe, for Gazebo",
        files,
        launch=("start.launch.py", launch.replace("PAUSED", "true" if push in files else "false")),
        depends=("launch", "launch_ros", "ros_gz_bridge", "ros_gz_sim"),
        readme=readme,
        bridges=bridges,
    )


_WAYS = {"GZ_TO_ROS": "from Gazebo", "ROS_TO_GZ": "to Gazebo"}


def _list_bridges(title: str, messages: str) -> list[Bridge]:
    world, poses = f"/world/{WORLD}", f"/{title}/poses"
    found = [
        Bridge("/clock", "/clock", "rosgraph_msgs/msg/Clock", f"{messages}.Clock", "GZ_TO_ROS"),
        Bridge(
            poses, f"{world}/dynamic_pose/info", "tf2_msgs/msg/TFMessage", f"{messages}.Pose_V", "GZ_TO_ROS"
        ),
        Bridge(
            f"/{title}/current",
            "/ocean_current",
            "geometry_msgs/msg/Vector3",
            f"{messages}.Vector3d",
            "ROS_TO_GZ",
        ),
    ]
    if messages == "gz.msgs":
        # The bridge of Fortress knows no such message.
        kind, own = "ros_gz_interfaces/msg/EntityWrench", f"{messages}.EntityWrench"
        found.append(Bridge(f"/{title}/wrench", f"{world}/wrench", kind, own, "ROS_TO_GZ"))
    return found
