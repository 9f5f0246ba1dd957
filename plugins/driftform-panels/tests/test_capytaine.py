"""Panels against Capytaine, a boundary-element code for bodies of any shape: a stored table, and the study that makes it.

``UPDATE_DOCS=1 pytest -m slow -s plugins/driftform-panels/tests/test_capytaine.py`` computes the table anew (half an
hour) and writes it to ``capytaine.json`` and to docs/validation.md. Capytaine 3 has flat panels of constant strength,
here on meshes that repeat one wedge of the body around the axis; there is no free surface. A cup is not among the
bodies: what Capytaine finds for one does not settle from mesh to mesh (surge by 2 %). ``test_solve`` has one.
"""

import json
import os
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from solids import remus_body

from driftform.agent import solid_of_revolution
from driftform.testing.bodies import cylinder_body, make_body
from driftform.types import FloatArray
from driftform.water import Fluid
from driftform_panels.solve import solve
from driftform_striptheory.coefficients import StripTheory, StripTheoryOptions

TABLE = Path(__file__).with_name("capytaine.json")
AGENTS = 15
MESHES = ((4e-3, 12), (2e-3, 24), (1e-3, 48))
"""Longest panel along the meridian of an agent (m), and panels around the axis; each half as long as the one before."""


@dataclass(frozen=True, eq=False)
class Case:
    """A body, and what Capytaine found for it in water of density 1, about the centre of its volume.

    ``found`` has a row for each mesh: A11, A22, A66 (m3, m5), and the mean of A26 and A62 (m4). ``panels`` holds the
    number of panels of each mesh.
    """

    name: str
    contour: FloatArray
    panels: list[int]
    found: FloatArray

    @property
    def limit(self):
        """The limit of the three meshes, if their errors form a geometric series."""
        first, second, third = self.found
        step, before = third - second, second - first
        ratio = np.clip(np.divide(step, before, out=np.full(4, 0.25), where=before != 0), 1 / 8, 1 / 2)
        return np.asarray(third + step * ratio / (1 - ratio))

    @property
    def unit(self):
        """The scale of the errors: the values, and sqrt(A22 A66) for the coupling."""
        unit = self.limit.copy()
        unit[3] = np.sqrt(unit[1] * unit[2])
        return unit

    def by_panels(self):
        s = solve(self.contour)
        return np.array([s.surge, s.sway, s.yaw, (s.sway_of_yaw + s.yaw_of_sway) / 2])

    def by_strips(self):
        model = StripTheory(StripTheoryOptions())
        m = model.coefficients(make_body(self.contour), Fluid(density=1.0)).added_mass
        return np.array([m[0, 0], m[1, 1], m[5, 5], m[1, 5]])


def stored():
    if not TABLE.exists():
        return []
    document = json.loads(TABLE.read_text(encoding="utf-8"))
    return [
        Case(row["name"], np.array(row["contour"]), row["panels"], np.array(row["found"])) for row in document["cases"]
    ]


def agents():
    return [case for case in stored() if case.name.startswith("agent")]


@pytest.mark.parametrize("case", stored(), ids=lambda case: case.name)
def test_panels_agree_with_capytaine(case):
    error = np.abs(case.by_panels() - case.limit) / case.unit
    assert (error[:3] < 0.01).all(), error
    assert error[3] < 0.005, error


def test_capytaine_has_converged_well_enough_to_judge():
    for case in stored():
        left = np.abs(case.found[2] - case.limit) / case.unit
        assert (left < [0.03, 0.01, 0.01, 0.005]).all(), (case.name, left)


# The study.


def cut(contour, longest):
    """The contour with its edges cut into equal pieces, none longer than ``longest``."""
    points = [contour[:1]]
    for a, b in pairwise(contour):
        count = max(1, int(np.ceil(np.hypot(*(b - a)) / longest - 1e-9)))
        points.append(a + (b - a) * np.arange(1, count + 1)[:, None] / count)
    return np.concatenate(points)


