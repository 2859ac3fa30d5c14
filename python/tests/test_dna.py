"""Parameters of steps from arrays: 3DNA's, and those of cgNA+."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from supercoil import InputError, Rod, Scene, dna

from test_readers import rotation

#: Three steps as 3DNA has them: degrees, Å.
MEANS = np.array([[3.0, 8.0, 32.0, 0.4, -0.6, 3.3], [-4.0, 1.0, 36.0, -0.2, 0.1, 3.4], [0.0, 0.0, 34.3, 0.0, 0.0, 3.4]])
X, Y, Z = np.eye(3)


def pose(parameters: Any) -> tuple[Any, Any]:
    """Rotation and translation of a step (El Hassan and Calladine 1995)."""
    tilt, roll, twist, *along = parameters
    bend, phase = np.hypot(tilt, roll), np.degrees(np.arctan2(tilt, roll))
    first, last = rotation(Z, twist / 2 - phase), rotation(Z, twist / 2 + phase)
    middle = first @ rotation(Y, bend / 2) @ rotation(Z, phase)
    return first @ rotation(Y, bend) @ last, middle @ np.array(along)


def coordinates(parameters: Any) -> Any:
    """The same step as cgNA+ has it: (R − Rᵀ)/(1 + tr R) is the cross matrix of tan(θ/2) n."""
    turn, place = pose(parameters)
    skew = (turn - turn.T) / (1 + np.trace(turn))
    half = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    angle = np.degrees(np.arctan(np.linalg.norm(half)))
    return np.concatenate([10 * half, rotation(half / np.linalg.norm(half), angle).T @ place])


def ground_state(means: Any, period: int, closed: bool) -> Any:
    """The steps among coordinates that do not matter."""
    pairs = len(means) + (not closed)
    shape = np.random.default_rng(1).normal(size=period * pairs)
    for k, mean in enumerate(means):
        begin = period * k + period // 2
        shape[begin : begin + 6] = coordinates(mean)
    return shape if closed else shape[: period * pairs - period + 6]


def matrix(size: int) -> Any:
    """A positive definite matrix in which neighbours are coupled."""
    band = np.random.default_rng(2).normal(size=(size, size)) * (np.abs(np.subtract.outer(range(size), range(size))) < 18)
    return band @ band.T + 20 * np.eye(size)


@pytest.mark.parametrize(("period", "closed"), [(24, False), (24, True), (12, False)])
def test_steps_of_cgna_are_those_of_3dna(period: int, closed: bool) -> None:
    shape = ground_state(MEANS, period, closed)
    table = dna.cgna(shape, matrix(len(shape)), phosphates=period == 24)
    found = np.stack([table[name] for name in ("tilt", "roll", "twist", "shift", "slide", "rise")], axis=1)
    assert np.allclose(found, MEANS, atol=1e-9)


def test_energies_are_those_of_the_marginal_distribution() -> None:
    """Of a small change of a step, all else free, by either set of parameters."""
    shape = ground_state(MEANS, 24, False)
    stiffness = matrix(len(shape))
    table = dna.cgna(shape, stiffness)
    names = ("tilt", "roll", "twist", "shift", "slide", "rise")
    swapped = {"_".join(reversed(name.split("_"))): column for name, column in table.items()}
    for k, mean in enumerate(MEANS):
        constants = np.array([[(table | swapped)[f"{a}_{b}"][k] for a in names] for b in names])
        change = 1e-5 * np.random.default_rng(k).normal(size=6)
        moved = coordinates(mean + change) - coordinates(mean)
        begin = 24 * k + 12
        others = [i for i in range(len(shape)) if not begin <= i < begin + 6]
        own = list(range(begin, begin + 6))
        # what is left when the others give way: the Schur complement
        free = stiffness[np.ix_(own, own)] - stiffness[np.ix_(own, others)] @ np.linalg.solve(
            stiffness[np.ix_(others, others)], stiffness[np.ix_(others, own)]
        )
        assert change @ constants @ change == pytest.approx(moved @ free @ moved, rel=1e-4)


def test_sparse_matrices_are_taken() -> None:
    sparse = pytest.importorskip("scipy.sparse")
    shape = ground_state(MEANS, 24, False)
    stiffness = matrix(len(shape))
    dense, thin = dna.cgna(shape, stiffness), dna.cgna(shape, sparse.csr_matrix(stiffness))
    assert all(np.allclose(dense[name], thin[name]) for name in dense)


def test_a_rod_has_the_steps_of_its_table() -> None:
    stiffness = np.diag([0.04, 0.04, 0.06, 20.0, 20.0, 20.0])
    means = np.tile([0.0, 2.0, 34.0, 0.0, 0.0, 3.4], (20, 1))
    table = dna.steps(means, stiffness)
    rod = Rod(shape={"kind": "line", "length": 6.8}, sequence={"letters": "A" * 21, "steps": table}, section={"contact_radius": 0.0})
    state = Scene(rod).run().state
    # twenty steps of 34° turn about an axis that a roll of 2° tilts
    assert state.twist * 360 / 20 == pytest.approx(34.0, abs=0.2)
    assert state.energies["total"] < 1e-6


@pytest.mark.parametrize(
    ("make", "arrays", "text"),
    [
        (dna.steps, (np.zeros((3, 5)), np.eye(6)), r"means: has shape \(3, 5\): must be \(n, 6\)"),
        (dna.steps, (MEANS, np.zeros((2, 6, 6))), r"stiffness: has shape \(2, 6, 6\): must be \(6, 6\) or \(3, 6, 6\)"),
        (dna.steps, (MEANS * np.nan, np.eye(6)), r"means\[0, 0\] = nan: must be finite"),
        (dna.cgna, (np.zeros(25), np.eye(25)), r"shape: has 25 entries: must be 24 N − 18"),
        (dna.cgna, (np.zeros(30), np.eye(31)), r"stiffness: has shape \(31, 31\): must be \(30, 30\)"),
        (dna.cgna, (np.ones(30), -np.eye(30)), r"the covariance of the step at \[12\] is not positive definite"),
    ],
)
def test_arrays_of_another_shape_are_refused(make: Callable[..., Any], arrays: tuple[Any, Any], text: str) -> None:
    with pytest.raises(InputError, match=text):
        make(*arrays)
