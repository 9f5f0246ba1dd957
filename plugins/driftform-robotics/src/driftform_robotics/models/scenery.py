"""The surroundings of the agent in SDF worlds: light, the pipe and the targets."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable

import numpy as np

from driftform.types import FloatArray
from driftform.water import Scenario
from driftform_robotics.models.pipe import list_bores, make_wall
from driftform_robotics.models.xml import add, add_comment, add_texts, format_pose

_GLASS, _RED = "0.6 0.8 0.9 1", "0.9 0.2 0.1 1"


def add_scene(world: ET.Element) -> None:
    """Append the colours of the scene and a light from above, so that the world includes no other files."""
    scene = add(world, "scene")
    add_texts(scene, ambient="0.6 0.6 0.6 1", background="0.7 0.8 0.9 1", shadows="false")
    light = add(world, "light", type="directional", name="sun")
    add_texts(light, pose="0 0 10 0 0 0", cast_shadows="false", diffuse="0.8 0.8 0.8 1")
    add_texts(light, specular="0.2 0.2 0.2 1", direction="-0.3 0.4 -0.9")


def add_friction(collision: ET.Element, coefficient: float) -> None:
    """Append a surface with Coulomb friction to a collision."""
    ode = add(add(add(collision, "surface"), "friction"), "ode")
    add_texts(ode, mu=coefficient, mu2=coefficient)


def add_mesh(parent: ET.Element, uri: str) -> None:
    """Append a mesh to a visual or to a collision."""
    add(add(add(parent, "geometry"), "mesh"), "uri", uri)


def _add_material(visual: ET.Element, colour: str) -> None:
    material = add(visual, "material")
    add_texts(material, ambient=colour, diffuse=colour)


def add_pipe(
    world: ET.Element, scenario: Scenario, offset: FloatArray, mesh: str | None
) -> ET.Element | None:
    """Append the pipe, moved by ``offset`` (m), and return its model, or ``None`` in open water.

    The wall collides as planks. It is displayed as the ``mesh`` of :func:`make_wall`, or, without one, as the planks.
    """
    wall = make_wall(scenario.pipe)
    if wall is None:
        return None
    model = add(world, "model", name="pipe")
    link = add(model, "link", name="wall")
    add_comment(
        link, "The wall is a ring of planks: simulators replace a mesh by its convex hull, which is solid."
    )
    if mesh is not None:
        visual = add(link, "visual", name="segment_0")
        add(visual, "pose", format_pose(wall.position + offset, wall.rotation))
        _add_glass(visual)
        add_mesh(visual, mesh)
    for index, bore in enumerate(list_bores(scenario.pipe)):
        for k, plank in enumerate(bore.make_planks()):
            shapes = [add(link, "collision", name=f"plank_{index}_{k}")]
            add_friction(shapes[0], scenario.calibrated_contact().friction)
            if mesh is None:
                shapes.append(add(link, "visual", name=f"segment_{index}_{k}"))
                _add_glass(shapes[1])
            for shape in shapes:
                place = bore.position + offset + bore.rotation @ plank.position
                add(shape, "pose", format_pose(place, bore.rotation @ plank.rotation))
                add(add(add(shape, "geometry"), "box"), "size", plank.size)
    return model


def _add_glass(visual: ET.Element) -> None:
    add_texts(visual, cast_shadows="false", transparency="0.75")
    _add_material(visual, _GLASS)


def add_targets(world: ET.Element, scenario: Scenario, offset: FloatArray) -> ET.Element | None:
    """Append the targets as marks without collision, moved by ``offset`` (m); return their model, ``None`` without targets."""
    if not scenario.targets:
        return None
    radius = 0.02 * (1.0 if scenario.pipe.is_open else scenario.pipe.layout.narrowest)
    model = add(world, "model", name="targets")
    link = add(model, "link", name="marks")
    for name, place in scenario.target_points().items():
        visual = add(link, "visual", name=name)
        add(visual, "pose", format_pose(np.array(place) + offset))
        _add_material(visual, _RED)
        add(add(add(visual, "geometry"), "sphere"), "radius", radius)
    return model


def make_static(models: Iterable[ET.Element | None]) -> None:
    """Make models immovable."""
    for model in models:
        if model is not None:
            add(model, "static", "true")
