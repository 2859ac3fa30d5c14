"""Scenes: made of objects, read from text and files, refused with key and value; the solver by hand; contact alone."""

import dataclasses
import inspect
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import supercoil
from supercoil import (
    InputError,
    Joint,
    LineLoad,
    Load,
    Obstacle,
    Plane,
    Rod,
    Scene,
    Stage,
    SupercoilError,
    Support,
    contact,
    dna,
)
from supercoil._inputs import schema

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
    lower, upper = state.obstacle_reactions
    assert upper["placement"]["level"] == 0.1 and lower["force"] == pytest.approx(upper["force"], rel=1e-6)
    # F = δ B / (R³ (π/4 − 2/π)) of a ring that is hardly pressed
    assert lower["force"] == pytest.approx(0.1 / (np.pi / 4 - 2 / np.pi), rel=0.1)


def test_obstacles_hold_and_move_rods() -> None:
    section = {"bending": 1.0, "twisting": 1.0, "stretching": 1e4, "shearing": 1e4, "contact_radius": 0.05}
    ring = Rod(closed=True, shape={"kind": "circle", "radius": 1.0}, section=section, elements=16)
    hinge = {"through": (0, 5, 0), "axis": (0, 0, 1)}
    bodies = [
        Obstacle(name="post", shape="cylinder", point=(0, 0, 0), axis=(0, 0, 1), radius=0.5, hinge=hinge),
        Obstacle(name="cavity", shape="sphere", side="inside", radius=3.0),
    ]
    moves = [{"name": "post", "radius": 0.6, "turns": 0.02, "displacement": (0.1, 0, 0)}, {"name": "cavity", "radius": 2.0}]
    scene = Scene(ring, obstacles=bodies, stages=Stage(obstacle=moves, steps=2))
    assert Scene.from_toml(scene.to_toml()).to_toml() == scene.to_toml()
    result = scene.run()
    post, cavity = result.state.obstacle_reactions
    assert result.status == "converged"
    assert post["placement"] == {"level": 0.6, "displacement": [0.1, 0.0, 0.0], "turns": 0.02, "rotation": [0.0, 0.0, 0.0]}
    assert cavity["placement"]["level"] == 2.0
    # by hand: a post lifts a cantilever by δ at a, F = 3 EI δ/a³
    beam = Rod(shape=LINE, section=section, elements=8)
    lifting = Obstacle(shape="cylinder", point=(0.8, -0.25, 0), axis=(0, 0, 1), radius=0.2)
    held = Support(at="start", position=True, rotation=True)
    solver = Scene(beam, obstacles=[lifting], supports=[held], planar=True).solver()
    solver.settle()
    report = solver.step_to(obstacle={"displacement": (0, 0.005, 0)})
    (push,) = solver.state.obstacle_reactions
    assert report.status == "converged" and push["force_on_rods"][1] == pytest.approx(0.015 / 0.8**3, rel=0.02)


def test_sweeps_change_obstacles(tmp_path: Path) -> None:
    section = {"bending": 1.0, "twisting": 1.0, "stretching": 1e4, "shearing": 1e4, "contact_radius": 0.05}
    ring = Rod(closed=True, shape={"kind": "circle", "radius": 1.0}, section=section, elements=16)
    cavity = Obstacle(name="cavity", shape="cylinder", side="inside", axis=(0, 0, 1), radius=1.1)
    stage = Stage(obstacle={"radius": 1.04}, steps=1)
    Scene(ring, obstacles=[cavity], stages=stage, planar=True).save(tmp_path / "scene.toml")
    axes = '"obstacles.cavity.radius" = [1.1, 0.9]\n"stages.0.ramp.obstacle.radius" = [1.045, 1.042]\n'
    (tmp_path / "sweep.toml").write_text(f'scene = "scene.toml"\n[axes]\n{axes}')
    table = supercoil.sweep(tmp_path / "sweep.toml").table
    # of each case that runs the start and a step; no ring fits in the smaller cavity
    assert list(table["status"]) == 4 * ["converged"] + 2 * ["refused"]
    # a ring that is compressed evenly: 2π EA (1 − λ)
    force = 2 * np.pi * 1e4 * np.array([0.005, 0.008])
    assert np.allclose(table["cavity_force"][[1, 3]], force, rtol=1e-2)


