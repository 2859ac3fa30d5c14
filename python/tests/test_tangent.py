"""What the tangent knows, from Python."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import supercoil
from supercoil import Equilibria, Load, Rod, Scene, Stage, State, Support
from supercoil.state import Floats

SECTION = {"bending": 1.0, "twisting": 1.5, "stretching": 1e8, "shearing": 1e8, "contact_radius": 0.0}


def ring(link: float = 0.4) -> State:
    rod = Rod(name="ring", closed=True, shape={"kind": "circle", "length": 1.0}, section=SECTION, elements=16)
    solver = Scene([rod], stages=[Stage(excess_link=link)]).solver()
    assert solver.step_to(excess_link=link).converged
    return solver.state


def test_modes_of_a_twisted_ring() -> None:
    state = ring()
    modes, flat = state.modes(4), ring(0.0).modes(4)
    # the four modes of two waves: (1 - x²/3)² with x = 0.4 C/B
    assert modes.eigenvalues.prod() / flat.eigenvalues.prod() == pytest.approx((1 - 0.6**2 / 3) ** 2, rel=1e-4)
    assert modes.displacements.shape == (4, 48, 3) and modes.participation.sum(axis=1) == pytest.approx(1.0)
    assert modes.frequencies is None
    with pytest.raises(supercoil.InputError, match="pickled"):
        pickle.loads(pickle.dumps(state)).modes(4)


def test_gradient_and_free_energy_of_a_twisted_ring() -> None:
    state = ring()
    energy = state.gradient("energy", ["link", "twisting:ring"])
    assert energy == pytest.approx([4 * np.pi**2 * 1.5 * 0.4, 2 * np.pi**2 * 0.4**2], rel=1e-5)
    assert state.gradient("energy", "link") == pytest.approx(energy[0], rel=1e-12)
    assert state.free_energy(0.02) - state.free_energy(0.02, contacts="locked") == 0.0
    assert state.covariance(["twist"], 0.02).shape == (1, 1)
    soft, warm = state.anharmonicity(1e-6), state.anharmonicity(20.0)
    assert soft.max() < 0.01 < warm.max()
    assert state.one_sided() == []
    with pytest.raises(supercoil.InputError, match="extension"):
        state.gradient("writing", ["load"])
    with pytest.raises(supercoil.InputError, match="kT"):
        state.free_energy()


def cantilever(values: Floats) -> State:
    bending, load = values
    section = {**SECTION, "bending": float(bending), "stretching": 1e4, "shearing": 1e4}
    rod = Rod(name="rod", shape={"kind": "line", "length": 1.0}, section=section, elements=8)
    clamp = Support(rod="rod", at="start", position=True, rotation=True)
    scene = Scene([rod], supports=[clamp], loads=[Load(rod="rod", at="end", force=(0.0, 0.0, -1.0))])
    solver = scene.solver()
    assert solver.step_to(load=float(load)).converged
    return solver.state


EQUILIBRIA = Equilibria(cantilever, ["energy", "position_z:rod:end"], ["bending", "load"])
POINT = np.array([1.2, 0.7])


def differences() -> Floats:
    steps = 1e-4 * np.eye(2)
    return np.stack([(EQUILIBRIA(POINT + step) - EQUILIBRIA(POINT - step)) / 2e-4 for step in steps], axis=1)


def test_equilibria_as_a_function() -> None:
    values, jacobian = EQUILIBRIA.with_jacobian(POINT)
    assert values.shape == (2,) and jacobian == pytest.approx(differences(), rel=1e-5)


def test_torch() -> None:
    torch = pytest.importorskip("torch")
    point = torch.tensor(POINT, requires_grad=True)
    EQUILIBRIA.torch()(point)[1].backward()
    assert point.grad.numpy() == pytest.approx(differences()[1], rel=1e-5)


def test_jax() -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    slope = jax.jit(jax.grad(lambda values: EQUILIBRIA.jax()(values)[1]))(POINT)
    assert np.asarray(slope) == pytest.approx(differences()[1], rel=1e-5)


def test_rows_of_a_table(tmp_path: Path) -> None:
    def tip(row: int, by: float) -> State:
        curvature = [0.4, -0.2, 0.3, 0.1, 0.5]
        curvature[row] += by
        lines = [f"{k / 5},{(k + 1) / 5},{kappa},0,0.2" for k, kappa in enumerate(curvature)]
        path = tmp_path / "natural.csv"
        path.write_text("\n".join(["from,to,kappa1,kappa2,kappa3", *lines, ""]))
        rod = Rod(name="rod", shape={"kind": "line", "length": 1.0}, section=SECTION, elements=7, natural={"table": str(path)})
        clamp = Support(rod="rod", at="start", position=True, rotation=True)
        return Scene([rod], supports=[clamp]).run().state

    slopes = tip(0, 0.0).gradient("position_y:rod:end", "natural_strains")
    assert slopes.shape == (5, 6)
    for row in (1, 4):
        ends = [float(tip(row, by).positions[-1, 1]) for by in (-1e-3, 1e-3)]
        assert slopes[row, 3] == pytest.approx((ends[1] - ends[0]) / 2e-3, rel=1e-5)