def by_capytaine(contour, longest, around):
    """Number of panels, and a row of ``Case.found``. Capytaine's z axis is our x, its x our y."""
    import capytaine

    points = cut(contour, longest)
    half = np.pi / around
    # Polygons of the same area as the circles that they replace.
    r = points[:, 1] * np.sqrt(half / (np.sin(half) * np.cos(half)))
    z = points[:, 0] - solid_of_revolution(contour).centroid
    sides = [np.column_stack([r * np.cos(angle), r * np.sin(angle), z]) for angle in (-half, half)]
    first = np.arange(len(points) - 1)
    faces = np.column_stack([first, first + len(points), first + len(points) + 1, first + 1])
    wedge = capytaine.Mesh(vertices=np.concatenate(sides), faces=faces)
    mesh = capytaine.RotationSymmetricMesh(wedge=wedge, n=around)
    x, _, z = mesh.faces_centers.T
    zero, one = np.zeros_like(x), np.ones_like(x)
    motions = {
        "surge": np.column_stack([zero, zero, one]),
        "sway": np.column_stack([one, zero, zero]),
        "yaw": np.column_stack([z, zero, -x]),
    }
    body = capytaine.FloatingBody(mesh=mesh, dofs=motions)
    problems = [
        capytaine.RadiationProblem(
            body=body, free_surface=np.inf, water_depth=np.inf, radiating_dof=motion, rho=1.0, omega=1.0
        )
        for motion in motions
    ]
    results = capytaine.BEMSolver(method="direct").solve_all(problems, progress_bar=False)
    A = {(result.radiating_dof, motion): result.added_masses[motion] for result in results for motion in motions}
    coupling = (A["sway", "yaw"] + A["yaw", "sway"]) / 2
    return len(x), np.array([A["surge", "surge"], A["sway", "sway"], A["yaw", "yaw"], coupling])


def shapes(random_bodies):
    """Name, contour, and length by which the meshes of an agent are to be multiplied."""
    return [
        *((f"agent {k}", np.round(body.outer, 6), 1.0) for k, body in enumerate(random_bodies(AGENTS, 7))),
        ("cylinder", cylinder_body(0.06, 0.02).outer, 0.5),
        ("REMUS 100", np.round(remus_body(30).outer, 5), 10.0),
    ]


def lines_of(cases, version):
    """The table of docs/validation.md."""
    limits, units = np.array([case.limit for case in cases]), np.array([case.unit for case in cases])
    models = {
        "panels": np.array([case.by_panels() for case in cases]),
        "strip theory": np.array([case.by_strips() for case in cases]),
        "Capytaine's finest mesh": np.array([case.found[-1] for case in cases]),
    }
    lines = ["| error in percent, mean (largest) | " + " | ".join(models) + " |", "|---|" + "---|" * len(models)]
    for index, name in enumerate(("M11", "M22", "M55", "M26, of the root of M22 M66")):
        errors = [100 * np.abs(values[:, index] - limits[:, index]) / units[:, index] for values in models.values()]
        lines.append(f"| {name} | " + " | ".join(f"{e.mean():.2g} ({e.max():.2g})" for e in errors) + " |")
    counts = np.median([case.panels for case in cases], axis=0)
    unknowns = np.median([solve(case.contour).unknowns for case in cases])
    lines += [
        "",
        f"{len(cases)} random agents, about the centre of buoyancy. Capytaine {version} on three meshes of "
        f"{counts[0]:.0f}, {counts[1]:.0f} and {counts[2]:.0f} panels (medians), extrapolated; the distance of its "
        f"finest mesh from the limit shows the uncertainty of the limit. `panels` has {unknowns:.0f} unknowns.",
    ]
    return lines


def test_the_page_shows_the_stored_table(published):
    published("coefficients", lines_of(agents(), json.loads(TABLE.read_text(encoding="utf-8"))["capytaine"]))


@pytest.mark.peers
@pytest.mark.slow
def test_what_capytaine_finds(random_bodies, publish):
    import capytaine

    cases = []
    for name, contour, scale in shapes(random_bodies):
        found = [by_capytaine(contour, scale * longest, around) for longest, around in MESHES]
        case = Case(name, contour, [count for count, _ in found], np.array([values for _, values in found]))
        cases.append(case)
        off = 100 * (case.by_panels() - case.limit) / case.unit
        left = 100 * (case.found[-1] - case.limit) / case.unit
        print(f"{name}: {case.panels} panels, panels off by {off.round(3)} %, finest mesh by {left.round(3)} %")
    lines = lines_of([case for case in cases if case.name.startswith("agent")], capytaine.__version__)
    publish("coefficients", lines)
    if os.environ.get("UPDATE_DOCS") == "1":
        document = {
            "capytaine": capytaine.__version__,
            "meshes": [{"longest_m": longest, "around": around} for longest, around in MESHES],
            "cases": [
                {
                    "name": case.name,
                    "contour": case.contour.tolist(),
                    "panels": case.panels,
                    "found": [[float(f"{value:.7g}") for value in values] for values in case.found],
                }
                for case in cases
            ],
        }
        TABLE.write_text(json.dumps(document).replace('{"name"', '\n{"name"') + "\n", encoding="utf-8")
    for case in cases:
        error = np.abs(case.by_panels() - case.limit) / case.unit
        assert (error < [0.02, 0.02, 0.02, 0.01]).all(), case.name