def test_minicircle_has_the_numbers_of_dna() -> None:
    scene = Scene.minicircle()
    (rod,) = scene.rods
    assert rod["length"] == pytest.approx(114.24) and rod["contact_radius"] == pytest.approx(2.5)
    assert "to = -1.92" in scene.to_toml()
    assert Scene.minicircle(salt_mM=1000).rods[0]["contact_radius"] == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Scene.minicircle(salt_mM=5), "salt_mM = 5: must be at least 10 and at most 1000 mmol/l"),
        (lambda: Scene.minicircle(elements=0), "^elements = 0: must be at least 1"),
        (lambda: Scene.minicircle(base_pairs=0), "base_pairs = 0: must be at least 1"),
        (lambda: Scene.from_toml("rods = [\n"), "scene: TOML parse error"),
        (lambda: Scene.from_toml(ROOT / "nowhere.toml"), "nowhere.toml: No such file"),
        (lambda: cantilever(planer=True), "planer"),
        (lambda: cantilever(contact={"law": "penalty", "stiffness": -1.0}), "contact.stiffness = -1"),
        (lambda: cantilever(stages=Stage(displacement={"at": 900, "to": [0, 0, 0]})), "900"),
        (lambda: cantilever().run(threads=0), "threads = 0: must be at least 1"),
        (lambda: cantilever().solver().step_to(excess_link=1.0), "^excess_link: rod \"rod\" is open"),
        (lambda: cantilever().solver().step_to(), "^nothing to do: ramp at least one of excess_link"),
        (lambda: cantilever().solver().follow(load=1.0, step=-1.0), "^step = -1.0: must be greater than 0"),
        (lambda: cantilever().solver().follow(load=1.0, start="back"), "^start = 'back': must be one of 'towards'"),  # type: ignore[arg-type]
        (lambda: cantilever().solver().state.modes(0), "^count = 0: must be at least 1"),
        (lambda: cantilever().solver().state.modes(contacts="loose"), "^contacts = 'loose': must be one of 'law'"),
        (lambda: cantilever().solver().state.free_energy(-1.0), "^kT = -1: must be a finite number greater than 0"),
        (lambda: cantilever().solver().step_to(rotation={"at": "end", "turn": 1}), "rotation.turn = 1: there is no such key"),
        (lambda: Scene(Rod(shape=LINE, section={"bendin": 1.0})), r"rods\[0\].section.bendin = 1.0: .*meant: bending\?"),
        (lambda: Scene(Rod(shape=LINE, section=SECTION, elements=2.5)), r"rods\[0\].elements = 2.5: must be an int"),  # type: ignore[arg-type]
        (lambda: Scene(Rod(shape=LINE, section=SECTION, order=7)), r"rods\[0\].order = 7: must be at least 1 and at most 3"),
        (lambda: Scene(Rod(shape=LINE, section={**SECTION, "bending": -1.0})), r"^rods\[0\].section.bending\[0\] = -1: must be"),
        (lambda: Scene(Rod(name="a.b", shape=LINE, section=SECTION, elements=8, closed=True)), r"^rods\[0\].shape: a line is open"),
        (lambda: Scene(Rod(shape=LINE, section=SECTION, natural={"table": "none.csv"})), r"^rods\[0\].natural.table = 'none.csv': there is no"),
        (lambda: Scene(Rod(shape=LINE, section=SECTION, natural={"table": np.eye(3)})), r"^rods\[0\].natural.table: must be .* found ndarray"),
        (lambda: contact.writhe("curve"), "^points: must be an array of numbers"),
        (lambda: dna.steps("means", np.eye(6)), "^means: must be an array of numbers"),
        (lambda: Scene(Rod(shape={"kind": "lime"})), r"rods\[0\].shape.kind = 'lime': must be one of 'line'"),
        (lambda: Scene(Rod(section=SECTION)), "Rod: needs exactly one of shape, points, frames, found none"),
        (lambda: Scene(Rod(points=np.zeros((5, 2)), section=SECTION)), r"points: has shape \(5, 2\)"),
        (lambda: Scene(Rod(points=np.array([[0, 0, 0], [1, np.nan, 0]]), section=SECTION)), r"points\[1, 1\] = nan"),
        (lambda: cantilever(fidelity="best"), "fidelity = 'best': must be one of 'draft', 'balanced', 'reference'"),
        (lambda: cantilever(temperature=-3.0), "temperature = -3.0: must be greater than 0 K"),
        (lambda: Scene(Rod(shape=LINE, section=SECTION), supports=[Support(at="middle")]), r"supports\[0\].at = 'middle'"),
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
    # of one open rod: that of the rod extended by straight lines
    assert state.link == pytest.approx(0.0, abs=1e-12) and state.twist == pytest.approx(0.0, abs=1e-12)
    two = Scene([Rod(name=name, shape=LINE, section=SECTION, elements=2) for name in "ab"]).solver().state
    with pytest.raises(AttributeError, match="link: must be of exactly one closed rod"):
        _ = two.link


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


