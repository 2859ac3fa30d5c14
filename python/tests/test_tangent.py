"""What the tangent knows, from Python."""

from __future__ import annotations

import numpy as np
import pytest

import supercoil
from supercoil import Rod, Scene, Stage

SECTION = {"bending": 1.0, "twisting": 1.5, "stretching": 1e8, "shearing": 1e8, "contact_radius": 0.0}


def ring() -> supercoil.Solver:
    rod = Rod(name="ring", closed=True, shape={"kind": "circle", "length": 1.0}, section=SECTION, elements=16)
    solver = Scene([rod], stages=[Stage(excess_link=0.4)]).solver()
    assert solver.step_to(excess_link=0.4).converged
    return solver


def test_modes_of_a_twisted_ring() -> None:
    modes = ring().modes(4)
    flat = (2 * np.pi) ** 4 * 36 / np.array([5.0, 5.0, 4 + 1 / 1.5, 4 + 1 / 1.5])
    ratio = (1 - 0.6**2 / 3) ** 2
    assert modes.eigenvalues.prod() == pytest.approx(flat.prod() * ratio, rel=1e-3)
    assert modes.displacements.shape == (4, 48, 3) and modes.participation.sum(axis=1) == pytest.approx(1.0)


def test_gradient_and_free_energy_of_a_twisted_ring() -> None:
    solver = ring()
    energy = solver.gradient("energy", ["link", "twisting:ring"])
    assert energy == pytest.approx([4 * np.pi**2 * 1.5 * 0.4, 2 * np.pi**2 * 0.4**2], rel=1e-5)
    assert solver.free_energy(0.02) - solver.free_energy(0.02, contacts="locked") == 0.0
    assert solver.covariance(["twist"], 0.02).shape == (1, 1)
    with pytest.raises(supercoil.InputError, match="extension"):
        solver.gradient("writing", ["load"])
