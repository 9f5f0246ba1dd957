"""An agent in flight on a running ROS."""

from typing import TYPE_CHECKING

from driftform import hookimpl

if TYPE_CHECKING:
    import typer


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform ros``. Check here that rosbags is installed; ROS itself is looked for when the command runs."""
    from driftform.util import foreign
    from driftform_ros.command import ros

    foreign.require_module("rosbags")
    # Words of ROS 2, such as --ros-args, stand among the remaps.
    app.command("ros", context_settings={"ignore_unknown_options": True})(ros)
