"""What the tangent knows, from Python."""

from __future__ import annotations

import numpy as np
import pytest

import supercoil
from supercoil import Rod, Scene, Stage

SECTION = {"bending": 1.0, "twisting": 1.5, "stretching": 1e8, "shearing": 1e8, "contact_radius": 0.0}


def ring(link: float = 0.4) -> supercoil.Solver:
    rod = Rod(name="ring", closed=True, shape={"kind": "circle", "length": 1.0}, section=SECTION, elements=16)
    solver = Scene([rod], stages=[Stage(excess_link=link)]).solver()
    assert solver.step_to(excess_link=link).converged
    return solver


def test_modes_of_a_twisted_ring() -> None:
    modes, flat = ring().modes(4), ring(0.0).modes(4)
    # the four modes of two waves: (1 - x²/3)² with x = 0.4 C/B
    assert modes.eigenvalues.prod() / flat.eigenvalues.prod() == pytest.approx((1 - 0.6**2 / 3) ** 2, rel=1e-4)
    assert modes.displacements.shape == (4, 48, 3) and modes.participation.sum(axis=1) == pytest.approx(1.0)


def test_gradient_and_free_energy_of_a_twisted_ring() -> None:
    solver = ring()
    energy = solver.gradient("energy", ["link", "twisting:ring"])
    assert energy == pytest.approx([4 * np.pi**2 * 1.5 * 0.4, 2 * np.pi**2 * 0.4**2], rel=1e-5)
    assert solver.free_energy(0.02) - solver.free_energy(0.02, contacts="locked") == 0.0
    assert solver.covariance(["twist"], 0.02).shape == (1, 1)
    with pytest.raises(supercoil.InputError, match="extension"):
        solver.gradient("writing", ["load"])
