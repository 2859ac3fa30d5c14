"""Runs: the same bits as the command line, callbacks, exceptions, Ctrl-C."""

import csv
import os
import pickle
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import supercoil
from supercoil import Result, Rod, Scene, Stage, State, Support

ROOT = Path(__file__).parents[2]

SECTION = {"bending": 1.0, "twisting": 1.5, "stretching": 1e4, "shearing": 1e4, "contact_radius": 0.02}


def ring(excess_link: float = 1.4, steps: int = 4, elements: int = 16) -> Scene:
    """A ring of length 1 into which link is put: a figure-eight from 1.3 turns on."""
    shape = {"kind": "circle", "length": 1.0}
    rod = Rod(name="ring", closed=True, shape=shape, section=SECTION, elements=elements)
    return Scene(rod, stages=Stage(excess_link=excess_link, steps=steps))


@pytest.fixture(scope="module")
def result() -> Result:
    return ring().run()


def test_a_run_equals_the_command_line(program: str, tmp_path: Path) -> None:
    file = tmp_path / "ring.toml"
    file.write_text(ring().to_toml())
    subprocess.run([program, "run", file, "--out", tmp_path / "out", "--quiet"], check=True, timeout=300)
    with (tmp_path / "out" / "final_state.csv").open() as lines:
        rows = np.array([[float(cell) for cell in row] for row in list(csv.reader(lines))[1:]])
    state = Scene.from_toml(file).run(threads=1).state
    assert np.array_equal(rows[:, 2], state.arc_lengths)
    assert np.array_equal(rows[:, 3:6], state.positions)
    assert np.array_equal(rows[:, 6:], state.quaternions)


def parting() -> Scene:
    """Two linked rings without contact, of which one is carried away through the other."""
    circles = {"a": {"center": (0, 0, 0), "normal": (0, 0, 1)}, "b": {"center": (1, 0, 0), "normal": (0, 1, 0)}}
    rods = [
        Rod(name=name, closed=True, shape={"kind": "circle", "radius": 1.0, **circle}, section=SECTION, elements=8)
        for name, circle in circles.items()
    ]
    held = [Support(rod=name, at="start", position=True, rotation=True) for name in circles]
    away = {"rod": "b", "at": "start", "to": (3, 0, 0)}
    return Scene(rods, supports=held, contact={"law": "none"}, stages=Stage(displacement=away, steps=4))


