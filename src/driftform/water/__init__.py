"""The environment as data: pipe, flow, fluid, release, contact, targets, and their disturbances."""

from driftform.water.factors import Calibration, Factors
from driftform.water.flow import (
    FLOWS,
    DevelopingFlow,
    Flow,
    GridFlow,
    LogLawFlow,
    PipeFlow,
    PowerLawFlow,
    TurbulentFlow,
    UniformFlow,
)
from driftform.water.pipe import Number, Pipe, Segment, Vector
from driftform.water.scenario import (
    Contact,
    FlightLimits,
    Fluid,
    Release,
    Robustness,
    Scenario,
    evaluation_seed,
)

__all__ = [
    "FLOWS",
    "Calibration",
    "Contact",
    "DevelopingFlow",
    "Factors",
    "FlightLimits",
    "Flow",
    "Fluid",
    "GridFlow",
    "LogLawFlow",
    "Number",
    "Pipe",
    "PipeFlow",
    "PowerLawFlow",
    "Release",
    "Robustness",
    "Scenario",
    "Segment",
    "TurbulentFlow",
    "UniformFlow",
    "Vector",
    "evaluation_seed",
]