def test_beads_and_grips_are_obstacles_of_their_rod() -> None:
    line = {"kind": "line", "length": 1.0}
    section = {"bending": 1.0, "twisting": 1.0, "stretching": 1e4, "shearing": 1e4, "contact_radius": 0.01}
    rod = Rod(shape=line, section=section, elements=4, beads=[{"at": 6, "radius": 0.05}])
    held = [
        Support(at="start", position=True, rotation=True, grip="endless"),
        Support(at="end", position=True, rotation=True, grip=0.3),
    ]
    reactions = Scene(rod, supports=held).run().state.obstacle_reactions
    assert [entry["placement"]["level"] for entry in reactions] == [0.05, 0.01, 0.01]
    with pytest.raises(InputError, match="grip"):
        Scene(rod, supports=[Support(at="start", position=True, rotation=True, grip="long")])  # type: ignore[arg-type]


def test_joints_bear_forces() -> None:
    section = {"bending": 1.0, "twisting": 1.0, "stretching": 1e4, "shearing": 1e4, "contact_radius": 0.0}
    rods = [
        Rod(name=name, elements=4, section=section, shape={"kind": "line", "start": [x, 0, 0], "length": 1.0})
        for name, x in (("a", 0.0), ("b", 1.0))
    ]
    clamp = Support(rod="a", at="start", position=True, rotation=True)
    load = Load(rod=["b"], at="end", force=(0.0, 0.0, -0.1))

    def moment(**more: Any) -> Any:
        joint = Joint(a={"rod": "a", "at": "end"}, b={"rod": "b", "at": "start"}, **more)
        on_a, on_b = Scene(rods, supports=[clamp], joints=[joint], loads=[load]).run().state.joints
        assert (on_a["rod"], on_b["rod"], on_a["point"], on_b["point"]) == (0, 1, 0, 0)
        assert np.allclose(on_b["force"], [0, 0, 0.1], atol=1e-9)
        assert np.allclose(np.add(on_a["moment"], on_b["moment"]), 0, atol=1e-9)
        return on_b["moment"]

    assert moment()[1] == pytest.approx(-0.1, rel=0.1)
    assert moment(kind="hinge", axis=(0, 0, 1))[1] == pytest.approx(-0.1, rel=0.1)
    assert np.allclose(moment(kind="pin"), 0, atol=1e-9)
    with pytest.raises(InputError, match="axis"):
        moment(kind="hinge")


KEYS = {
    Rod: ("RodText", {"points", "frames"}),
    Support: ("SupportText", set()),
    Joint: ("JointText", set()),
    Load: ("LoadText", set()),
    LineLoad: ("LineLoadText", set()),
    Plane: ("PlaneText", set()),
    Obstacle: ("ObstacleText", set()),
}


@pytest.mark.parametrize("kind", KEYS)
def test_classes_have_all_keys(kind: type) -> None:
    """The keys are those of scene files, whose schema the library makes from the types that read them."""
    name, more = KEYS[kind]
    names = {field.name for field in dataclasses.fields(kind)}
    assert names - more == set(schema()["$defs"][name]["properties"])


