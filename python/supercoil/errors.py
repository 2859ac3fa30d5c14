"""Exceptions of supercoil. A run that merely does not converge raises none: its result has a status."""


class SupercoilError(Exception):
    """Whatever supercoil refuses or fails at."""


class InputError(SupercoilError, ValueError):
    """Input that was refused: the text names the key, the value and what is allowed."""


class SolveError(SupercoilError, ArithmeticError):
    """Numbers that broke down during a run."""
