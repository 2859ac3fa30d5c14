"""Scenes: made of objects, read from text and files, refused with key and value; the solver by hand; contact alone."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from supercoil import InputError, LineLoad, Load, Plane, Rod, Scene, Stage, SupercoilError, Support, contact

ROOT = Path(__file__).parents[2]
SECTION = {"bending": 1.0, "twisting": 1.5, "stretching": 1e6, "shearing": 1e6, "contact_radius": 0.0}
LINE = {"kind": "line", "length": 1.0, "start": [0, 0, 0], "direction": [1, 0, 0]}


def cantilever(**more: object) -> Scene:
    """A rod of length 1 clamped at its start."""
    rod = Rod(shape=LINE, section=SECTION, elements=8)
    return Scene(rod, supports=[Support(at="start", position=True, rotation=True)], **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["minicircle", "elastica", "cable", "ring_pressure"])
def test_examples_are_read_and_kept(name: str) -> None:
    path = ROOT / "examples" / f"{name}.toml"
    scene = Scene.from_toml(path)
    assert scene.to_toml() == path.read_text() and scene.rods[0]["num_nodes"] > 1
    assert pickle.loads(pickle.dumps(scene)).rods == scene.rods


def test_objects_become_the_text_they_say() -> None:
    load = Load(at="end", force=np.array([0.0, 0.01, 0.0]))
    scene = cantilever(loads=[load], line_loads=[LineLoad(force=(0, 0.001, 0))], stages=[Stage(load=1.0, steps=2)])
    again = Scene.from_toml(scene.to_toml())
    a, b = scene.run().state, again.run().state
    assert np.array_equal(a.positions, b.positions)
    # Euler and Bernoulli: F L³/3EI + f L⁴/8EI
    assert a.positions[-1, 1] == pytest.approx(0.01 / 3 + 0.001 / 8, rel=1e-3)


def test_planes_push_rods() -> None:
    section = {"bending": 1.0, "twisting": 1.0, "stretching": 1e4, "shearing": 1e4, "contact_radius": 0.05}
    ring = Rod(closed=True, shape={"kind": "circle", "radius": 1.0}, section=section, elements=16)
    planes = [
        Plane(name="lower", point=(0, -1.05, 0), normal=(0, 1, 0)),
        Plane(name="upper", point=(0, 1.05, 0), normal=(0, -1, 0)),
    ]
    stage = Stage(plane={"name": "upper", "to": 0.1}, steps=2)
    state = Scene(ring, planes=planes, stages=stage, planar=True).run().state
    lower, upper = state.plane_reactions
    assert upper["displacement"] == 0.1 and lower["force"] == pytest.approx(upper["force"], rel=1e-6)
    # F = δ B / (R³ (π/4 − 2/π)) of a ring that is hardly pressed
    assert lower["force"] == pytest.approx(0.1 / (np.pi / 4 - 2 / np.pi), rel=0.1)


def test_minicircle_has_the_numbers_of_dna() -> None:
    scene = Scene.minicircle()
    (rod,) = scene.rods
    assert rod["length"] == pytest.approx(114.24) and rod["contact_radius"] == pytest.approx(2.5)
    assert "to = -1.92" in scene.to_toml()
    assert Scene.minicircle(salt_mM=1000).rods[0]["contact_radius"] == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Scene.minicircle(salt_mM=5), "sodium_chloride = 0.005: must be between 0.01 and 1"),
        (lambda: Scene.minicircle(base_pairs=0), "base_pairs = 0: must be at least 1"),
        (lambda: Scene.from_toml("rods = [\n"), "scene: TOML parse error"),
        (lambda: Scene.from_toml(ROOT / "nowhere.toml"), "nowhere.toml: No such file"),
        (lambda: cantilever(planer=True), "planer"),
        (lambda: cantilever(contact={"law": "penalty", "stiffness": -1.0}), "contact.stiffness = -1"),
        (lambda: cantilever(stages=Stage(displacement={"at": 900, "to": [0, 0, 0]})), "900"),
        (lambda: cantilever().run(threads=0), "threads = 0: must be at least 1"),
        (lambda: cantilever().solver().step_to(excess_link=1.0), "excess_link"),
        (lambda: contact.detect([contact.Curve(points=[[0, 0]], radius=1.0)]), r"curves\[0\].points: has 2 columns"),
        (lambda: contact.detect([contact.Curve(points=np.eye(3), radius=-1.0)]), "-1"),
    ],
)
def test_bad_input_is_refused_with_key_and_value(make, text: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises((InputError, TypeError), match=text):
        make()
    assert issubclass(InputError, SupercoilError) and issubclass(InputError, ValueError)


def test_the_solver_goes_by_hand() -> None:
    """The end is carried and turned: the reaction is that of the elastica, the start shape is given back."""
    shaft = {**SECTION, "twisting": 1.5}
    rod = Rod(shape=LINE, section=shaft, elements=8)
    ends = [Support(at=at, position=True, rotation=True) for at in ("start", "end")]
    solver = Scene(rod, supports=ends).solver()
    assert solver.settle().converged
    start = solver.state.positions
    for turns in (0.1, 0.25):
        report = solver.step_to(rotation={"at": "end", "axis": [1, 0, 0], "turns": turns})
        assert report.converged and report.iterations >= 1
    moment = solver.state.reactions[1]["moment"][0]
    assert moment == pytest.approx(1.5 * 2 * np.pi * 0.25, rel=1e-6)
    assert solver.num_unstable() == 0
    solver.step_to(rotation={"at": "end", "axis": [1, 0, 0], "turns": 0.0})
    assert np.allclose(solver.state.positions, start, atol=1e-9)


def test_link_numbers_want_one_closed_rod() -> None:
    state = cantilever().solver().state
    assert state.links == []
    with pytest.raises(AttributeError, match="link: must be of exactly one closed rod"):
        _ = state.link


def test_contact_of_a_ring_and_a_rod() -> None:
    t = np.linspace(0, 2 * np.pi, 101)[:-1]
    ring = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    rod = [[1.3, 0.0, -1.0], [1.3, 0.0, 1.0]]
    sites = contact.detect(
        [contact.Curve(points=ring, radius=0.1, closed=True), contact.Curve(points=rod, radius=[0.05])], range=0.5
    )
    assert sites["gap"] == pytest.approx([0.15]) and sites["normal"] == pytest.approx(np.array([[1.0, 0, 0]]))
    assert sites["curve_a"].tolist() == [0] and sites["curve_b"].tolist() == [1]
    assert contact.detect([contact.Curve(points=rod, radius=0.1)])["normal"].shape == (0, 3)


def test_link_and_writhe_of_polygons() -> None:
    t = np.linspace(0, 2 * np.pi, 41)[:-1]
    ring = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    other = np.stack([1 + np.cos(t), 0 * t, np.sin(t)], axis=1)
    assert abs(contact.link(ring, other)) == pytest.approx(1.0)
    assert contact.link(ring, other + [5, 0, 0]) == pytest.approx(0.0)
    assert contact.link(ring, other[::-1]) == pytest.approx(-contact.link(ring, other))
    eight = np.stack([np.sin(t), np.sin(2 * t), 0.1 * np.cos(t)], axis=1)
    mirrored = eight * [1, 1, -1]
    assert contact.writhe(ring) == pytest.approx(0.0, abs=1e-12)
    assert contact.writhe(eight) == pytest.approx(-contact.writhe(mirrored)) and abs(contact.writhe(eight)) > 0.5


def test_tables_become_data_frames() -> None:
    pandas = pytest.importorskip("pandas")
    result = cantilever().run()
    frame = result.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and list(frame.columns) == list(result.table)


def test_states_become_polydata() -> None:
    pytest.importorskip("pyvista")
    t = {"kind": "circle", "length": 1.0}
    rods = [
        Rod(name="ring", closed=True, shape=t, section=SECTION, elements=4),
        Rod(name="line", shape=LINE, section=SECTION, elements=2),
    ]
    state = Scene(rods).solver().state
    mesh = state.to_pyvista()
    assert mesh.n_points == 12 + 7 and mesh.n_lines == 2
    assert mesh.lines.tolist() == [13, *range(12), 0, 7, *range(12, 19)]
    assert np.array_equal(mesh.point_data["d3"], state.frames[:, 2])