def test_scenes_and_stages_have_all_keys() -> None:
    parameters = set(inspect.signature(Scene.__init__).parameters) - {"self"}
    assert parameters == set(schema()["properties"])
    stage, ramp = (set(schema()["$defs"][name]["properties"]) for name in ("StageText", "RampText"))
    assert {field.name for field in dataclasses.fields(Stage)} == ramp | (stage - {"ramp"})
    solver = set(inspect.signature(supercoil.Solver.step_to).parameters) - {"self"}
    assert solver == ramp


def test_supports_come_and_go() -> None:
    """A cantilever whose end is held from the first stage on, carried, then let go: it springs back."""
    end = Support(at="end", position=True)
    scene = cantilever(
        stages=[
            Stage(hold=end, displacement={"at": "end", "to": [0, 0.1, 0]}, steps=2),
            Stage(release=end),
        ]
    )
    result = scene.run(keep="all")
    ends = [state.positions[-1, 1] for state in result.states]
    assert max(ends) == pytest.approx(0.1) and ends[-1] == pytest.approx(0.0, abs=1e-9)


def test_natural_curvature_and_length_are_ramped() -> None:
    stages = [Stage(natural={"curvature": [0.5, 0.0]}, steps=2), Stage(length=1.1)]
    state = cantilever(stages=stages).run().state
    # an arc of curvature 1/2 and length 1.1
    assert np.linalg.norm(state.positions[-1]) == pytest.approx(2 * 2 * np.sin(1.1 / 4), rel=1e-6)
    assert state.twist == pytest.approx(0.0, abs=1e-12)


def test_arrays_stand_for_files(tmp_path: Path) -> None:
    t = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    points = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    rod = Rod(closed=True, points=points, section=SECTION, elements=12, natural={"table": {"s": [0, 6.2831], "kappa1": [0.5, 0.5]}})
    with pytest.raises(InputError, match="natural: ends at s = 6.2831, but the rod is 6.28"):
        Scene(rod)
    scene = Scene(Rod(closed=True, points=points, section=SECTION, elements=12))
    assert scene.rods[0]["length"] == pytest.approx(2 * np.pi, rel=1e-5)
    again = pickle.loads(pickle.dumps(scene))
    assert again.rods == scene.rods
    scene.save(tmp_path / "ring.toml")
    assert Scene.from_toml(tmp_path / "ring.toml").rods == scene.rods
    frames = np.zeros((43, 4, 3))
    frames[:, 0, 2] = 0.34 * np.arange(43)
    frames[:, 1:] = np.eye(3)
    pairs = Scene(Rod(frames=frames, dna={"base_pairs": 42}, elements=14, natural={"curvature": [0, 0], "twist": 0.0}))
    assert pairs.rods[0]["num_nodes"] == 43 and pairs.units == {"length": "nm", "force": "pN"}
    steps = {
        "step": range(1, 8),
        **{name: np.zeros(7) for name in ("tilt", "shift", "slide")},
        "roll": np.linspace(0, 6, 7),
        "twist": np.full(7, 34.0),
        "rise": np.full(7, 3.4),
        **{f"{name}_{name}": np.full(7, 0.05) for name in ("tilt", "roll", "twist")},
        **{f"{name}_{name}": np.full(7, 20.0) for name in ("shift", "slide", "rise")},
    }
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    records = pandas.DataFrame(steps).to_records(index=False)
    for table in (steps, pandas.DataFrame(steps), polars.DataFrame(pandas.DataFrame(steps).to_dict("list")), records):
        own = Rod(
            shape={"kind": "line", "length": 7 * 0.34},
            sequence={"letters": "ACGTACGT", "steps": table},
            section={"contact_radius": 0.0},
        )
        result = Scene(own, supports=[Support(at="start", position=True, rotation=True)]).run()
        result.export(par=tmp_path / "own.par")
        rows = [[float(cell) for cell in line.split()[1:]] for line in (tmp_path / "own.par").read_text().splitlines()[3:]]
        assert np.array(rows)[1:, 10] == pytest.approx(np.linspace(0, 6, 7), abs=1e-5)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"points": [[0, 0, 0], [0, np.nan, 1]]}, r"^rods\[0\]\.points\[1, 1\] = nan: must be finite"),
        ({"frames": np.zeros((4, 3, 3))}, r"^rods\[0\]\.frames: has shape \(4, 3, 3\): must be"),
        ({"shape": LINE, "natural": {"table": {"s": [0, 1], "kappa9": [1, 2]}}}, r"^rods\[0\]\.natural\.table: unknown column"),
        ({"shape": LINE, "natural": {"table": {"s": [0, 1], "kappa1": ["a", 2]}}}, r"^rods\[0\]\.natural\.table: row 0, column kappa1: .*\"a\""),
    ],
)
def test_errors_name_the_argument_of_an_array(arguments: dict[str, Any], text: str) -> None:
    with pytest.raises(InputError, match=text):
        Scene(Rod(section=SECTION, elements=8, **arguments))


