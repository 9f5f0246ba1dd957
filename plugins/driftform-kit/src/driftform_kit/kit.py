"""What an exporter reports of a kit: its weight, and what holds the ballast."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from driftform.errors import WorkFailedError
from driftform.interfaces import Exporter, ExportJob
from driftform.plugins.seams import require_files

MM_PER_M = 1000.0


@dataclass(frozen=True)
class HeldBall:
    """A ball of ballast that a kit holds.

    Attributes
    ----------
    x, diameter
        of the ball, m.
    part
        name of the part that holds it.
    mouth
        x of the joint that it goes in by, m; ``None`` if it is put in while its part is printed.
    pause
        height at which the printer is to pause for it, m; ``None`` if it goes in by a joint.
    held_by
        ``"seat"``, or ``"wall"`` if the hull narrows there.
    """

    x: float
    diameter: float
    part: str
    mouth: float | None
    pause: float | None
    held_by: str


@dataclass(frozen=True)
class KitReport:
    """A kit with its core: mass (kg), x of its centre of gravity (m), the balls of ballast that it holds."""

    mass: float
    cog: float
    held: tuple[HeldBall, ...] = ()


Balls = Sequence[tuple[float, float]]
"""Of each ball x and diameter, m."""

MeasureKit = Callable[[Balls | None], KitReport]
"""Measures a kit with seats for balls, for ``None`` with those of its options; fails if it cannot hold them."""


def measure_kit(exporter: Exporter[Any], job: ExportJob, balls: Balls | None = None) -> KitReport:
    """Return what an exporter reports of its kit, with seats for balls.

    Raises
    ------
    WorkFailedError
        if the exporter does not account for its kit, cannot hold these balls, or knows no seats.
    """
    if balls is not None:
        if "ballast" not in exporter.Options.model_fields:
            raise WorkFailedError(f"exporter '{exporter.name}' makes no seats for ballast")
        options = {**exporter.options.model_dump(), "ballast": [list(ball) for ball in balls]}
        try:
            exporter = type(exporter)(exporter.Options.model_validate(options))
        except ValueError:
            sizes = ", ".join(f"{MM_PER_M * diameter:.2g} mm" for _, diameter in balls)
            raise WorkFailedError(f"exporter '{exporter.name}' makes no seats for balls of {sizes}") from None
    with TemporaryDirectory() as folder:
        written = require_files(exporter.write(job, Path(folder) / f"{job.name}{exporter.suffix}"), exporter)
    for file in written:
        kit = file.facts.get("kit", {})
        for row in kit.get("balance", ()):
            if row["of"] == "printed":
                return KitReport(
                    float(row["mass_kg"]),
                    float(row["cog_mm"]) / MM_PER_M,
                    tuple(_read_ball(ball) for ball in kit.get("ballast", ())),
                )
    raise WorkFailedError(
        f"exporter '{exporter.name}' does not report how its kit balances; weigh the kit, and leave --kit out"
    )


def _read_ball(ball: dict[str, Any]) -> HeldBall:
    return HeldBall(
        ball["x_mm"] / MM_PER_M,
        ball["diameter_mm"] / MM_PER_M,
        ball["part"],
        _in_metres(ball["mouth_mm"]),
        _in_metres(ball["pause_mm"]),
        ball["held_by"],
    )


def _in_metres(value: float | None) -> float | None:
    return None if value is None else value / MM_PER_M
