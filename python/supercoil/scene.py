"""Scenes, their runs, and the solver driven by hand."""

from __future__ import annotations

import html
import itertools
import json
import os
import pickle
import re
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w
from numpy.typing import ArrayLike, NDArray

from . import _supercoil
from ._inputs import Given, Inputs, Table, check, check_count, ramp_keys, schema
from .errors import InputError
from .state import Floats, State

Path_ = str | os.PathLike[str]
Vector = Sequence[float] | NDArray[Any]


@dataclass(kw_only=True)
class Rod:
    """A rod, with the keys of ``[[rods]]`` in a scene file: a ``name``, ``closed`` or not, elements of ``order`` 1, 2 or 3.

    ``shape`` and ``section`` are tables such as ``{"kind": "circle", "length": 6.0}`` [L] and ``{"bending": 1.0,
    "twisting": 1.5, "stretching": 1e4, "shearing": 1e4, "contact_radius": 0.1}`` [F·L², F, L]. ``elements`` may be left
    out where the scene has a fidelity or the rod a sequence. Closed rods have an ``excess_link`` [turns beyond the relaxed
    rod], or in its place ``sigma`` or the whole ``link``; open ones a ``twist`` [turns]. ``roll`` [turns] turns the first frame about the rod.

    ``dna``, such as ``{"base_pairs": 336, "salt_mM": 150}``, stands for the section and the shape's length, in nm and pN.
    ``sequence``, such as ``{"letters": "ACGT…", "steps": "ideal"}``, gives stiffness and natural strains; a plain string of
    letters has the steps of ``"protein-dna-1998"``.

    Wherever a scene file names a file, an array or a table may stand: ``points`` (n, 3) [L] or ``frames`` (n, 4, 3) [nm:
    origin, d1, d2, d3] in place of ``shape`` (or as its ``"file"``); a dict of columns or a data frame as ``{"table": …}`` of
    ``natural`` (columns ``s`` or ``from``, ``to``; ``gamma1`` … ``kappa3``) and ``section``, and as ``"steps"`` and
    ``"proteins"`` of ``sequence``. A :class:`State` stands for a file in ``shape={"kind": "state", "file": state}``.

    Raises :class:`InputError` when the scene is made: the text has the argument, its value and what is allowed.
    """

    shape: Table | None = None
    section: Table | None = None
    elements: int | None = None
    name: str | None = None
    closed: bool = False
    order: int = 3
    natural: str | Table | None = None
    roll: float | None = None
    excess_link: float | None = None
    dna: Table | None = None
    sigma: float | None = None
    link: float | None = None
    twist: float | None = None
    sequence: str | Table | None = None
    #: Weight under the scene's ``gravity``, by one of three: mass per volume,
    density: float | None = None
    #: the mass of the whole rod,
    mass: float | None = None
    #: or weight per length [F/L].
    weight: float | None = None
    #: Part of the natural state of a table, or of the change of it by proteins, at the start: 0 to 1.
    binding: float | None = None
    #: Balls about nodes that move with them and take part in contact: ``{"at": …, "radius": …, "name": …}`` [L].
    beads: Sequence[Table] | None = None
    #: (n, 3) points [L] of the centreline at the start, in place of ``shape``.
    points: ArrayLike | None = None
    #: (n, 4, 3) base pairs [nm]: origin, d1, d2, d3; in place of ``shape``.
    frames: ArrayLike | None = None

    def _table(self) -> Table:
        table = {f.name: getattr(self, f.name) for f in fields(self)}
        given = {kind: table.pop(kind) for kind in ("points", "frames")}
        arrays = {kind: np.asarray(value) for kind, value in given.items() if value is not None}
        if len(arrays) + (self.shape is not None) != 1:
            found = [*arrays, *(["shape"] if self.shape is not None else [])]
            raise InputError(f"Rod: needs exactly one of shape, points, frames, found {', '.join(found) or 'none'}")
        for kind, array in arrays.items():
            table["shape"] = {"kind": kind, "file": Given(kind, array)}
        if isinstance(self.sequence, str):
            table["sequence"] = {"letters": self.sequence, "steps": "protein-dna-1998"}
        return table


@dataclass(kw_only=True)
class Support:
    """Fixes a node of ``rod`` (a name, or several; by default the only one): ``at`` is "start", "end", a node index or
    ``{"arc": s}``; ``position`` and ``rotation`` are True or a list of axes such as ``["x", "y"]``. ``grip``: the length [L]
    of a rigid capsule that prolongs an end of an open rod, or ``"endless"``: no loop and no knot slips over it."""

    at: str | int | Table
    rod: str | list[str] | None = None
    position: bool | list[str] = False
    rotation: bool | list[str] = False
    grip: float | Literal["endless", "none"] | None = None


