"""ROS 2 packages: what colcon, CMake and ros_gz_bridge ask of their files."""

import ast
import os
import re
import xml.etree.ElementTree as ET

import pytest
import yaml

FORMATS = {"sdf": ("gazebo", "start.launch.py"), "urdf": ("description", "display.launch.py")}


@pytest.fixture(params=FORMATS)
def package(request, job, export):
    return request.param, export(request.param, job)


def name_of(folder):
    return str(ET.parse(folder / "package.xml").getroot().findtext("name"))


def test_both_packages_of_an_agent_fit_into_one_workspace(job, export):
    assert len({name_of(export(format, job)) for format in ("sdf", "urdf", "uuv")}) == 3


def test_colcon_builds_and_registers_both_packages_of_every_agent(jobs, export, requires_program, run_system, tmp_path):
    requires_program("colcon")
    source = tmp_path / "src"
    source.mkdir()
    packages = {}
    for job in jobs.values():
        for format in FORMATS:
            folder = export(format, job)
            packages[name_of(folder)] = folder
            (source / name_of(folder)).symlink_to(folder)
    built = run_system("colcon build --merge-install", tmp_path)
    assert f"{len(packages)} packages finished" in built and "stderr" not in built
    # By this index `ros2 launch` and `ros2 run` find packages.
    index = "install/share/ament_index/resource_index/packages"
    run_system(f"source install/setup.bash && test $AMENT_PREFIX_PATH = {tmp_path}/install", tmp_path)
    assert {path.name for path in (tmp_path / index).iterdir()} == set(packages)
    for name, folder in packages.items():
        share, lib = tmp_path / "install" / "share" / name, tmp_path / "install" / "lib" / name
        files = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
        for path in files - {"CMakeLists.txt", "README.md", "LICENSE"}:
            # `ros2 run` takes programs only.
            assert os.access(lib / path, os.X_OK) if path.endswith(".sh") else (share / path).is_file(), path


def test_the_launch_file_starts_only_packages_that_the_manifest_names(package):
    format, folder = package
    text = (folder / "launch" / FORMATS[format][1]).read_text(encoding="utf-8")
    tree = ast.parse(text)
    assert "generate_launch_description" in [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    imported = {(node.module or "").split(".")[0] for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)} - {
        "pathlib"
    }
    started = set(re.findall(r"package='(\w+)'|FindPackageShare\('(\w+)'\)", text))
    named = {name for pair in started for name in pair if name} - {name_of(folder)}
    root = ET.parse(folder / "package.xml").getroot()
    assert imported | named == {element.text for element in root.findall("exec_depend")}


@pytest.mark.parametrize("gazebo", ["harmonic", "fortress"])
def test_the_bridge_connects_topics_of_this_world(gazebo, job, export):
    folder = export("sdf", job, gazebo=gazebo)
    rows = yaml.safe_load((folder / "config" / "bridge.yaml").read_text(encoding="utf-8"))
    world = ET.parse(folder / "world.sdf").getroot().find("world").get("name")
    assert len(rows) == (4 if gazebo == "harmonic" else 3)
    for row in rows:
        assert set(row) == {"ros_topic_name", "gz_topic_name", "ros_type_name", "gz_type_name", "direction"}
        assert re.fullmatch(r"\w+/msg/\w+", row["ros_type_name"])
        assert row["gz_type_name"].startswith("gz.msgs." if gazebo == "harmonic" else "ignition.msgs.")
        assert row["direction"] in ("GZ_TO_ROS", "ROS_TO_GZ")
        assert not row["gz_topic_name"].startswith("/world/") or row["gz_topic_name"].split("/")[2] == world
    assert len({row["ros_topic_name"] for row in rows}) == len(rows)


def test_the_launch_file_opens_a_world_that_is_there(job, export):
    folder = export("sdf", job)
    text = (folder / "launch" / "start.launch.py").read_text(encoding="utf-8")
    first = re.search(r"'world', default_value='([\w.]+)'", text).group(1)
    assert (folder / first).is_file()
    assert first == ("drift.sdf" if (folder / "drift.sdf").exists() else "world.sdf")
    # Where a script must give the velocity of the release, the simulation must not run at once.
    push = folder / {"drift.sdf": "push_drift.sh", "world.sdf": "push.sh"}[first]
    assert ("'paused', default_value='true'" in text) == push.exists()
    assert (push.name in (folder / "README.md").read_text(encoding="utf-8")) or not push.exists()


def test_the_readme_names_only_arguments_that_launch_takes_and_the_world_of_each_script(jobs, export):
    for job in jobs.values():
        folder = export("sdf", job)
        text = (folder / "README.md").read_text(encoding="utf-8")
        launch = (folder / "launch" / "start.launch.py").read_text(encoding="utf-8")
        given = re.findall(r"(\w+):=(\S*?)[`\s,)]", text)
        # `ros2 launch` refuses an argument without a value.
        assert all(value for _, value in given)
        assert {argument for argument, _ in given} <= set(re.findall(r"DeclareLaunchArgument\('(\w+)'", launch))
        if (folder / "push.sh").exists() and (folder / "drift.sdf").exists():
            assert "in `world.sdf`, and there only" in text and "world:=world.sdf paused:=true" in text
