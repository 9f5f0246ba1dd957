"""Mass and volume of a kit beside those that were simulated: sleeves, seats and fillings add mass."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from manifold3d import Manifold

from driftform.geometry import mass_properties, solid_of_revolution
from driftform.geometry.mass import assemble
from driftform.interfaces import ExportJob
from driftform.scenario import Fluid
from driftform.types import Body, FloatArray, MassProperties
from driftform_frusta.kit.engraving import Engraving
from driftform_frusta.kit.meridian import MM, moments
from driftform_frusta.kit.options import KitOptions
from driftform_frusta.kit.pieces import Kit, Piece, make_kit
from driftform_frusta.solid import to_manifold

_MM3_PER_M3 = MM**3


@dataclass(frozen=True, eq=False)
class EngravedVolume:
    """The material that a text removes: volume (m3), and centroid in the body frame (m, (3,))."""

    volume: float
    centroid: FloatArray


def kit_mass(body: Body, options: KitOptions) -> MassProperties:
    """Return mass properties of the assembled kit with its core.

    Parts of revolution are integrated in closed form; glue and O-rings weigh nothing here, and holes of ``drain``
    are taken to be plugged flush. An engraving is taken out as a point mass, which is exact but for the inertia, and
    outside it fills with water.

    Raises
    ------
    WorkFailedError
        if the body has no such kit.
    """
    kit = make_kit(body, options)
    printed = sum((moments(p.rings) for p in kit.pieces[1:]), moments(kit.pieces[0].rings))
    whole = assemble(printed, solid_of_revolution(body.outer), body.hull_density, body.core)
    texts = [measure_engraving(piece.engraved) for piece in kit.pieces if piece.engraved is not None]
    outside = options.engrave_side == "outside"
    for text in texts:
        whole = _subtract(whole, text, body.hull_density, outside)
    return whole


@lru_cache(maxsize=64)
def measure_engraving(text: Engraving) -> EngravedVolume:
    """Return the volume and the centroid of the material that an engraving removes."""
    volume, first = _mesh_moments(to_manifold(text.gone))
    x, y, z = first / volume / MM
    # Printed: the axis along z. In the body frame it is x.
    return EngravedVolume(volume / _MM3_PER_M3, np.array([z, x, y]))


def _mesh_moments(solid: Manifold) -> tuple[float, FloatArray]:
    """Volume and first moments of a mesh, sums over the tetrahedra from the origin to its triangles; mm."""
    mesh = solid.to_mesh64()
    corners = np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts, dtype=np.int64)]
    sixfold = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    first: FloatArray = (sixfold[:, None] * corners.sum(axis=1)).sum(axis=0) / 24
    return float(sixfold.sum()) / 6, first


def _subtract(whole: MassProperties, text: EngravedVolume, density: float, floods: bool) -> MassProperties:
    lost = text.volume * density
    mass = whole.mass - lost
    cog = (whole.mass * whole.cog - lost * text.centroid) / mass
    inertia = (
        whole.inertia
        + whole.mass * _point_inertia(whole.cog)
        - lost * _point_inertia(text.centroid)
        - mass * _point_inertia(cog)
    )
    if not floods:
        return MassProperties(mass, cog, inertia, whole.volume, whole.cob)
    volume = whole.volume - text.volume
    cob = (whole.volume * whole.cob - text.volume * text.centroid) / volume
    return MassProperties(mass, cog, inertia, volume, cob)


def _point_inertia(at: FloatArray) -> FloatArray:
    """Inertia of a unit point mass, m2."""
    square: FloatArray = float(at @ at) * np.eye(3) - np.outer(at, at)
    return square


def kit_facts(job: ExportJob, options: KitOptions) -> dict[str, Any]:
    """Return the facts of a job's kit, under the key ``kit``; an empty dictionary without a kit.

    ``joint``: its ``kind``, where it cuts (``x_mm``), and ``why``. ``parts``: of each its ``name``, ``mass_kg``,
    ``height_mm`` and ``bed_end``. ``balance``: mass (kg), x of the centres of gravity and of buoyancy (mm) and net
    buoyancy (N) of the simulated agent and of the printed one. With holes also ``flooded_kg``, the mass of the
    water that enters through an open hole.
    """
    if not options.kit:
        return {}
    body, fluid = job.agent.body, job.scenario.fluid
    kit = make_kit(body, options)
    first = kit.core_joint.joint
    facts: dict[str, Any] = {
        "joint": {"kind": first.kind, "x_mm": first.z, "why": kit.core_joint.reason},
        "parts": [_facts_of_piece(piece, body.hull_density) for piece in kit.pieces],
        "balance": [
            _balance(name, mass, fluid)
            for name, mass in (("simulated", mass_properties(body)), ("printed", kit_mass(body, options)))
        ],
    }
    if options.drain:
        facts["flooded_kg"] = fluid.density * _free_volume(kit, body)
    return {"kit": facts}


def _facts_of_piece(piece: Piece, density: float) -> dict[str, Any]:
    z = np.concatenate([ring[:, 1] for ring in piece.rings])
    volume = moments(piece.rings).volume - (
        measure_engraving(piece.engraved).volume if piece.engraved else 0.0
    )
    return {
        "name": piece.name,
        "mass_kg": volume * density,
        "height_mm": float(np.ptp(z)),
        "bed_end": "fore" if piece.fore_down else "aft",
    }


def _balance(name: str, mass: MassProperties, fluid: Fluid) -> dict[str, Any]:
    return {
        "of": name,
        "mass_kg": mass.mass,
        "cog_mm": MM * float(mass.cog[0]),
        "cob_mm": MM * float(mass.cob[0]),
        "net_buoyancy_n": mass.net_buoyancy(fluid),
    }


def _free_volume(kit: Kit, body: Body) -> float:
    """Volume inside the hull that is neither part nor core, m3."""
    inside = solid_of_revolution(body.outer).volume - sum(moments(piece.rings).volume for piece in kit.pieces)
    return inside - 4 / 3 * np.pi * body.core.radius**3