@dataclass(kw_only=True)
class Joint:
    """Joins two nodes at one place, ``a`` and ``b``: ``{"rod": name, "at": …}`` with ``at`` as for :class:`Support`. ``kind``:
    "rigid" (they share position and rotation), "pin" (position) or "hinge" (position, and rotation but about ``axis`` (3,), given
    in space by the initial shapes)."""

    a: Table
    b: Table
    kind: Literal["rigid", "pin", "hinge"] | None = None
    axis: Vector | None = None


@dataclass(kw_only=True)
class Load:
    """Dead ``force`` (3,) [F] and ``moment`` (3,) [F·L] at a node of ``rod``, times the load factor of the stages. ``at`` as for
    :class:`Support`; each rod of a list bears the whole load."""

    at: str | int | Table
    rod: str | list[str] | None = None
    force: Vector | None = None
    moment: Vector | None = None


@dataclass(kw_only=True)
class LineLoad:
    """Dead ``force`` (3,) [F/L] and ``moment`` (3,) [F] per reference length on a whole ``rod``, times the load factor of the
    stages; each rod of a list bears the whole load."""

    force: Vector | None = None
    moment: Vector | None = None
    rod: str | list[str] | None = None


@dataclass(kw_only=True)
class Plane:
    """A plane that rods rest on, without friction: ``normal`` [a unit vector] points towards the rods, ``point`` [L] is on
    it. Several need a ``name`` each, by which stages move them."""

    normal: Vector
    point: Vector | None = None
    name: str | None = None


@dataclass(kw_only=True)
class Obstacle:
    """A rigid cylinder or sphere without friction. ``shape``: ``"cylinder"``, about the ``axis`` through ``point`` [L], or
    ``"sphere"``, about ``point``; ``radius`` [L]; ``side``: where rods are, ``"outside"`` or ``"inside"``. ``hinge``:
    ``{"through": […], "axis": […]}``, the line about which stages turn it. Several need a ``name`` each."""

    shape: Literal["cylinder", "sphere"]
    radius: float
    point: Vector | None = None
    axis: Vector | None = None
    side: Literal["outside", "inside"] | None = None
    hinge: Table | None = None
    name: str | None = None


def _list(given: Any) -> list[Any]:
    """One or several as a list."""
    return list(given) if isinstance(given, Iterable) and not isinstance(given, (Mapping, str)) else [given]


@dataclass(kw_only=True)
class Stage:
    """What moves, in so many ``steps``. All targets are absolute and all ramps of a stage move together.

    ``excess_link``: turns, or ``{"rod": …, "to": turns}``; so ``link`` [turns], ``sigma``, ``pressure`` [F/L], ``length``
    [L] and ``plane`` (displacement along its normal [L], or ``{"name": …, "to": …}``). ``pose``: ``{"at": …, "position":
    [x, y, z], "quaternion": [w, x, y, z]}`` and what else the key takes in scene files. ``rotation``: ``{"at": …, "axis":
    […], "turns": …}``. ``displacement``: ``{"at": …, "to": [x, y, z]}`` [L]. ``load``: the factor of all loads.
    ``section``: ``{"bending": …, "twisting": …, "contact_radius": …}`` and ``natural``: ``{"curvature": [k1, k2], "twist":
    k3}`` [1/L]. ``obstacle``: ``{"name": …, "radius": …,
    "displacement": […], "turns": …}``. ``binding``: 0 to 1, the part of the natural state of a table or of bound proteins. Lists of tables move
    several nodes or rods.

    ``hold`` and ``release``: supports that are there from this stage on, or no longer: :class:`Support` objects.
    ``follow``, of the last stage with one ramp: True or ``{"step": …, "max_step": …, "max_points": …}``: the path past limit
    points.
    """

    steps: int = 1
    excess_link: float | Table | list[Table] | None = None
    rotation: Table | list[Table] | None = None
    displacement: Table | list[Table] | None = None
    load: float | None = None
    pressure: float | Table | list[Table] | None = None
    plane: float | Table | list[Table] | None = None
    obstacle: Table | list[Table] | None = None
    pose: Table | list[Table] | None = None
    sigma: float | Table | list[Table] | None = None
    link: float | Table | list[Table] | None = None
    section: Table | list[Table] | None = None
    length: float | Table | list[Table] | None = None
    natural: Table | list[Table] | None = None
    binding: float | Table | list[Table] | None = None
    hold: Support | Sequence[Support] | None = None
    release: Support | Sequence[Support] | None = None
    follow: bool | Table | None = None

    def _table(self) -> Table:
        ramp = {key: getattr(self, key) for key in sorted(ramp_keys()) if getattr(self, key) is not None}
        for key in ("excess_link", "sigma", "link", "pressure", "plane", "length", "binding"):
            if key in ramp and not isinstance(ramp[key], (dict, list)):
                ramp[key] = {"to": ramp[key]}
        table: Table = {"ramp": ramp, "steps": self.steps}
        for key in ("hold", "release"):
            supports = getattr(self, key)
            if supports is not None:
                table[key] = _list(supports)
        if self.follow is not None and self.follow is not False:
            table["follow"] = {} if self.follow is True else self.follow
        return table


