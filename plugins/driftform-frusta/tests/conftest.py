"""Bodies made directly of contours, and the programs that read what we write."""

import subprocess

import numpy as np
import pytest
import trimesh

from driftform.types import Body, Core

WALL = 1.25e-3
DENSITY = 1050.0


def body_of(outer, cavity=()):
    """A body of contours in m."""
    outline = np.array(outer, dtype=float)
    return Body(
        outer=outline,
        cavity=np.array(cavity, dtype=float).reshape(-1, 2),
        joints=np.unique(outline[:, 0]),
        core=Core(radius=0.01, mass=0.05),
        wall=WALL,
        hull_density=DENSITY,
    )


def chain_of(lengths, radii, wall=WALL):
    """A capped chain of frustums with a radial wall; there is one radius more than there are lengths."""
    x = np.concatenate(([0.0], np.cumsum(lengths))) - sum(lengths) / 2
    r = np.array(radii)
    inside = np.concatenate(([x[0] + wall], x[(x > x[0] + wall) & (x < x[-1] - wall)], [x[-1] - wall]))
    bore = np.interp(inside, x, r - wall)

    def capped(x, r):
        return [[x[0], 0.0], *np.column_stack((x, r)).tolist(), [x[-1], 0.0]]

    return body_of(capped(x, r), capped(inside, bore))


@pytest.fixture(scope="session")
def make_body():
    return body_of


@pytest.fixture(scope="session")
def make_chain():
    return chain_of


def _wavy():
    rng = np.random.default_rng(7)
    radii = np.clip(0.02 + np.cumsum(rng.uniform(-3e-3, 3e-3, 41)), 5e-3, 0.06)
    return chain_of(rng.uniform(2.5e-3, 10e-3, 40), radii)


_BODIES = {
    "capped cylinder": lambda: chain_of([0.1], [0.02, 0.02]),
    "solid cone": lambda: body_of([(-0.02, 0), (-0.02, 0.03), (0.05, 0)]),
    "hollow cone": lambda: body_of([(-0.02, 0), (-0.02, 0.03), (0.05, 0)], [(-0.018, 0), (-0.018, 0.02), (0.03, 0)]),
    "double cone": lambda: body_of([(-0.05, 0), (0, 0.03), (0.05, 0)], [(-0.04, 0), (0, 0.024), (0.04, 0)]),
    "stepped cylinder": lambda: body_of(
        [(-0.05, 0), (-0.05, 0.01), (0, 0.01), (0, 0.03), (0.05, 0.03), (0.05, 0)],
        [(-0.048, 0), (-0.048, 0.008), (0.002, 0.008), (0.002, 0.028), (0.048, 0.028), (0.048, 0)],
    ),
    "40 modules": _wavy,
}


@pytest.fixture(scope="session", params=_BODIES)
def body(request):
    """One body of each kind."""
    return _BODIES[request.param]()


@pytest.fixture(scope="session")
def wavy_body():
    """A hull of 40 modules."""
    return _wavy()


@pytest.fixture
def render(requires_program, tmp_path):
    """OpenSCAD source -> the mesh that OpenSCAD renders."""
    openscad = requires_program("openscad")

    def run(source):
        scad, stl = tmp_path / "source.scad", tmp_path / "rendered.stl"
        scad.write_text(source)
        done = subprocess.run(
            [openscad, "-o", str(stl), str(scad)],
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=600,
            check=False,
        )
        # Some errors, such as a part that is dropped, leave the exit code at 0.
        assert done.returncode == 0, done.stderr
        assert "ERROR" not in done.stderr, done.stderr
        assert "WARNING" not in done.stderr, done.stderr
        return trimesh.load_mesh(stl)

    return run