def test_a_sequence_may_be_a_string() -> None:
    rod = Rod(shape={"kind": "line", "length": 20 * 0.34}, sequence={"letters": "random:21:5", "steps": "ideal"}, section={"contact_radius": 0.0})
    scene = Scene(rod)
    assert scene.rods[0]["num_nodes"] == 22 and scene.units["force"] == "pN"
    with pytest.raises(InputError, match="sequence counts in nm and pN, but units are m and N"):
        Scene(rod, units={"length": "m", "force": "N"})
    with pytest.raises(InputError, match="ends at s = .*, but the rod is 6.8 long"):
        Scene(Rod(shape={"kind": "line", "length": 6.8}, sequence="ACGTACGTACGTACGTACGTA", section={"contact_radius": 0.0}))


def test_ends_of_open_rods_have_moments() -> None:
    ends = [Support(at=at, position=True, rotation=True) for at in ("start", "end")]
    solver = Scene(Rod(shape=LINE, section=SECTION, elements=8), supports=ends).solver()
    solver.step_to(rotation={"at": "end", "axis": [1, 0, 0], "turns": 0.25})
    state = solver.state
    moments = state.end_moments()
    assert moments["end"][0] == pytest.approx(1.5 * 2 * np.pi * 0.25)
    assert moments["start"][0] == pytest.approx(-moments["end"][0])
    assert state.twist == pytest.approx(0.25) and state.link == pytest.approx(0.25) and state.ends[0]["rod"] == 0
    with pytest.raises(InputError, match="rod = 'none': must be one of 'rod'"):
        state.end_moments("none")


def test_states_start_other_scenes() -> None:
    """Two rods that were bent go on from where they are: at once, and on another mesh."""
    rods = [Rod(name=name, shape={**LINE, "start": [0, y, 0]}, section=SECTION, elements=8) for y, name in enumerate("ab")]
    held = [Support(rod=name, at="start", position=True, rotation=True) for name in "ab"]
    load = Load(rod="b", at="end", force=(0.0, 0.5, 0.0))
    bent = Scene(rods, supports=held, loads=load, stages=Stage(load=1.0, steps=2)).run().state
    nodes = bent.positions[slice(*bent.node_ranges[1])]
    for elements in (8, 12):
        shape = {"kind": "state", "file": bent, "rod": 1}
        rod = Rod(name="b", shape=shape, section=SECTION, elements=elements)
        again = Scene(rod, supports=held[1], loads=load, load=1.0).run()
        assert again.converged and again.steps[0].iterations <= 4
        assert np.allclose(again.state.positions[-1], nodes[-1], atol=1e-6)


def test_temperature_is_that_of_the_constants_unless_given() -> None:
    assert cantilever().kT is cantilever().temperature is None
    scene = Scene.minicircle()
    assert scene.temperature == 298.0 and scene.kT == pytest.approx(4.114, abs=1e-3)
    rod = Rod(shape={"kind": "line"}, dna={"base_pairs": 42}, elements=8)
    warm = Scene(rod, temperature=310)
    assert warm.temperature == 310.0 and warm.kT == pytest.approx(310 * 0.01380649)
