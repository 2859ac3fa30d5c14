"""Sweeps: the table of one process, of the command line and of workers that die is the same to the bit."""

import os
import random
import signal
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

import supercoil
from supercoil import InputError, SweepPlan, SweepResult

SCENE = """
[[rods]]
name = "rod"
shape = { kind = "line", length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.0 }
elements = 12
[[supports]]
at = "start"
position = true
rotation = true
[[loads]]
at = "end"
force = [0.0, 1.0, 0.0]
[[stages]]
ramp = { load = 1.0 }
steps = 2
"""


def sweep_file(folder: Path, count: int) -> Path:
    """So many cases, of which every sixth is refused."""
    (folder / "scene.toml").write_text(SCENE)
    file = folder / "sweep.toml"
    loads = f"{{ from = 0.5, to = 2.5, count = {count // 6} }}"
    linked = '"rods.rod.elements" = [12, 12, 8, 8, 8, 0]\n"stages.0.steps" = [2, 3, 1, 2, 3, 1]\n'
    file.write_text(f'scene = "scene.toml"\n[axes]\n"stages.0.ramp.load" = {loads}\n[[linked]]\n{linked}')
    return file


def assert_same(a: SweepResult, b: SweepResult) -> None:
    assert a.missing == b.missing == [] and list(a.table) == list(b.table)
    for name in set(a.table) - {"seconds"}:
        x, y = a.table[name], b.table[name]
        same = x.tolist() == y.tolist() if x.dtype == object else x.tobytes() == y.tobytes()
        assert same, name


def test_the_table_has_every_case_and_its_failures(tmp_path: Path) -> None:
    file = sweep_file(tmp_path, 12)
    plan = SweepPlan(file)
    result = supercoil.sweep(plan)
    assert len(plan) == 12 and len(set(result.table["case"])) == 12
    converged = result.table["status"] == "converged"
    assert set(result.table["rods.rod.elements"][~converged]) == {0}
    assert all("elements = 0" in message for message in result.table["message"][~converged])
    steps = result.table["step"][converged]
    assert steps.dtype in (np.int64, np.float64) and set(steps) == {0, 1, 2, 3}
    # an independent reader finds the same
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    result.save(tmp_path / "table.parquet")
    frame = pandas.read_parquet(tmp_path / "table.parquet")
    assert list(frame.columns) == list(result.table) and len(frame) == len(converged)
    assert frame["total_energy"].to_numpy().tobytes() == result.table["total_energy"].tobytes()
    assert frame["case"].tolist() == result.table["case"].tolist()


def test_the_command_line_shares_the_folder(program: str, tmp_path: Path) -> None:
    file, folder = sweep_file(tmp_path, 12), tmp_path / "sweep"
    subprocess.run([program, "sweep", "plan", file, "--out", folder], check=True, timeout=60)
    subprocess.run([program, "sweep", "run", folder, "--shard", "0/2", "--quiet"], check=True, timeout=60)
    assert_same(supercoil.sweep(file, directory=folder), supercoil.sweep(file, jobs=1))
    subprocess.run([program, "sweep", "status", folder], check=True, timeout=60)
    assert_same(supercoil.sweep(SweepPlan.read(folder), directory=folder), supercoil.sweep(file))


def test_bad_input_is_refused(tmp_path: Path) -> None:
    file = sweep_file(tmp_path, 6)
    with pytest.raises(InputError, match="jobs = 0: must be at least 1"):
        supercoil.sweep(file, jobs=0)
    with pytest.raises(InputError, match="case = 6: must be the number of a case"):
        SweepPlan(file).only([6])
    with pytest.raises(InputError, match="part: "):
        SweepPlan(file)._native.merge([b"PAR1"])


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes are not killed so here")
def test_workers_may_die(tmp_path: Path) -> None:
    """Four workers, one of them killed every two seconds: nothing is lost, nothing is there twice."""
    distributed = pytest.importorskip("distributed")
    count = int(os.environ.get("SUPERCOIL_SWEEP_CASES", "900"))
    plan = SweepPlan(sweep_file(tmp_path, count))
    killed = 0
    done = threading.Event()
    with (
        distributed.LocalCluster(n_workers=4, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):

        def kill() -> None:
            nonlocal killed
            choose = random.Random(1)
            while not done.wait(2.0):
                alive = set(cluster.scheduler.workers)
                pids = [nanny.pid for nanny in cluster.workers.values() if nanny.worker_address in alive and nanny.pid]
                # on a machine so busy that none comes back in time there would be no end
                if len(pids) > 1:
                    try:
                        os.kill(choose.choice(pids), signal.SIGKILL)
                        killed += 1
                    except ProcessLookupError:
                        pass

        killer = threading.Thread(target=kill)
        killer.start()
        try:
            # a round with rows kept by the client, and one with rows in a folder
            in_memory = supercoil.sweep(plan, client=client)
            on_disk = supercoil.sweep(plan, client=client, directory=tmp_path / "sweep", batch=5)
        finally:
            done.set()
            killer.join()
    assert killed >= 2
    serial = supercoil.sweep(plan, jobs=1)
    assert len(set(serial.table["case"])) == len(plan)
    assert_same(in_memory, serial)
    assert_same(on_disk, serial)
