"""Measured or computed coefficients of your own body: the file that names them, and the model that has them."""

import re
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from driftform.errors import InputError
from driftform.interfaces import Hydrodynamics, HydrodynamicsOptions, option
from driftform.types import Body, Coefficients, FloatArray
from driftform.util import files
from driftform.water import Fluid

if TYPE_CHECKING:
    from driftform import Design

_Entry = Annotated[float, Field(ge=-1e12, le=1e12)]
_Row = tuple[_Entry, _Entry, _Entry, _Entry, _Entry, _Entry]
Matrix = tuple[_Row, _Row, _Row, _Row, _Row, _Row]

KINDS = ("added_mass", "linear_damping", "quadratic_damping")

_NAME = re.compile(r"([XYZKMN])_?([uvwpqr])(dot|\2|)")
"""Such as Y_vdot, Y_v and Y_vv, in the order of the matrices."""

_TURN, _SIGN = [0, 2, 1, 3, 5, 4], np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0])
"""A quarter of a turn about the axis: whose component each one becomes, and its sign."""

_AXES = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
"""From Fossen's axes to those of the body: y to port and z up, half a turn about x."""


class MatrixOptions(HydrodynamicsOptions):
    """Matrices about a point of the axis, in body axes: x fore, y to port, z up."""

    added_mass: Matrix = option(..., "added mass", "kg, kg m, kg m2")
    linear_damping: Matrix = option(..., "linear damping, positive where it resists", "N s/m, N s, N m s")
    quadratic_damping: Matrix = option(..., "the same of a rate times its size", "N s2/m2, N s2/m, N s2, N m s2")
    origin: float = option(0.0, "x of the point in the body frame", "m", ge=-1000, le=1000)
    density: float = option(..., "density of the water in which they were found", "kg/m3", ge=0.01, le=22_600)

    @model_validator(mode="after")
    def _resist(self) -> "MatrixOptions":
        """Accept an added mass that is symmetric and positive, and damping that drives no motion."""
        added, linear, quadratic = (np.array(getattr(self, kind)) for kind in KINDS)
        if np.abs(added - added.T).max() > 1e-6 * np.abs(added).max():
            raise ValueError("added_mass is not symmetric")
        # A spin about its axis moves no water around a body of revolution.
        least, second, *_, most = np.linalg.eigvalsh(added)
        if least < -1e-9 * most or second < 1e-9 * most:
            raise ValueError("added_mass is not positive: it needs at least X_udot, Y_vdot and M_qdot")
        # The power of two motions at a time, in all ratios and both directions.
        i, j = np.triu_indices(6, 1)
        ratios = np.outer([1.0, -1.0], np.geomspace(1e-4, 1e4, 400)).ravel()
        rates = np.eye(6)[i][:, None] + ratios[:, None] * np.eye(6)[j][:, None]
        for kind, matrix, moved in zip(KINDS[1:], (linear, quadratic), (rates, rates * np.abs(rates)), strict=True):
            terms = rates[..., :, None] * matrix * moved[..., None, :]
            if (terms.sum(axis=(-1, -2)) < -1e-9 * np.abs(terms).sum(axis=(-1, -2))).any():
                raise ValueError(f"{kind} drives a motion instead of resisting it: look at its signs")
        return self


class MatrixModel(Hydrodynamics[MatrixOptions]):
    """The matrices of the options, as 'driftform body --coefficients' writes them, for one body only."""

    name = "matrices"
    Options = MatrixOptions

    def coefficients(self, body: Body, fluid: Fluid) -> Coefficients:
        """Return the matrices; added mass and quadratic damping grow with the density of the water."""
        added, linear, quadratic = (np.array(getattr(self.options, kind)) for kind in KINDS)
        denser, origin = fluid.density / self.options.density, np.array([self.options.origin, 0.0, 0.0])
        return Coefficients(denser * added, origin, linear, denser * quadratic)


class _File(BaseModel):
    """A file of coefficients: whole matrices, and single derivatives by their names."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)
    __pydantic_extra__: dict[str, float]
    origin: float | None = None
    added_mass: Matrix | None = None
    linear_damping: Matrix | None = None
    quadratic_damping: Matrix | None = None


def _read_matrices(given: _File) -> dict[str, FloatArray]:
    """Return the matrices of a file in body axes, positive where they resist.

    What a body of revolution has twice, such as Y_vdot and Z_wdot, may be given once.
    """
    found = {kind: np.array(matrix) for kind in KINDS if (matrix := getattr(given, kind)) is not None}
    for key, value in given.__pydantic_extra__.items():
        if (name := _NAME.fullmatch(key.replace("|", ""))) is None:
            raise ValueError(
                f"'{key}': expected a name such as Y_vdot, Y_v, Y_vv, {', '.join(KINDS)} or origin; products of two rates, such as "
                "the lift of fins, cannot be given"
            )
        kind = KINDS[{"dot": 0, "": 1}.get(name.group(3), 2)]
        place = "XYZKMN".index(name.group(1)), "uvwpqr".index(name.group(2))
        found.setdefault(kind, np.full((6, 6), np.nan))[place] = value
    return {kind: np.outer(_AXES, _AXES) * _complete(values, kind == KINDS[0]) for kind, values in found.items()}


def _complete(values: FloatArray, symmetric: bool) -> FloatArray:
    """Return a matrix without gaps, which are NaN, positive where derivatives of forces are negative."""
    filled = np.where(np.isnan(values), np.outer(_SIGN, _SIGN) * values[np.ix_(_TURN, _TURN)], values)
    if symmetric:
        filled = np.where(np.isnan(filled), filled.T, filled)
    filled = np.nan_to_num(filled)
    return filled * (-1.0 if np.trace(filled) < 0 else 1.0)


def measure_model(path: Path, design: "Design") -> tuple[dict[str, Any], list[str]]:
    """Return the table ``[hydrodynamics]`` of a design with the matrices of a file in place of those of its hull, and their names.

    Matrices are about the ``origin`` of the file, its distance from the nose (m), or the centre of gravity; y points to
    starboard and z down. Damping also replaces the hull's drag. An InputError names the file and what is wrong.
    """
    # Compiled code loads the compiler, and listing the plugins must not.
    from driftform.motion.forces import added_mass_at

    model, body, fluid = design.pipeline.hydrodynamics, design.agent.body, design.scenario.fluid
    try:
        given = _File.model_validate(tomllib.loads(files.read_text(path)))
        found = _read_matrices(given)
        x = float(design.mass.cog[0] if given.origin is None else body.outer[-1, 0] - given.origin)
        own = added_mass_at(model.coefficients(body, fluid), np.array([x, 0.0, 0.0]))
        matrices = {kind: np.zeros((6, 6)) for kind in KINDS} | {KINDS[0]: own} | found
        table = {"origin": x, "density": fluid.density, "drag_without": model.options.drag_without}
        table["drag"] = "none" if found.keys() & {*KINDS[1:]} else model.options.drag
        table |= {kind: matrix.tolist() for kind, matrix in matrices.items()}
        MatrixOptions.model_validate(table)
    except ValidationError as error:
        wrong = error.errors()[0]
        place = f"'{'.'.join(map(str, wrong['loc']))}': " if wrong["loc"] else ""
        raise InputError(f"{path}: {place}{wrong['msg'].removeprefix('Value error, ')}") from None
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
    return {"use": "matrices", **table}, list(found)
