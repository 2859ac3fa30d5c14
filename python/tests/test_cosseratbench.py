"""The adapter for cosseratbench: its static experiments run and score, the others are unsupported by name."""

import numpy as np
import pytest

cosseratbench = pytest.importorskip("cosseratbench")

from cosseratbench import registry  # noqa: E402
from cosseratbench.experiment import Result, run  # noqa: E402
from cosseratbench.scenario import Cylinder, EndCondition, Material, Plane, Rod, Scenario  # noqa: E402

from supercoil._cosseratbench import Supercoil  # noqa: E402


def result(experiment: str, **values: float) -> Result:
    return run(registry.load_experiment(experiment), registry.load_solver("supercoil"), values=values)


def test_it_is_found_by_its_entry_point() -> None:
    assert "supercoil" in registry.names(registry.SOLVERS)


@pytest.mark.parametrize(
    ("experiment", "metric", "limit"),
    [("cantilever", "tip_deflection_error", 1e-3), ("catenary", "shape_error", 5e-4), ("catenary", "sag_error", 5e-4)],
)
def test_static_experiments_score(experiment: str, metric: str, limit: float) -> None:
    scored = result(experiment)
    assert scored.outcome == "completed" and scored.metrics[metric] < limit and scored.metrics["settling_residual"] == 0.0


def test_crossing_ends_below_the_symmetric_state() -> None:
    # ropes that are pressed little lie across each other's middle; others slide off it, see the page
    assert result("crossing", drop=0.05).metrics["shape_error"] < 1e-3
    slid = result("crossing")
    assert slid.outcome == "completed" and 0.04 < slid.metrics["shape_error"] < 0.06


@pytest.mark.parametrize(
    ("experiment", "reason"),
    [("pendulum", "dynamics"), ("capstan", "friction"), ("pile", "friction"), ("twist", "an end driven in time")],
)
def test_what_is_outside_the_model_is_unsupported_by_name(experiment: str, reason: str) -> None:
    refused = result(experiment)
    assert refused.outcome == "unsupported" and reason in refused.missing[0]


def test_rods_rest_on_planes_and_cylinders() -> None:
    """A beam clamped above a plane and a cylinder sinks onto both; its directors stay perpendicular to it."""
    rod = Rod(
        centerline=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        radius=0.01,
        material=Material(1e6, 1e6 / 3.0, 1000.0),
        start=EndCondition.CLAMPED,
    )
    floor = Plane(point=(0.0, 0.0, -0.2), normal=(0.0, 0.0, 2.0))
    post = Cylinder(center=(0.3, 0.0, -0.1), axis=(0.0, 1.0, 0.0), radius=0.05, length=1.0)
    scenario = Scenario(rods=(rod,), duration=1.0, gravity=(0.0, 0.0, -9.81), obstacles=(floor, post), quasi_static=True)
    trajectory = Supercoil().run(scenario, n_elements=40, n_frames=3)
    nodes, directors = trajectory.positions[0], trajectory.directors[0]
    assert nodes[-1, :, 2].min() == pytest.approx(-0.19, abs=1e-4)
    assert np.hypot(nodes[-1, :, 0] - 0.3, nodes[-1, :, 2] + 0.1).min() > 0.06 - 1e-4
    assert np.allclose(directors[0], rod.directors(40)) and np.allclose(np.linalg.norm(directors, axis=2), 1.0)
    assert np.abs((directors[-1] * np.diff(nodes[-1], axis=0)).sum(axis=1)).max() < 1e-12
    short = Cylinder(center=(0.3, 1.0, -0.1), axis=(0.0, 1.0, 0.0), radius=0.05, length=1.0)
    with pytest.raises(NotImplementedError, match="the end of a cylinder"):
        beyond = Scenario(rods=(rod,), duration=1.0, gravity=(0.0, 0.0, -9.81), obstacles=(short,), quasi_static=True)
        Supercoil().run(beyond, n_elements=40, n_frames=3)
