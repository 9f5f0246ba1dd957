"""Bodies of plain modules, jobs of exporters, and 3MF files made by hand, for tests of prints."""

import math
import zipfile

import numpy as np

from driftform.agent import mass_properties
from driftform.interfaces import ExportJob
from driftform.types import Agent, Coefficients, Module, Morphology
from driftform.water import Scenario
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.parts import make_parts

_TILTS = {"u": math.radians(20), "n": -math.radians(20), "s": 0.0}
_MODEL = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_START = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"

CORNERS = np.array([[0, 0, 0], [10, 0, 0], [0, 20, 0], [0, 0, 30]], dtype=float)
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
"""A tetrahedron that no rotation takes to itself, mm."""


def chain_body(fore="", aft="", **options):
    """Return a body of modules of 10 mm: u widens by 20 degrees, n narrows, s goes straight on."""
    sides = [tuple(Module(0.01, _TILTS[letter]) for letter in side) for side in (fore, aft)]
    return FrustaBuilder(FrustaOptions.model_validate(options)).build(Morphology(*sides))


def job_of(body, name="agent", gravity=9.81):
    """Return a body as exporters receive it, in open water, with coefficients that no exporter of meshes reads."""
    agent = Agent(body, mass_properties(body), Coefficients(np.eye(6)))
    return ExportJob(name, agent, Scenario.model_validate({"fluid": {"density": 1000.0, "gravity": gravity}}))


def weigh_meshes(body, options):
    """Return mass (kg), centre of gravity (m) and inertia about it (kg m2) of the meshes of the parts and the core."""
    mass, first, second = body.core.mass, np.zeros(3), 0.2 * body.core.mass * body.core.radius**2 * np.eye(3)
    for part in make_parts(body, options):
        corners = 1e-3 * part.solid.vertices[part.solid.triangles]
        corners = corners[:, :, [2, 0, 1]] + (body.outer[0, 0], 0.0, 0.0)
        sixth = np.linalg.det(corners) / 6
        total = corners.sum(axis=1)
        mass += body.hull_density * sixth.sum()
        first += body.hull_density * (sixth[:, None] * total).sum(axis=0) / 4
        # Integral of x x^T over a tetrahedron with one corner at the origin.
        outer = np.einsum("ni,nj->nij", total, total) + np.einsum("nki,nkj->nij", corners, corners)
        second += body.hull_density * (sixth[:, None, None] * outer).sum(axis=0) / 20
    cog = first / mass
    second -= mass * np.outer(cog, cog)
    return mass, cog, np.trace(second) * np.eye(3) - second


def mesh_xml(vertices=CORNERS, triangles=TRIANGLES):
    """Return a mesh as 3MF has it."""
    corners = "".join('<vertex x="{}" y="{}" z="{}"/>'.format(*v) for v in np.asarray(vertices).tolist())
    faces = "".join('<triangle v1="{}" v2="{}" v3="{}"/>'.format(*t) for t in np.asarray(triangles).tolist())
    return f"<mesh><vertices>{corners}</vertices><triangles>{faces}</triangles></mesh>"


OBJECT = f'<object id="1">{mesh_xml()}</object>'


def write_3mf(path, objects=OBJECT, items='<item objectid="1"/>', unit="millimeter", attached=None):
    """Write a 3MF file of the text of its objects and its items, with other files by their names."""
    model = f'<model unit="{unit}" xmlns="{_MODEL}"><resources>{objects}</resources><build>{items}</build></model>'
    relationship = f'<Relationship Id="r" Target="/3D/parts.model" Type="{_START}"/>'
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("_rels/.rels", f"<Relationships>{relationship}</Relationships>")
        archive.writestr("3D/parts.model", model)
        for name, content in (attached or {}).items():
            archive.writestr(name, content, zipfile.ZIP_STORED)
    return path


def edit_archive(path, added=None, removed=()):
    """Replace files of an archive, or add them, and remove others."""
    with zipfile.ZipFile(path) as archive:
        held = {entry: archive.read(entry) for entry in archive.namelist() if entry not in removed}
    with zipfile.ZipFile(path, "w") as archive:
        for entry, content in {**held, **(added or {})}.items():
            archive.writestr(entry, content)