def _check_threads(threads: int | None) -> None:
    if threads is not None:
        check_count("threads", threads)


class Scene:
    """A problem, its stages and its solver's choices; checked when it is made.

    Every key is explained with the scene files; keyword arguments here have the same names. Of what there may be several,
    one alone needs no list.
    """

    def __init__(
        self,
        rods: Rod | Sequence[Rod],
        *,
        stages: Stage | Sequence[Stage] = (),
        supports: Support | Sequence[Support] = (),
        joints: Joint | Table | Sequence[Joint | Table] = (),
        loads: Load | Sequence[Load] = (),
        line_loads: LineLoad | Sequence[LineLoad] = (),
        planes: Plane | Sequence[Plane] = (),
        obstacles: Obstacle | Sequence[Obstacle] = (),
        contact: Table | None = None,
        solver: Table | None = None,
        fidelity: Literal["draft", "balanced", "reference"] | None = None,
        planar: bool = False,
        title: str = "",
        units: Table | None = None,
        temperature: float | None = None,
        gravity: Vector | None = None,
        load: float | None = None,
        output: Table | None = None,
        picture: Table | None = None,
    ) -> None:
        all_rods = _list(rods)
        scene = {
            "title": title,
            "planar": planar,
            "fidelity": fidelity,
            "units": units,
            "temperature": temperature,
            "gravity": gravity,
            "load": load,
            "rods": all_rods,
            "supports": _list(supports),
            "joints": _list(joints),
            "loads": _list(loads),
            "line_loads": _list(line_loads),
            "planes": _list(planes),
            "obstacles": _list(obstacles),
            "contact": contact,
            "solver": solver,
            "output": output,
            "picture": picture,
            "stages": _list(stages),
        }
        inputs = Inputs([getattr(rod, "name", None) or "rod" for rod in all_rods])
        plain = inputs.plain(scene)
        check(plain, schema(), "")
        try:
            self._read(tomli_w.dumps(plain), Path(), inputs.files)
        except InputError as error:
            raise InputError(inputs.in_arguments(str(error))) from None

    def _read(self, text: str, base_dir: Path, files: dict[str, bytes] | None = None) -> None:
        self._text, self._base_dir, self._files = text, base_dir, files or {}
        if not self._files:
            self._native = _supercoil.Scene(text, base_dir)
            return
        # arrays are files while the scene is read; what else it names has an absolute path
        with tempfile.TemporaryDirectory() as folder:
            self._write_files(Path(folder))
            try:
                self._native = _supercoil.Scene(text, Path(folder))
            except InputError as error:
                raise InputError(str(error).replace(folder + os.sep, "")) from None

    def _write_files(self, folder: Path) -> None:
        for name, content in self._files.items():
            (folder / name).write_bytes(content)

    @classmethod
    def from_toml(cls, source: str | os.PathLike[str]) -> Scene:
        """Reads a scene from a file, or from text if ``source`` is a string of more than one line.

        Files named in a scene file are found relative to it, those named in text relative to the working directory.

        Raises :class:`InputError` with the place in the text, the value and what is allowed.
        """
        scene = cls.__new__(cls)
        if isinstance(source, str) and "\n" in source:
            scene._read(source, Path())
            return scene
        path = Path(source)
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}") from error
        scene._read(text, path.parent)
        return scene

    @classmethod
    def minicircle(
        cls,
        base_pairs: int = 336,
        sigma: float = -0.06,
        salt_mM: float = 150.0,  # noqa: N803 (the unit)
        *,
        elements: int | None = None,
        steps: int = 10,
        fidelity: Literal["draft", "balanced", "reference"] = "balanced",
    ) -> Scene:
        """A DNA minicircle in nm and pN, from the relaxed circle to supercoiling density ``sigma``.

        The contact diameter follows the concentration of sodium chloride, ``salt_mM`` from 10 to 1000 mmol/l. Its length is
        that of ``base_pairs``. Without ``elements`` the ``fidelity`` sets the mesh. The link changes in ``steps``.

        Raises :class:`InputError` for numbers out of their ranges.
        """
        rules = schema()["$defs"]["DnaText"]["properties"]
        for argument, value in (("base_pairs", base_pairs), ("salt_mM", salt_mM)):
            check(value, rules[argument], argument)
        for argument, count in (("elements", elements), ("steps", steps)):
            if count is not None:
                check_count(argument, count)
        rise, bending, twisting, stretching = _supercoil.dna()
        radius = _supercoil.contact_diameter(salt_mM / 1000.0) / 2.0
        section = {"bending": bending, "twisting": twisting, "stretching": stretching, "shearing": stretching}
        section["contact_radius"] = radius
        shape = {"kind": "circle", "length": base_pairs * rise}
        return cls(
            Rod(name="dna", closed=True, shape=shape, section=section, elements=elements),
            stages=Stage(excess_link=_supercoil.excess_link(base_pairs, sigma), steps=steps),
            title=f"{base_pairs} bp minicircle, sigma {sigma}",
            units={"length": "nm", "force": "pN"},
            fidelity=fidelity,
        )

    def to_toml(self) -> str:
        """The scene as the text of a scene file, as it was read or made. Arrays are named in it as the files that
        :meth:`save` writes."""
        return self._text

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the scene file ``path``, and beside it the files of the arrays in it: what ``supercoil run`` reads.

        Raises :class:`OSError` for a file that cannot be written.
        """
        path = Path(path)
        path.write_text(self._text, encoding="utf-8")
        self._write_files(path.parent)

    @property
    def units(self) -> dict[str, str]:
        """Names of the units: ``{"length": "nm", "force": "pN"}``; L and F where none are given."""
        length, force = self._native.units()
        return {"length": length, "force": force}

    @property
    def temperature(self) -> float | None:
        """Temperature [K] of what is reported in kT, 298 unless it was given; None where units are not nm and pN."""
        thermal = self._native.thermal()
        return thermal and thermal[0]

    @property
    def kT(self) -> float | None:  # noqa: N802 (as it is written)
        """Thermal energy, kT [pN nm], at :attr:`temperature`; None where units are not nm and pN."""
        thermal = self._native.thermal()
        return thermal and thermal[1]

    @property
    def notices(self) -> list[str]:
        """What to know of the scene: a start that is not at rest in its link or its base-pair steps."""
        return self._native.remarks()[0]

    @property
    def warnings(self) -> list[str]:
        """What is probably not meant: a mesh too coarse, a radius in another unit."""
        return self._native.remarks()[1]

    @property
    def title(self) -> str:
        """The title; may be empty."""
        return self._native.title

    @property
    def rods(self) -> list[dict[str, Any]]:
        """Of every rod ``name``, ``closed``, ``length`` [L], ``contact_radius`` [L], ``num_nodes``."""
        keys = ("name", "closed", "length", "contact_radius", "num_nodes")
        return [dict(zip(keys, rod, strict=True)) for rod in self._native.rods()]

    def run(
        self,
        progress: bool = False,
        callback: Callable[[State], object] | None = None,
        threads: int | None = None,
        keep: Literal["last", "all"] | int = "last",
    ) -> Result:
        """Runs all stages.

        ``callback`` sees the start and every accepted state, and stops the run by returning False; its exceptions and
        Ctrl-C end the run and pass through. ``progress`` shows how far the run is: tqdm's bar where tqdm is installed, in
        notebooks and terminals, else a line a step on the error stream. ``threads`` do not change the result; by default all are used. Other
        Python threads go on meanwhile. ``keep``: which states :attr:`Result.states` has, the last one only, all of them, or
        every so many steps (the start and the last always).

        In a process that was forked after a run (``multiprocessing`` with "fork") a run uses one thread unless it is given
        more.

        Raises :class:`InputError` and :class:`SolveError`; a run that does not converge has a status in its result.
        """
        _check_threads(threads)
        every = {"last": None, "all": 1}.get(keep, keep) if isinstance(keep, str) else keep
        if isinstance(every, str) or (every is not None and (isinstance(every, bool) or every < 1)):
            raise InputError(f"keep = {keep!r}: must be 'last', 'all' or a number of steps of at least 1")
        states: list[State] = []
        bar = _Bar(self._native.stage_steps()) if progress else None

        def seen(native: _supercoil.State) -> object:
            state = State(native)
            step = int(state.observation["step"])
            if every is not None and step % every == 0:
                states.append(state)
            if bar is not None:
                bar.show(state)
            return None if callback is None else callback(state)

        watch = seen if progress or callback is not None or every is not None else None
        try:
            result = Result(self, *self._native.run(watch, threads))
        finally:
            if bar is not None:
                bar.close()
        if states and states[-1].observation["step"] == result.state.observation["step"]:
            states.pop()
        result.states = [*states, result.state]
        return result

    def solver(self, threads: int | None = None) -> Solver:
        """The solver, to be driven by hand; the stages of the scene are not run. ``threads`` as for :meth:`run`.

        Raises :class:`InputError` for fewer than one thread.
        """
        _check_threads(threads)
        return Solver(self, threads)

    def __reduce__(self) -> tuple[Any, ...]:
        return _scene_of, (self._text, self._base_dir, self._files)

    def __repr__(self) -> str:
        names = ", ".join(rod["name"] for rod in self.rods)
        return f"<Scene {self.title!r}: {names}>"


def _scene_of(text: str, base_dir: Path, files: dict[str, bytes]) -> Scene:
    scene = Scene.__new__(Scene)
    scene._read(text, base_dir, files)
    return scene


#: Steps may be parts of steps: tqdm's own format, with one digit.
_BAR_FORMAT = "{l_bar}{bar}| {n:.1f}/{total} [{elapsed}<{remaining}, {rate_fmt}{postfix}]"


class _Bar:
    """How far a run is, on the error stream: tqdm's bar where tqdm is installed, else a line a step."""

    def __init__(self, stage_steps: list[int]) -> None:
        #: Steps before each stage, and of all.
        self.before = [0, *itertools.accumulate(stage_steps)]
        self.steps = stage_steps
        try:
            from tqdm.auto import tqdm
        except ImportError:
            self.bar: Any = None
        else:
            self.bar = tqdm(total=self.before[-1], unit="step", bar_format=_BAR_FORMAT)

    def show(self, state: State) -> None:
        step = state.observation
        stage = min(step["stage"], len(self.steps) - 1)
        told = f"energy {step['energies']['total']:.6g}, {step['num_sites']} contact sites"
        if self.bar is None:
            where = f"step {step['step']}: stage {step['stage'] + 1} at {100 * step['fraction']:.0f} %"
            print(f"{where}, {told}", file=sys.stderr)
            return
        if stage >= 0:
            # steps that are cut back are parts of one
            self.bar.n = self.before[stage] + step["fraction"] * self.steps[stage]
        self.bar.set_postfix_str(told)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()


