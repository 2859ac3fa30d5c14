"""Equilibria of elastic rods that touch themselves and each other: DNA loops, plectonemes, knots, plies, cables."""

from importlib.metadata import PackageNotFoundError, version

from . import contact, dna
from ._differentiable import Equilibria
from ._sweep import SweepPlan, SweepResult, sweep
from .errors import InputError, SolveError, SupercoilError
from .scene import (
    EquilibriumPath,
    Joint,
    LineLoad,
    Load,
    PathPoint,
    Obstacle,
    Plane,
    Result,
    Rod,
    Scene,
    Solver,
    Stage,
    Step,
    StepReport,
    Support,
)
from .state import Modes, State

try:
    __version__ = version("supercoil")
except PackageNotFoundError:  # sources that were not installed
    __version__ = "0+unknown"

__all__ = [
    "Equilibria",
    "EquilibriumPath",
    "InputError",
    "Joint",
    "LineLoad",
    "Load",
    "Modes",
    "PathPoint",
    "Obstacle",
    "Plane",
    "Result",
    "Rod",
    "Scene",
    "SolveError",
    "Solver",
    "Stage",
    "State",
    "Step",
    "StepReport",
    "SupercoilError",
    "Support",
    "SweepPlan",
    "SweepResult",
    "__version__",
    "contact",
    "dna",
    "sweep",
]
