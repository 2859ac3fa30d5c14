"""Code as users write it: the README's runs, and passes ``mypy --strict`` against the installed package."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

#: What a user may write with everything that has a type.
CODE = """
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import supercoil
from supercoil import Result, Rod, Scene, Stage, State, Support, contact, dna


def loop(letters: str, end: NDArray[np.float64]) -> Result:
    length = (len(letters) - 1) * 0.34
    line = {"kind": "line", "length": length}
    rod = Rod(name="dna", shape=line, sequence={"letters": letters, "steps": "ideal"}, section={"contact_radius": 1.0})
    ends = [Support(rod="dna", at=at, position=True, rotation=True) for at in ("start", "end")]
    stage = Stage(displacement={"at": "end", "to": end}, steps=4, hold=None)
    scene = Scene(rod, supports=ends, stages=[stage], temperature=298.0, output={"vtk": False})

    def seen(state: State) -> bool:
        return state.energies["total"] < 1e3

    return scene.run(progress=False, callback=seen, keep="all")


result = loop("ACGT" * 8 + "A", np.array([0.0, 0.0, -0.5]))
positions: NDArray[np.float64] = result.state.positions
table: dict[str, NDArray[np.float64]] = result.table
energy: float = result.steps[-1].energies["total"]
unit: str = result.units["total_energy"]
moment: NDArray[np.float64] = result.state.end_moments()["end"]
result.export(npy=Path("frames.npy"), pdb="loop.pdb")
writhe: float = contact.writhe(positions, closed=False)
steps: dict[str, NDArray[np.float64]] = dna.steps(np.zeros((3, 6)), np.eye(6))
try:
    Scene(Rod(points=np.zeros((3, 2))))
except supercoil.InputError as error:
    print(error)
"""


def test_user_code_is_strictly_typed(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    (tmp_path / "user.py").write_text(CODE)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--follow-imports=silent", "user.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout
    # the check can fail
    (tmp_path / "wrong.py").write_text(CODE + "\nresult.state.positions = 1\nScene(Rod(shape=3))\n")
    done = subprocess.run([*command[:-1], "wrong.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 1 and done.stdout.count("error:") == 2, done.stdout


@pytest.mark.parametrize("name", ["README.md", "python/README.md"])
def test_the_readme_runs(name: str, tmp_path: Path) -> None:
    fences = re.findall(r"```python\n(.*?)```", (ROOT / name).read_text(), re.DOTALL)
    assert fences
    for text in fences:
        subprocess.run([sys.executable, "-P", "-c", text], cwd=tmp_path, check=True, timeout=300)
