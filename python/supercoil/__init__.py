"""Equilibria of elastic rods that touch themselves and each other: DNA loops, plectonemes, knots, plies, cables."""

from . import contact
from ._sweep import SweepPlan, SweepResult, sweep
from .errors import InputError, SolveError, SupercoilError
from .scene import (
    EquilibriumPath,
    LineLoad,
    Load,
    PathPoint,
    Plane,
    Result,
    Rod,
    Scene,
    Solver,
    Stage,
    StepReport,
    Support,
)
from .state import State

__all__ = [
    "EquilibriumPath",
    "InputError",
    "LineLoad",
    "Load",
    "PathPoint",
    "Plane",
    "Result",
    "Rod",
    "Scene",
    "SolveError",
    "Solver",
    "Stage",
    "State",
    "StepReport",
    "SupercoilError",
    "Support",
    "SweepPlan",
    "SweepResult",
    "contact",
    "sweep",
]