class Step(dict[str, Any]):
    """The report of one accepted step: its entries (as in ``summary.json``) are attributes, too: ``step.energies``."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"a step has no {name!r}, but {', '.join(self)}") from None


class Result:
    """How a run went: its ``status``, reports of its ``steps``, the states that were kept."""

    def __init__(
        self,
        scene: Scene,
        state: _supercoil.State,
        steps: str,
        status: str,
        failure: str | None,
        error_estimate: str | None,
        seconds: float,
    ) -> None:
        self.scene = scene
        #: The last accepted state.
        self.state = State(state)
        #: The states that were kept, in order; the last one is ``state``.
        self.states: list[State] = [self.state]
        #: Reports of all accepted steps, the start first, as in ``summary.json``: dicts whose entries are attributes, too.
        self.steps: list[Step] = [Step(step) for step in json.loads(steps)]
        #: "converged", "stopped", or why the run went no further ("bent as tightly as it is thick" where a rod's
        #: thickness is the reason); "overlap" if it arrived with tubes inside each other
        #: where contact does not resist it.
        self.status = status
        #: What the last attempt failed at; None if it did not fail.
        self.failure = failure
        #: Estimate of the last state's error, as in ``summary.json``: a dict; None unless the scene's ``output`` has
        #: ``error_estimate``.
        self.error_estimate: dict[str, Any] | None = None if error_estimate is None else json.loads(error_estimate)
        #: Wall time [s].
        self.seconds = seconds
        self._steps = steps

    @property
    def converged(self) -> bool:
        """Whether the run arrived at its end, no tubes inside each other."""
        return self.status == "converged"

    @property
    def table(self) -> dict[str, NDArray[Any]]:
        """The columns of ``table.csv``, one entry of each array an accepted step, in the scene's units: what was ramped,
        link and ends of the rods, energies (``bending_energy``, …, ``total_energy``), contact, reactions, ``status``,
        ``notes``: a dict of arrays (n,), their units in :attr:`units`. Where there is no number, as no gap where nothing is near, it
        is NaN."""
        columns = json.loads(self.scene._native.table(self._steps))
        missing = {name: [np.nan if value is None else value for value in values] for name, values in columns}
        return {name: np.array(values) for name, values in missing.items()}

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column of :attr:`table`, for example "pN nm"; "" of plain numbers and texts."""
        return {name: unit for name, unit, _ in self.scene._native.columns()}

    @property
    def meanings(self) -> dict[str, str]:
        """Meaning of each column of :attr:`table`."""
        return {name: meaning for name, _, meaning in self.scene._native.columns()}

    def to_pandas(self, unit_names: bool = False) -> Any:
        """The table as a ``pandas.DataFrame``, its units in ``frame.attrs["units"]``. ``unit_names``: columns are named
        "writhe [turns]".

        Raises :class:`ImportError` without pandas.
        """
        import pandas

        frame = pandas.DataFrame(self._named(unit_names))
        frame.attrs["units"] = self.units
        return frame

    def to_polars(self, unit_names: bool = False) -> Any:
        """The table as a ``polars.DataFrame``, which has no place for units: :attr:`units`, or with ``unit_names`` columns named
        "writhe [turns]".

        Raises :class:`ImportError` without polars.
        """
        import polars

        return polars.DataFrame(self._named(unit_names))

    def _named(self, unit_names: bool) -> dict[str, NDArray[Any]]:
        """The table, its units in its names or not."""
        return {self._label(name) if unit_names else name: column for name, column in self.table.items()}

    def _label(self, column: str) -> str:
        """A column with its unit."""
        unit = self.units.get(column)
        return f"{column} [{unit}]" if unit else column

    def export(
        self,
        *,
        oxdna: Path_ | None = None,
        xyz: Path_ | None = None,
        vect: Path_ | None = None,
        pdb: Path_ | None = None,
        par: Path_ | None = None,
        ref_frames: Path_ | None = None,
        npy: Path_ | None = None,
        glb: Path_ | None = None,
        vtk: Path_ | None = None,
        directory: Path_ | None = None,
        rod: str | None = None,
        base_pairs: int | None = None,
        sequence: str | None = None,
        color: Literal["strand", "pressure", "curvature", "twist_rate"] = "strand",
    ) -> None:
        """Writes the last state into files, each argument a path.

        Of base pairs (units nm): ``oxdna`` (the name of NAME.top and NAME.dat), ``xyz`` and ``vect`` [nm], ``pdb`` (atoms P of
        both strands) [Å], ``par`` and ``ref_frames`` as 3DNA has them, ``npy`` (n, 4, 3) [nm]. ``rod``: which, where there are
        several. ``sequence``: its letters, where the rod has none; ``base_pairs``: how many, where neither tells.

        ``glb``: binary glTF, and ``directory``: all files that ``supercoil run`` writes, of the states kept (``keep="all"``);
        ``vtk``: a ``.vtp`` file of the last state. ``color``: by what rods are coloured in ``glb``.

        Raises :class:`InputError` for other units than nm, a rod that is not there, a number of letters that does not fit,
        files that cannot be written.
        """
        given = {"oxdna": oxdna, "xyz": xyz, "vect": vect, "pdb": pdb, "par": par, "ref_frames": ref_frames, "npy": npy}
        formats = {name: path for name, path in given.items() if path is not None}
        if not formats and glb is None and vtk is None and directory is None:
            raise InputError(f"export: names no file: give one of {', '.join([*given, 'glb', 'vtk', 'directory'])}")
        if base_pairs is not None:
            check_count("base_pairs", base_pairs)
        if formats:
            _supercoil.export(self.scene._native, self.state._native, rod, base_pairs, sequence, formats)
        if directory is not None:
            self._write_run(Path(directory), for_page=False)
        if glb is None and vtk is None:
            return
        with tempfile.TemporaryDirectory() as folder:
            self._write_run(Path(folder))
            if glb is not None:
                _supercoil.write_glb(Path(folder), glb, color)
            if vtk is not None:
                last = max(Path(folder).glob("step_*.vtp"))
                Path(vtk).write_bytes(last.read_bytes())

    def _write_run(self, folder: Path, for_page: bool = True) -> None:
        """The files of a run with the states that were kept: those of the scene's outputs, or those of a page."""
        states = [state._native for state in self.states]
        outcome = (self.converged, (self.status, self.failure), self.seconds)
        _supercoil.write_files(self.scene._native, states, folder, *outcome, for_page)

    def page(self) -> str:
        """The page of ``supercoil view`` as text (HTML): the states that were kept, to turn and to step through."""
        with tempfile.TemporaryDirectory() as folder:
            self._write_run(Path(folder))
            return (Path(folder) / "view.html").read_text(encoding="utf-8")

    def view(self, path: Path_ | None = None, open_browser: bool = True) -> Path:
        """Writes :meth:`page` into a file and shows it in the browser; returns the file (a temporary one without
        ``path``). ``open_browser``: False only writes it.

        Raises :class:`OSError` for a file that cannot be written.
        """
        if path is None:
            path = Path(tempfile.mkdtemp(prefix="supercoil-")) / "view.html"
        file = Path(path).absolute()
        file.write_text(self.page(), encoding="utf-8")
        if open_browser:
            webbrowser.open(file.as_uri())
        return file

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes scene, states that were kept and reports into the file ``path`` for :meth:`load`.

        Raises :class:`OSError` for a file that cannot be written.
        """
        Path(path).write_bytes(pickle.dumps(self))

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Result:
        """Reads what :meth:`save` wrote into the file ``path``. It is a pickle: read only what you trust.

        Raises :class:`InputError` for a pickle of something else.
        """
        result = pickle.loads(Path(path).read_bytes())
        if not isinstance(result, Result):
            raise InputError(f"{path}: must be a saved result, found {type(result).__name__}")
        return result

    def __reduce__(self) -> tuple[Any, ...]:
        states = [state._native.to_bytes() for state in self.states]
        estimate = None if self.error_estimate is None else json.dumps(self.error_estimate)
        return _result_of, (self.scene, states, self._steps, self.status, self.failure, estimate, self.seconds)

    def plot(self, x: str, y: str | Sequence[str], ax: Any = None) -> Any:
        """Draws the columns ``y`` of :attr:`table` against the column ``x``, axes with their units, into the matplotlib axes ``ax``
        or new ones; returns them. Needs matplotlib.

        Raises :class:`InputError` for columns that are not there.
        """
        names, table = [y] if isinstance(y, str) else list(y), self.table
        for name in (x, *names):
            if name not in table:
                raise InputError(f"plot: there is no column {name!r}; there are {', '.join(table)}")
        if ax is None:
            import matplotlib.pyplot

            ax = matplotlib.pyplot.figure().add_subplot()
        for name in names:
            ax.plot(table[x], table[name], marker=".", label=name)
        if len(names) > 1:
            ax.legend()
        ax.set_xlabel(self._label(x))
        ax.set_ylabel(self._label(names[0]) if len(names) == 1 else self.units.get(names[0], ""))
        return ax

    def _repr_png_(self) -> bytes:
        return self.state._repr_png_()

    def _repr_html_(self) -> str:
        page = html.escape(self.page())
        frame = f'<iframe srcdoc="{page}" style="width: 100%; height: 480px; border: 0"></iframe>'
        return f"<p>{html.escape(repr(self))}</p>{frame}{self.state._energies_html(self.units['total_energy'])}"

    def __repr__(self) -> str:
        return f"<Result: {self.status} after {len(self.steps) - 1} steps, {self.seconds:.2f} s>"


def _result_of(
    scene: Scene, states: list[bytes], steps: str, status: str, failure: str | None, estimate: str | None, seconds: float
) -> Result:
    kept = [_supercoil.State.from_bytes(state) for state in states]
    result = Result(scene, kept[-1], steps, status, failure, estimate, seconds)
    result.states = [*map(State, kept[:-1]), result.state]
    return result


@dataclass(frozen=True)
class StepReport:
    """What one step of a solver did."""

    #: "converged", or why not.
    status: str
    #: What broke down; None if nothing did.
    error: str | None
    #: Newton iterations.
    iterations: int
    #: Augmentations of the contact offsets.
    augmentations: int
    #: How many times an unstable equilibrium was left.
    escapes: int
    #: Unstable directions of the state.
    num_unstable: int = field(default=0)

    @property
    def converged(self) -> bool:
        """Whether the state is at rest at its target."""
        return self.status == "converged"


@dataclass(frozen=True)
class PathPoint:
    """A point of a path of equilibria."""

    #: "start", "regular", "limit", "branch", "corner" or "target".
    kind: str
    #: The parameter in the ramp's own unit.
    value: float
    #: Unstable directions.
    num_unstable: int
    #: The state there.
    state: State


@dataclass(frozen=True)
class EquilibriumPath:
    """A path of equilibria."""

    #: "Target", "MaxPoints", "StepTooSmall", "NoStart", "Stopped" or "BrokeDown".
    end: str
    #: In order along the path, the start first.
    points: list[PathPoint]


def _stage_text(stage: Stage) -> str:
    """The text of a stage, checked; its argument names are those of the call."""
    plain = Inputs().plain(stage)
    rule = schema()["$defs"]["RampText"]
    check(plain["ramp"], rule, "")
    return tomli_w.dumps({"stages": [plain]})


@contextmanager
def _in_arguments() -> Iterator[None]:
    """Errors about the only stage of a solver by hand as ones about its arguments."""
    try:
        yield
    except InputError as error:
        raise InputError(re.sub(r"^(stages\[0\]\.ramp(\.|: )|follow\.)", "", str(error))) from None


class Solver:
    """Equilibria one after the other, each from the one before."""

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        self._native = _supercoil.Solver(scene._native, threads)

    def settle(self) -> StepReport:
        """Brings the present state to rest."""
        return StepReport(*self._native.step_to(None))

    def step_to(
        self,
        *,
        excess_link: float | Table | list[Table] | None = None,
        rotation: Table | list[Table] | None = None,
        displacement: Table | list[Table] | None = None,
        load: float | None = None,
        pressure: float | Table | list[Table] | None = None,
        pose: Table | list[Table] | None = None,
        sigma: float | Table | list[Table] | None = None,
        link: float | Table | list[Table] | None = None,
        plane: float | Table | list[Table] | None = None,
        obstacle: Table | list[Table] | None = None,
        section: Table | list[Table] | None = None,
        length: float | Table | list[Table] | None = None,
        natural: Table | list[Table] | None = None,
        binding: float | Table | list[Table] | None = None,
    ) -> StepReport:
        """Moves all that is given to its target in one step, without cut-back; targets as in :class:`Stage`.

        A step that does not converge leaves the solver where the attempt ended. Raises :class:`InputError` for targets that are
        refused, :class:`SolveError` where numbers break down.
        """
        stage = Stage(
            excess_link=excess_link,
            rotation=rotation,
            displacement=displacement,
            load=load,
            pressure=pressure,
            pose=pose,
            sigma=sigma,
            link=link,
            plane=plane,
            obstacle=obstacle,
            section=section,
            length=length,
            natural=natural,
            binding=binding,
        )
        with _in_arguments():
            return StepReport(*self._native.step_to(_stage_text(stage)))

    def follow(
        self,
        *,
        excess_link: float | Table | None = None,
        rotation: Table | None = None,
        displacement: Table | None = None,
        load: float | None = None,
        pressure: float | Table | None = None,
        sigma: float | Table | None = None,
        link: float | Table | None = None,
        start: Literal["towards", "away", "branch", "other-branch"] = "towards",
        step: float = 0.05,
        max_step: float = 0.2,
        max_points: int = 500,
    ) -> EquilibriumPath:
        """Follows the path of equilibria past limit points, stable or not, with one ramp as its parameter.

        ``start``: towards the ramp's target, or away from it; at a branch point onto the branch, in either of its directions.

        ``step`` and ``max_step`` are arc lengths of the path: ds² = mean |δr|²/L² + mean |θ|² + (δλ/range)². The solver
        keeps the last of at most ``max_points``. The ramp is given as to :class:`Stage`.

        Raises :class:`InputError` for several ramps or a target that is refused.
        """
        options = {"start": start, "step": step, "max_step": max_step, "max_points": max_points}
        check(options, schema()["$defs"]["FollowChoice"], "")
        stage = Stage(
            excess_link=excess_link,
            rotation=rotation,
            displacement=displacement,
            load=load,
            pressure=pressure,
            sigma=sigma,
            link=link,
        )
        text = _stage_text(stage)
        with _in_arguments():
            end, points = self._native.follow(text, start, (step, max_step), max_points)
        return EquilibriumPath(end, [PathPoint(kind, value, unstable, State(state)) for kind, value, unstable, state in points])

    @property
    def state(self) -> State:
        """The present state; before the first step the start shape, settled."""
        return State(self._native.state())

    def num_unstable(self) -> int:
        """Number of unstable directions of the present state."""
        return self._native.num_unstable()
