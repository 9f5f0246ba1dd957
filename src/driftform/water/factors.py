"""The table ``[calibration]``: factors on the model from filmed flights, and how sure they are."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from driftform.types import Body, Coefficients, FloatArray
from driftform.util.options import Table, option


@dataclass(frozen=True)
class Factors:
    """Factors on results of the model; 1 changes nothing.

    Attributes:
        axial_drag: of friction, nose and base along the axis, of the friction of a spin, and of damping in surge and
            roll.
        cross_drag: of strips across the axis, of a sphere's drag, and of all other damping.
        added_mass: of the whole matrix.
        hull_density: of the hull's material, so that a print weighs what it does.
        restitution, friction: of the coefficients of the contact with walls.
        MIN, MAX: bounds of every factor.
    """

    MIN: ClassVar[float] = 0.01
    MAX: ClassVar[float] = 100.0
    """Bounds of a factor."""
    names: ClassVar[tuple[str, ...]]
    """The factors by name."""

    axial_drag: float = 1.0
    cross_drag: float = 1.0
    added_mass: float = 1.0
    hull_density: float = 1.0
    restitution: float = 1.0
    friction: float = 1.0

    def scale_body(self, body: Body) -> Body:
        """Return the body with the hull's density that was found."""
        if self.hull_density == 1.0:
            return body
        return replace(body, hull_density=body.hull_density * self.hull_density)

    def scale_coefficients(self, coefficients: Coefficients) -> Coefficients:
        """Return the coefficients with the drag and the added mass that were found."""
        if self.axial_drag == self.cross_drag == self.added_mass == 1.0:
            return coefficients
        scaled = coefficients.scale_damping(self.axial_drag, self.cross_drag)
        return replace(scaled, added_mass=self.added_mass * scaled.added_mass)

    def scale_restitution(self, restitution: float) -> float:
        """Return the coefficient of restitution that was found, within the bounds of ``contact.restitution``."""
        return restitution if self.restitution == 1.0 else min(1.0, max(0.1, self.restitution * restitution))


Factors.names = tuple(field.name for field in fields(Factors))

DRAGS = ("axial_drag", "cross_drag")
"""The factors that ``robustness.drag`` is about, unless they are known better."""


def _spread(value: Any) -> Any:
    return [value] * 3 if isinstance(value, int | float) and not isinstance(value, bool) else value


def _check_order(values: tuple[float, float, float]) -> tuple[float, float, float]:
    value, low, high = values
    if not low <= value <= high:
        raise ValueError(f"[{value:g}, {low:g}, {high:g}] must be [value, low, high] with low <= value <= high")
    return values


_Number: TypeAlias = Annotated[float, Field(strict=True, ge=Factors.MIN, le=Factors.MAX)]

Interval: TypeAlias = Annotated[
    tuple[_Number, _Number, _Number], BeforeValidator(_spread), AfterValidator(_check_order)
]
"""A factor and the interval that holds it with a probability of 90 %; a single number has no interval."""


class Calibration(Table):
    """Factors on the model, measured with ``driftform calibrate``: [value, low, high] of a 90 % interval, or a value.

    Every flight has the values. Disturbed flights draw a factor from its interval. ``robustness.drag`` is about the drags
    that have no interval.
    """

    quantile: ClassVar[float] = 1.6448536269514722
    """Standard deviations within which 90 % of a normal distribution lie."""

    axial_drag: Interval | None = option(
        None, "factor on drag along the axis: friction, nose and base; [value, low, high] or a value"
    )
    cross_drag: Interval | None = option(None, "factor on drag across the axis, and on a sphere's drag; the same")
    added_mass: Interval | None = option(None, "factor on the added mass; the same")
    hull_density: Interval | None = option(
        None, "factor on the density of the hull's material, by which the net weight of a print differs; the same"
    )
    restitution: Interval | None = option(None, "factor on `contact.restitution`; the same")
    friction: Interval | None = option(None, "factor on `contact.friction`; the same")
    correlations: tuple[tuple[str, str, Annotated[float, Field(strict=True, ge=-1, le=1)]], ...] = option(
        (), 'correlations between factors with an interval, such as ["cross_drag", "hull_density", 0.8]'
    )
    agent: str = option("", "name of the agent whose flights were filmed")
    tracks: int = option(0, "number of filmed flights", ge=0, le=1_000_000)
    residual: float = option(
        0.0, "root mean square distance between the calibrated flights and the tracks", "m", ge=0, le=1e6
    )

    @model_validator(mode="after")
    def _check_names(self) -> "Calibration":
        for first, second, _ in self.correlations:
            for name in (first, second):
                if name not in Factors.names:
                    raise ValueError(f"correlations name '{name}'; the factors are {', '.join(Factors.names)}")
        return self

    @property
    def intervals(self) -> Mapping[str, tuple[float, float, float]]:
        """Value, low and high of the factors that have an interval."""
        found = {name: getattr(self, name) for name in Factors.names}
        return {name: v for name, v in found.items() if v is not None and v[1] < v[2]}

    @property
    def factors(self) -> Factors:
        """The values."""
        found = {name: getattr(self, name) for name in Factors.names}
        return Factors(**{name: v[0] for name, v in found.items() if v is not None})

    @property
    def is_empty(self) -> bool:
        """True if it changes nothing."""
        return self.factors == Factors() and not self.intervals

    def with_factors(self, factors: Factors) -> "Calibration":
        """Return these values without intervals."""
        values = {name: getattr(factors, name) for name in Factors.names}
        return Calibration().model_copy(update={name: (v, v, v) for name, v in values.items()})

    def draw_factors(self, deviates: FloatArray) -> FloatArray:
        """Return values of the factors that have an interval, (n, factors), from independent normal deviates.

        Each factor is normal on both sides of its value, with the width of that side of the interval, and as correlated
        as :attr:`correlations` says.
        """
        value, low, high = np.array(list(self.intervals.values())).reshape(-1, 3).T
        z = np.asarray(deviates) @ self._mixing().T
        drawn = value + z / self.quantile * np.where(z > 0, high - value, value - low)
        return np.asarray(np.clip(drawn, Factors.MIN, Factors.MAX), dtype=np.float64)

    def _mixing(self) -> FloatArray:
        """Return the matrix (k, k) that turns independent deviates into correlated ones of variance 1."""
        names = list(self.intervals)
        matrix = np.eye(len(names))
        for first, second, value in self.correlations:
            if first in names and second in names and first != second:
                i, j = names.index(first), names.index(second)
                matrix[i, j] = matrix[j, i] = value
        # Rounded correlations may be no correlation matrix; the nearest one by its eigenvalues is.
        values, vectors = np.linalg.eigh(matrix)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        return np.asarray(root / np.linalg.norm(root, axis=1, keepdims=True))
