"""Sweeps: one scene many times, with other values each time."""

from __future__ import annotations

import itertools
import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _supercoil
from ._inputs import check_count

Folder = str | os.PathLike[str]

#: Tasks that wait with the scheduler at a time: enough for a thousand workers, few enough for its memory.
_IN_FLIGHT = 4000
#: Workers that may die on one case before the scheduler gives it up. By default these are 3: a busy cluster has that.
_ALLOWED_FAILURES = 1000
#: Seconds that rows wait for being written.
_PART_SECONDS = 10.0


class SweepPlan:
    """The cases of a sweep, made from a sweep file: a base scene, and axes of values that its keys take."""

    def __init__(self, file: Folder) -> None:
        self._native = _supercoil.Plan.of_file(file)

    @classmethod
    def read(cls, directory: Folder) -> SweepPlan:
        """The plan in the folder ``directory`` of a sweep, as ``supercoil sweep plan`` has written it.

        Raises :class:`InputError` for a folder without one.
        """
        return cls._of(_supercoil.Plan.read(directory))

    @classmethod
    def _of(cls, native: _supercoil.Plan) -> SweepPlan:
        plan = cls.__new__(cls)
        plan._native = native
        return plan

    def write(self, directory: Folder) -> None:
        """Writes the plan into the folder ``directory``, for ``supercoil sweep run``.

        Raises :class:`InputError` for a folder that has another plan.
        """
        self._native.write(directory)

    @cached_property
    def cases(self) -> list[tuple[str, list[str]]]:
        """Id of every case, and the values that it replaces as ``KEY=VALUE``."""
        return self._native.cases()

    def only(self, indices: Sequence[int]) -> SweepPlan:
        """The plan of the cases with these ``indices``, from 0.

        Raises :class:`InputError` for a case that is not there.
        """
        for k, index in enumerate(indices):
            check_count(f"indices[{k}]", index, 0)
        return self._of(self._native.only(list(indices)))

    def __len__(self) -> int:
        return len(self.cases)

    def __reduce__(self) -> tuple[Any, ...]:
        return _plan_of, (self._native.to_text(),)


def _plan_of(text: str) -> SweepPlan:
    return SweepPlan._of(_supercoil.Plan.from_text(text))


@dataclass(frozen=True)
class SweepResult:
    """The rows of a sweep, in the order of its plan."""

    #: The plan.
    plan: SweepPlan
    #: Numbers of the cases that have no rows.
    missing: list[int]
    #: The table as the bytes of a Parquet file.
    parquet: bytes

    @cached_property
    def table(self) -> dict[str, NDArray[Any]]:
        """A dict of arrays, one entry a row: ``case``, the keys of the axes, ``status``, ``message``, and the columns of
        a run's table. Numbers that are not there are NaN, words None."""
        columns = _supercoil.table_columns(self.parquet).items()
        return {name: np.array(c, dtype=object) if isinstance(c, list) else c for name, c in columns}

    def to_pandas(self) -> Any:
        """The table as a pandas data frame."""
        import pandas

        return pandas.DataFrame(self.table)

    def save(self, path: Folder) -> None:
        """Writes the table as the Parquet file ``path``.

        Raises :class:`OSError` for a file that cannot be written.
        """
        Path(path).write_bytes(self.parquet)

    def __repr__(self) -> str:
        return f"<SweepResult: {len(self.plan)} cases, {len(self.missing)} missing>"


def sweep(
    plan: SweepPlan | Folder,
    *,
    directory: Folder | None = None,
    client: Any = None,
    jobs: int | None = None,
    batch: int = 1,
) -> SweepResult:
    """Runs a sweep, given as a plan or by its file, and returns its table.

    ``directory``: folder for plan and rows. Cases that have rows there are not run again; it is the folder of ``supercoil
    sweep run``, which may share the work. Without one nothing is kept.
    ``client``: a Dask client, whose workers run the cases, ``batch`` of them a task; workers that die lose nothing. Files
    that the scene names must be there for them under the same path. Without a client cases run here, ``jobs`` of them side
    by side [default: one a core].

    A case that fails is a row with status and message. The table is the same to the bit however it came about, but for
    the column ``seconds``. Raises :class:`InputError` for a ``plan`` that cannot be read.
    """
    if not isinstance(plan, SweepPlan):
        plan = SweepPlan(plan)
    for name, value in (("jobs", jobs), ("batch", batch)):
        if value is not None:
            check_count(name, value)
    if directory is None and client is None:
        with tempfile.TemporaryDirectory() as folder:
            return sweep(plan, directory=folder, jobs=jobs)
    if directory is not None:
        plan.write(directory)
    if client is None:
        assert directory is not None
        _supercoil.Plan.run_in(directory, jobs)
    else:
        todo = list(range(len(plan))) if directory is None else plan._native.missing(directory)
        rows = list(_on_dask(plan, todo, client, batch, directory))
        if directory is None:
            table, missing = plan._native.merge(rows)
            return SweepResult(plan, missing, table)
    assert directory is not None
    table, missing = _supercoil.Plan.collect(directory)
    return SweepResult(plan, missing, table)


def _run(text: str) -> bytes:
    """The task of a worker."""
    return _supercoil.Plan.from_text(text).run()


def _on_dask(
    plan: SweepPlan, todo: list[int], client: Any, batch: int, directory: Folder | None
) -> Iterator[bytes]:
    """Rows of all cases to do; with a directory they are written there and not given."""
    from distributed import as_completed

    def submit(first: int) -> Any:
        indices = todo[first : first + batch]
        key = f"supercoil-sweep-{plan.cases[indices[0]][0]}-{len(indices)}"
        return client.submit(_run, plan._native.only(indices).to_text(), key=key)

    before = client.run_on_scheduler(_allow_failures, _ALLOWED_FAILURES)
    waiting: list[bytes] = []
    written = time.monotonic()
    try:
        firsts = iter(range(0, len(todo), batch))
        done = as_completed([submit(first) for first in itertools.islice(firsts, _IN_FLIGHT)], with_results=True)
        for _, rows in done:
            if (first := next(firsts, None)) is not None:
                done.add(submit(first))
            if directory is None:
                yield rows
                continue
            waiting.append(rows)
            if time.monotonic() - written > _PART_SECONDS:
                _supercoil.Plan.write_part(directory, waiting)
                waiting, written = [], time.monotonic()
    finally:
        if waiting and directory is not None:
            _supercoil.Plan.write_part(directory, waiting)
        client.run_on_scheduler(_allow_failures, before)


def _allow_failures(number: int, dask_scheduler: Any = None) -> int:
    before: int = dask_scheduler.allowed_failures
    dask_scheduler.allowed_failures = number
    return before