def test_a_folder_equals_that_of_the_command_line(program: str, tmp_path: Path) -> None:
    """The same files, the same table to the bit, with notes that compare states."""
    file = tmp_path / "rings.toml"
    file.write_text(parting().to_toml())
    subprocess.run([program, "run", file, "--out", tmp_path / "cli", "--quiet"], check=True, timeout=300)
    result = Scene.from_toml(file).run(keep="all")
    assert 'rods "a" and "b" were linked' in result.table["notes"][-1] and not result.table["notes"][0]
    result.export(directory=tmp_path / "python")
    there, here = ({path.name for path in (tmp_path / name).iterdir()} for name in ("cli", "python"))
    # what goes on from a run is the program's
    assert there - here == {".lock", "final_state.bin", "scene_as_run.toml"} and here <= there
    for name in ("table_columns.csv", "final_state.csv", "resultants.csv", "sites.csv"):
        assert (tmp_path / "cli" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name
    rows = [list(csv.DictReader((tmp_path / name / "table.csv").open())) for name in ("cli", "python")]
    assert [row | {"seconds": ""} for row in rows[0]] == [row | {"seconds": ""} for row in rows[1]]


def test_arrays_have_their_shapes_and_meaning(result: Result) -> None:
    state = result.state
    assert result.converged and state.status == "converged" and result.failure is None
    assert state.positions.shape == (48, 3) and state.quaternions.shape == (48, 4)
    assert state.frames.shape == (48, 3, 3) and state.strains.shape == state.stresses.shape == (48, 6)
    # orthonormal and right-handed, d3 along the centreline
    assert np.allclose(state.frames @ state.frames.transpose(0, 2, 1), np.eye(3), atol=1e-14)
    assert np.allclose(np.linalg.det(state.frames), 1.0)
    along = np.roll(state.positions, -1, axis=0) - np.roll(state.positions, 1, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    assert np.min(np.sum(along * state.frames[:, 2], axis=1)) > 0.98
    # the energy of bending is the integral of the strains' density, with Gauss's weights on three points an element
    weights = np.tile([5 / 18, 8 / 18, 5 / 18], 16) / 16
    bend = 0.5 * np.sum(weights * (state.strains[:, 3] ** 2 + state.strains[:, 4] ** 2))
    assert bend == pytest.approx(state.energies["bending"], rel=1e-12)
    assert np.allclose(state.stresses[:, 5], 1.5 * state.strains[:, 5], rtol=1e-12)


def test_link_is_twist_plus_writhe_and_contact_is_found(result: Result) -> None:
    state = result.state
    assert state.link == pytest.approx(1.4, abs=1e-12)
    assert state.twist + state.writhe == pytest.approx(state.link, abs=1e-12)
    assert supercoil.contact.writhe(state.positions) == pytest.approx(state.writhe, abs=0.02)
    contacts = state.contacts
    assert len(contacts["gap"]) == state.observation["num_sites"] >= 1
    assert contacts["feet"].shape == (len(contacts["gap"]), 2, 3)
    assert np.all(contacts["force"] > 0) and set(contacts["kind"]) <= {"point", "line"}
    # the feet are two radii apart
    apart = np.linalg.norm(contacts["feet"][:, 0] - contacts["feet"][:, 1], axis=1)
    assert np.allclose(apart - 0.04, contacts["gap"], atol=1e-9)


def test_the_table_has_a_row_a_step(result: Result) -> None:
    table = result.table
    assert {len(column) for column in table.values()} == {len(result.steps)}
    assert table["step"].tolist() == list(range(len(result.steps)))
    assert table["excess_link"][-1] == pytest.approx(1.4) and np.all(np.diff(table["excess_link"]) > 0)
    # of the elements' centreline, between which and the contact curve the mesh leaves a little
    assert np.isnan(table["min_gap"][0]) and abs(table["min_gap"][-1]) < 1e-4
    assert table["num_sites"].dtype.kind == "i" and set(table["status"]) == {"converged"}
    kinds = ("stretching", "shearing", "bending", "twisting", "contact")
    assert np.allclose(sum(table[f"{kind}_energy"] for kind in kinds), table["total_energy"], rtol=1e-12)


def test_the_callback_sees_states_and_stops() -> None:
    seen: list[State] = []
    threads: set[int] = set()

    def callback(state: State) -> bool:
        seen.append(state)
        threads.add(threading.get_ident())
        return len(seen) < 3

    result = ring().run(callback=callback)
    assert result.status == "stopped" and len(seen) == 3 and [s.observation["step"] for s in seen] == [0, 1, 2]
    assert np.array_equal(result.state.positions, seen[-1].positions)
    assert threads == {threading.get_ident()}


def test_exceptions_pass_through() -> None:
    class Mine(Exception):
        pass

    def callback(state: State) -> None:
        raise Mine("of the callback")

    with pytest.raises(Mine, match="of the callback"):
        ring().run(callback=callback)


def test_other_threads_go_on() -> None:
    ticks = 0
    done = threading.Event()

    def count() -> None:
        nonlocal ticks
        while not done.wait(0.001):
            ticks += 1

    other = threading.Thread(target=count)
    other.start()
    try:
        ring(elements=48, steps=8).run()
    finally:
        done.set()
        other.join()
    assert ticks > 3


def test_ctrl_c_ends_a_run() -> None:
    """A run that would take minutes ends with KeyboardInterrupt."""
    scene = ring(excess_link=20.0, steps=4000, elements=300)
    timer = threading.Timer(0.5, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        scene.run()
    timer.join()


def test_threads_do_not_change_the_bits(result: Result) -> None:
    assert np.array_equal(ring().run(threads=2).state.positions, result.state.positions)


def test_tubes_inside_each_other_are_not_converged() -> None:
    """A rod bent to 1.1 times the curvature that its contact radius allows: at rest, not to be believed."""
    text = """
    [[rods]]
    shape = { kind = "line", length = 1.0 }
    section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.2 }
    elements = 8
    [[supports]]
    at = "start"
    position = true
    rotation = true
    [[stages]]
    ramp = { natural = { curvature = [CURVATURE, 0.0] } }
    steps = 4
    """
    tight = Scene.from_toml(text.replace("CURVATURE", "5.5")).run()
    assert tight.status == tight.state.status == "overlap" and not tight.converged
    assert Scene.from_toml(text.replace("CURVATURE", "4.0")).run().converged


def test_pickles_and_files_keep_everything(result: Result, tmp_path: Path) -> None:
    state = pickle.loads(pickle.dumps(result.state))
    assert state.observation == result.state.observation
    for name in ("positions", "quaternions", "strains", "stresses", "arc_lengths", "contact_force"):
        assert np.array_equal(getattr(state, name), getattr(result.state, name))
    result.save(tmp_path / "ring.result")
    loaded = Result.load(tmp_path / "ring.result")
    assert loaded.status == result.status and loaded.steps == result.steps
    assert loaded.scene.to_toml() == result.scene.to_toml()
    (tmp_path / "other").write_bytes(pickle.dumps(1))
    with pytest.raises(supercoil.InputError, match="must be a saved result, found int"):
        Result.load(tmp_path / "other")


def test_a_picture_is_a_png_of_the_size_asked_for(result: Result, tmp_path: Path) -> None:
    result.state.save_picture(tmp_path / "ring.png", 320, 200)
    data = (tmp_path / "ring.png").read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")) == (320, 200)
    assert result._repr_png_()[:4] == b"\x89PNG"


def test_results_show_themselves_in_notebooks(result: Result) -> None:
    shown = result._repr_html_()
    assert "<iframe srcdoc=" in shown and "&lt;Result: converged" in shown and "<td>twisting</td>" in shown
    assert "<th>F L</th>" in shown and "<th>pN nm</th>" in Scene.minicircle(elements=12, steps=1).run()._repr_html_()
    assert "data:image/png;base64," in result.state._repr_html_()
    axes = result.plot("excess_link", "writhe")
    assert list(axes.lines[0].get_ydata()) == list(result.table["writhe"]) and axes.get_ylabel() == "writhe [turns]"
    both = result.plot("excess_link", ["writhe", "excess_twist"])
    assert [line.get_label() for line in both.lines] == ["writhe", "excess_twist"]
    with pytest.raises(supercoil.InputError, match="there is no column 'wirthe'; there are step, "):
        result.plot("excess_link", "wirthe")
    line = result.state.plot().lines[0]
    closed = np.vstack([result.state.positions, result.state.positions[:1]])
    assert np.array_equal(np.array(line.get_data_3d()).T, closed)


def test_a_path_passes_the_branch_point_of_a_twisted_ring() -> None:
    """Michell and Zajac: a ring buckles at excess link √3 B/C, here 1.1547.

    That it stretches and shears moves it by some (2π)² B/(EA L²).
    """
    path = ring().solver().follow(excess_link=1.3, max_step=0.1)
    kinds = [point.kind for point in path.points]
    assert path.end == "Target" and kinds[0] == "start" and kinds[-1] == "target" and kinds.count("branch") == 1
    branch = path.points[kinds.index("branch")]
    assert branch.value == pytest.approx(3**0.5 / 1.5, abs=(2 * np.pi) ** 2 / 1e4)
    assert [point.num_unstable > 0 for point in (path.points[0], path.points[-1])] == [False, True]
    assert path.points[-1].state.links[0]["excess_link"] == pytest.approx(1.3, rel=1e-12)


def test_stages_are_followed_as_paths() -> None:
    """Symptom: a stage with ``follow`` was taken in load steps, which pass a limit point by a snap."""
    shape = {"kind": "circle", "length": 1.0}
    rod = Rod(name="ring", closed=True, shape=shape, section=SECTION, elements=16)
    result = Scene(rod, stages=Stage(excess_link=1.3, follow={"max_step": 0.1})).run(keep="all")
    notes = [note for step in result.steps for note in step.notes]
    # Michell and Zajac, as above
    assert result.converged and any(note.startswith("branch point: other paths cross at 1.15") for note in notes)
    assert len(result.states) == len(result.steps) > 5 and [step.step for step in result.steps] == list(range(len(result.steps)))
    assert result.steps[-1].num_unstable > 0 and result.table["excess_link"][-1] == pytest.approx(1.3)


def test_paths_begin_where_they_are_told() -> None:
    path = ring().solver().follow(excess_link=1.3, start="away", max_points=3)
    assert path.points[-1].value < 0.0


def test_errors_are_estimated_where_the_scene_says_so() -> None:
    rod = Rod(closed=True, shape={"kind": "circle", "length": 1.0}, section=SECTION, elements=16)
    result = Scene(rod, stages=Stage(excess_link=0.5), output={"error_estimate": True}).run()
    assert result.error_estimate is not None and 0.0 <= result.error_estimate["mesh"]["error"]["energy"] < 1.0
    assert pickle.loads(pickle.dumps(result)).error_estimate == result.error_estimate
    assert ring(0.5, 1).run().error_estimate is None


def test_progress_is_tqdms_bar(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm")
    result = ring(excess_link=0.5, steps=2).run(progress=True)
    last = capsys.readouterr().err.split("\r")[-1]
    assert last.startswith("100%") and "2.0/2" in last and f"energy {result.state.energies['total']:.6g}, 0 contact sites" in last


def test_progress_without_tqdm_is_a_line_a_step(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    result = ring(excess_link=0.5, steps=2).run(progress=True)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == len(result.steps) and lines[-1].startswith("step 2: stage 1 at 100 %")


def test_curves_without_link_or_writhe_are_refused() -> None:
    """Points that are not numbers are named."""
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    broken = circle.copy()
    broken[7, 1] = np.nan
    with pytest.raises(supercoil.InputError, match=r"\[7\]"):
        supercoil.contact.writhe(broken)
    with pytest.raises(supercoil.InputError, match=r"\[7\]"):
        supercoil.contact.link(circle, broken)
    through = circle[:, [0, 2, 1]] + [1.0, 0.0, 0.0]
    assert abs(supercoil.contact.link(circle, through)) == pytest.approx(1.0, abs=1e-12)
    assert supercoil.contact.link(circle, np.repeat(through, 2, axis=0) + [3.0, 0.0, 0.0]) == pytest.approx(0.0)


def in_child(_: int) -> bytes:
    """The bits of a run in a forked process."""
    return ring().run().state.positions.tobytes()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_forked_processes_run() -> None:
    """Symptom: a run in a process forked after a run never ended. Mechanism: the copy has no threads of the pool.

    In a process of its own, because a hang is to fail rather than to stop the tests.
    """
    text = (
        "import multiprocessing, sys; sys.path.insert(0, sys.argv[1])\n"
        "from test_run import in_child, ring\n"
        "here = ring().run().state.positions.tobytes()\n"
        "with multiprocessing.get_context('fork').Pool(2) as pool:\n"
        "    assert pool.map(in_child, range(2)) == [here, here]\n"
    )
    subprocess.run([sys.executable, "-P", "-c", text, str(Path(__file__).parent)], check=True, timeout=120)


def test_states_are_kept_as_asked() -> None:
    every = ring().run(keep="all")
    assert [state.observation["step"] for state in every.states] == list(range(len(every.steps)))
    assert np.array_equal(every.states[-1].positions, every.state.positions)
    third = ring().run(keep=3)
    assert [state.observation["step"] for state in third.states] == [0, 3, 4]
    assert len(ring(0.5, 2).run().states) == 1
    assert len(pickle.loads(pickle.dumps(third)).states) == 3
    for bad in ("some", 0, True):
        with pytest.raises(supercoil.InputError, match="keep = .*: must be 'last', 'all' or a number of steps"):
            ring().run(keep=bad)  # type: ignore[arg-type]


def test_steps_have_names_and_columns_units(result: Result) -> None:
    assert result.steps[-1].energies == result.steps[-1]["energies"] == result.state.energies
    with pytest.raises(AttributeError, match="a step has no 'energy', but stage, step"):
        _ = result.steps[0].energy
    assert set(result.units) == set(result.table) == set(result.meanings)
    assert result.units["writhe"] == "turns" and result.units["total_energy"] == "F L"
    frame = pytest.importorskip("pandas") and result.to_pandas()
    assert frame.attrs["units"]["writhe"] == "turns"
    polars = pytest.importorskip("polars")
    assert isinstance(result.to_polars(), polars.DataFrame)
    for named in (result.to_pandas(unit_names=True), result.to_polars(unit_names=True)):
        assert list(named["writhe [turns]"]) == list(result.table["writhe"]) and "status" in named.columns


def test_results_become_files(tmp_path: Path) -> None:
    letters = "ACGTTGCAAG" * 9
    length = 90 * 0.34
    rod = Rod(
        closed=True,
        shape={"kind": "circle", "length": length},
        sequence={"letters": letters, "steps": "ideal"},
        section={"contact_radius": 0.5},
        link=9,
    )
    result = Scene(rod).run(keep="all")
    files = {name: tmp_path / f"m.{name}" for name in ("xyz", "vect", "pdb", "par", "ref_frames", "npy", "glb", "vtk")}
    result.export(**files, oxdna=tmp_path / "m", directory=tmp_path / "run")  # type: ignore[arg-type]
    frames = np.load(files["npy"])
    assert frames.shape == (90, 4, 3)
    assert np.allclose(frames[::3, 0], result.state.positions[::3], atol=1e-9)
    names = [line.split()[0] for line in files["par"].read_text().splitlines()[3:]]
    pairs = {"A": "A-T", "C": "C-G", "G": "G-C", "T": "T-A"}
    assert names == [pairs[base] for base in letters + letters[0]]
    atoms = [line for line in files["pdb"].read_text().splitlines() if line.startswith("ATOM")]
    assert [atom[17:20] for atom in atoms[:4]] == [" DA", " DC", " DG", " DT"] and len(atoms) == 180
    assert (tmp_path / "m.top").read_text().startswith("180 2\n") and files["glb"].read_bytes()[:4] == b"glTF"
    assert files["vtk"].read_bytes()[:5] == b"<?xml" and (tmp_path / "run" / "view.html").exists()
    with pytest.raises(supercoil.InputError, match="export: names no file: give one of oxdna, xyz"):
        result.export()
    with pytest.raises(supercoil.InputError, match="sequence: has 4 bases"):
        result.export(par=tmp_path / "x.par", sequence="ACGT")
    with pytest.raises(supercoil.InputError, match="units.length = \"L\": must be \"nm\""):
        ring(0.5, 1).run().export(par=tmp_path / "x.par")


def test_links_are_several_rods() -> None:
    """Whitehead's link by its braid, a Hopf link by its PD code: linked 0 times and once, at rest and without a knot."""
    braid: tuple[dict[str, Any], int] = ({"braid": [1, -2, 1, -2, -2]}, 0)
    for shape, link in [braid, ({"pd": [[1, 3, 2, 4], [3, 1, 4, 2]]}, 1)]:
        rods = [
            Rod(
                name=name,
                closed=True,
                shape={"kind": "knot", **shape, "component": k, "distance": 0.2},
                section=SECTION,
                elements=24,
            )
            for k, name in enumerate("ab")
        ]
        result = Scene(rods).run()
        table = result.table
        assert result.converged and table["linking_a_b"][-1] == link
        assert table["a_knot"][-1] == table["b_knot"][-1] == "0_1"


def test_results_have_a_page(result: Result, tmp_path: Path) -> None:
    file = result.view(tmp_path / "ring.html", open_browser=False)
    assert file.read_text().lstrip().lower().startswith("<!doctype html>")


def test_the_command_line_comes_along(tmp_path: Path) -> None:
    (tmp_path / "ring.toml").write_text(ring(0.5, 1).to_toml())
    program = [sys.executable, "-m", "supercoil"]
    told = subprocess.run([*program, "check", "ring.toml"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert told.returncode == 0 and "nothing to object" in told.stdout
    told = subprocess.run([*program, "run", "none.toml"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert told.returncode == 2 and "none.toml" in told.stderr
    # the console script, and what it writes
    script = Path(sys.executable).with_name("supercoil")
    subprocess.run([script, "new", "knot", "8_19"], cwd=tmp_path, check=True, timeout=60)
    assert Scene.from_toml(tmp_path / "knot_8_19.toml").rods[0]["closed"]
    told = subprocess.run([script, "--version"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert told.stdout.strip() == f"supercoil {supercoil.__version__}"
