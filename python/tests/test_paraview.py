"""Files for ParaView, read by VTK itself, which is strict."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

SCENE = """
units = { length = "m", force = "N" }
[[rods]]
name = "ring"
closed = true
shape = { kind = "circle", length = 6.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
elements = 12
[[rods]]
name = "beam <&> bar"
shape = { kind = "line", start = [3.0, 0.0, 0.0], length = 2.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
elements = 4
[[supports]]
rod = "beam <&> bar"
at = "start"
position = true
rotation = true
[[stages]]
ramp = { excess_link = { rod = "ring", to = 0.5 } }
steps = 2
[output]
picture = false
"""


def test_vtk_reads_all_of_a_step(program: str, tmp_path: Path) -> None:
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    (tmp_path / "scene.toml").write_text(SCENE)
    subprocess.run([program, "run", "scene.toml", "--out", "out"], cwd=tmp_path, check=True, capture_output=True)
    complaints: list[str] = []
    for step in range(3):
        reader = vtk.vtkXMLPolyDataReader()
        for event in ("ErrorEvent", "WarningEvent"):
            reader.AddObserver(event, lambda _, name: complaints.append(name))
        reader.SetFileName(str(tmp_path / "out" / f"step_{step:04}.vtp"))
        reader.Update()
        data = reader.GetOutput()
        points, fields, cells = data.GetPointData(), data.GetFieldData(), data.GetCellData()
        assert (data.GetNumberOfPoints(), data.GetNumberOfCells()) == (36 + 13, 2)
        assert [data.GetCell(k).GetNumberOfPoints() for k in range(2)] == [37, 13]
        names = [part.GetArrayName(k) for part in (points, fields, cells) for k in range(part.GetNumberOfArrays())]
        assert len(set(names)) == len(names)
        assert {"radius", "arc_length", "smoothed_contact_force_per_length", "internal_force", "internal_moment"} <= set(names)
        time = vtk_to_numpy(fields.GetArray("TimeValue"))
        assert time.tolist() == vtk_to_numpy(fields.GetArray("excess_link")).tolist() == [0.25 * step]
        units = fields.GetAbstractArray("units")
        lines = [units.GetValue(k) for k in range(units.GetNumberOfValues())]
        assert "TimeValue: excess_link" in lines and "internal_moment: N m" in lines
        arcs = vtk_to_numpy(points.GetArray("arc_length"))
        assert np.allclose(arcs[:36], np.arange(36) / 6) and np.allclose(arcs[36:], np.arange(13) / 6)
        assert np.allclose(vtk_to_numpy(points.GetArray("radius")), 0.05)
        # the flat ring bears EI 2π/L, GJ ΔLk 2π/L
        moment = np.linalg.norm(vtk_to_numpy(points.GetArray("internal_moment"))[:36], axis=1)
        assert np.allclose(moment, 2 * np.pi / 6 * np.hypot(1, 0.25 * step), rtol=1e-4)
    assert complaints == []
