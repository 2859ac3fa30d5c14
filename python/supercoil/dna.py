"""Parameters of base-pair steps from arrays, as ``sequence={"letters": …, "steps": table}`` takes them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._inputs import numbers
from .errors import InputError

__all__ = ["cgna", "steps"]

_NAMES = ("tilt", "roll", "twist", "shift", "slide", "rise")
#: Coordinates of a base pair and a step that have no place in a rod: a step's six begin after them.
_BEFORE_STEP = {True: 12, False: 6}
#: Step of the central differences, in units of about a tenth of a radian and an Å: their error is 1e-10.
_DIFFERENCE = 1e-5

Floats = NDArray[np.float64]


def steps(means: ArrayLike, stiffness: ArrayLike) -> dict[str, Floats]:
    """A table of the n steps of a molecule in their order: a dict of arrays (n,), for ``"steps"`` of a rod's ``sequence``.

    ``means`` (n, 6): tilt, roll, twist [degrees], shift, slide, rise [Å] in 3DNA's convention. ``stiffness`` (n, 6, 6), or (6, 6)
    for all: force constants [kT/deg², kT/(deg Å), kT/Å²]. A rod of n + 1 base pairs has n steps, a closed one of n as many.

    Raises :class:`supercoil.InputError` for other shapes and numbers that are not finite.
    """
    of_means = numbers("means", means)
    if of_means.ndim != 2 or of_means.shape[1] != 6:
        raise InputError(f"means: has shape {of_means.shape}: must be (n, 6)")
    count = len(of_means)
    constants = numbers("stiffness", stiffness)
    if constants.shape not in ((6, 6), (count, 6, 6)):
        raise InputError(f"stiffness: has shape {constants.shape}: must be (6, 6) or ({count}, 6, 6)")
    for name, array in (("means", of_means), ("stiffness", constants)):
        bad = np.argwhere(~np.isfinite(array))
        if len(bad):
            place = ", ".join(str(int(k)) for k in bad[0])
            raise InputError(f"{name}[{place}] = {array[tuple(bad[0])]}: must be finite")
    constants = np.broadcast_to(constants, (count, 6, 6))
    table: dict[str, Any] = {"step": np.arange(1, count + 1)}
    table |= {name: of_means[:, k] for k, name in enumerate(_NAMES)}
    for i, a in enumerate(_NAMES):
        for j, b in enumerate(_NAMES[: i + 1]):
            table[f"{b}_{a}"] = 0.5 * (constants[:, i, j] + constants[:, j, i])
    return table


def cgna(shape: ArrayLike, stiffness: Any, phosphates: bool = True) -> dict[str, Floats]:
    """The table of :func:`steps`, a dict of arrays (n,), from the ground state of cgNA+ and its stiffness, as its programs give them for one molecule.

    ``shape`` (24 N − 18,) for N base pairs: of each the six of the pair, six of a phosphate, the six of the step, six of the other
    phosphate; rotations as Cayley vectors [rad/5], translations [Å]. (24 N,) is a closed molecule. ``phosphates=False``: cgDNA's
    (12 N − 6,), without them. ``stiffness``: the matrix to it, kT the unit of energy, an array or a SciPy sparse matrix.

    Each step keeps its own 6 × 6 with all others free: the inverse of its block of the covariance, the stiffness that a marginal
    distribution of the step has. What is lost: that a step's parameters depend on those of its neighbours, so a molecule that is
    bent over several steps is softer or stiffer here than in cgNA+. Cayley vectors become 3DNA's tilt, roll, twist.

    Raises :class:`supercoil.InputError` for other shapes, and for a matrix that is not positive definite.
    """
    ground = numbers("shape", shape).ravel()
    period = 24 if phosphates else 12
    size = len(ground)
    left = size % period
    if size < period or left not in (0, 6):
        raise InputError(f"shape: has {size} entries: must be {period} N − {period - 6} for N base pairs, or {period} N")
    if tuple(stiffness.shape) != (size, size):
        raise InputError(f"stiffness: has shape {tuple(stiffness.shape)}: must be ({size}, {size}), as shape has {size}")
    begins = range(_BEFORE_STEP[phosphates], size, period)
    found = [_step(ground[k : k + 6], block) for k, block in zip(begins, _marginals(stiffness, begins), strict=True)]
    return steps([mean for mean, _ in found], [constants for _, constants in found])


def _marginals(stiffness: Any, begins: range) -> list[Floats]:
    """Stiffness of each step with everything else free."""
    if hasattr(stiffness, "tocsc"):
        from scipy.sparse.linalg import splu  # whoever has a sparse matrix has SciPy

        solve = splu(stiffness.tocsc().astype(float)).solve
    else:
        covariance = np.linalg.inv(np.asarray(stiffness, dtype=float))

        def solve(columns: Floats) -> Floats:
            return covariance @ columns

    blocks = []
    for k in begins:
        unit = np.zeros((stiffness.shape[0], 6))
        unit[k : k + 6] = np.eye(6)
        block = solve(unit)[k : k + 6]
        block = 0.5 * (block + block.T)
        if np.linalg.eigvalsh(block)[0] <= 0.0:
            raise InputError(f"stiffness: the covariance of the step at [{k}] is not positive definite")
        blocks.append(np.linalg.inv(block))
    return blocks


def _step(coordinates: Floats, stiffness: Floats) -> tuple[Floats, Floats]:
    """Mean and force constants in 3DNA's parameters of a step with these coordinates."""
    columns = []
    for k in range(6):
        change = _DIFFERENCE * np.eye(6)[k]
        difference = _parameters(coordinates + change) - _parameters(coordinates - change)
        columns.append(difference / (2 * _DIFFERENCE))
    back = np.linalg.inv(np.stack(columns, axis=1))
    return _parameters(coordinates), back.T @ stiffness @ back


def _about(axis: Floats, angle: float) -> Floats:
    """The rotation about a unit axis."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation: Floats = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return rotation


def _parameters(coordinates: Floats) -> Floats:
    """Tilt, roll, twist [degrees], shift, slide, rise [Å] (El Hassan and Calladine 1995) of a step whose rotation by θ about n is the
    Cayley vector 10 tan(θ/2) n, and whose translation stands in the frame turned half way."""
    cayley, translation = coordinates[:3], coordinates[3:]
    size = float(np.linalg.norm(cayley))
    axis = cayley / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
    angle = 2.0 * np.arctan(size / 10.0)
    turn, place = _about(axis, angle), _about(axis, angle / 2) @ translation
    # turn = Rz(twist/2 − phase) Ry(bend) Rz(twist/2 + phase)
    bend = np.arctan2(np.hypot(turn[0, 2], turn[1, 2]), turn[2, 2])
    if bend < 1e-9:
        first, last = np.arctan2(turn[1, 0], turn[0, 0]), 0.0
    else:
        first, last = np.arctan2(turn[1, 2], turn[0, 2]), np.arctan2(turn[2, 1], -turn[2, 0])
    twist = np.angle(np.exp(1j * (first + last)))
    # both angles are known modulo a turn
    phase = twist / 2 - first if bend >= 1e-9 else 0.0
    y, z = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    middle = _about(z, twist / 2 - phase) @ _about(y, bend / 2) @ _about(z, phase)
    angles = np.degrees([bend * np.sin(phase), bend * np.cos(phase), twist])
    return np.concatenate([angles, middle.T @ place])
