"""Scenes, their runs, and the solver driven by hand."""

from __future__ import annotations

import html
import json
import os
import pickle
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w
from numpy.typing import NDArray

from . import _supercoil
from .errors import InputError
from .state import State

Table = dict[str, Any]
Vector = Sequence[float] | NDArray[Any]


@dataclass(kw_only=True)
class Rod:
    """A rod, with the keys of ``[[rods]]`` in a scene file.

    ``shape`` and ``section`` are tables such as ``{"kind": "circle", "length": 6.0}`` [L] and ``{"bending": 1.0,
    "twisting": 1.5, "stretching": 1e4, "shearing": 1e4, "contact_radius": 0.1}`` [F·L², F, L]. ``elements`` may be left
    out where the scene has a fidelity. Closed rods have an ``excess_link`` [turns beyond the relaxed rod], or in its place
    ``sigma`` or the whole ``link``; open ones a ``twist`` [turns]. ``dna``, such as ``{"base_pairs": 336, "salt_mM": 150}``,
    stands for the section and the shape's length, in nm and pN.
    """

    shape: Table
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


@dataclass(kw_only=True)
class Support:
    """Fixes a node: ``at`` is "start", "end", a node index or ``{"arc": s}``; ``position`` and ``rotation`` are True or
    a list of axes such as ``["x", "y"]``."""

    at: str | int | Table
    rod: str | list[str] | None = None
    position: bool | list[str] = False
    rotation: bool | list[str] = False


@dataclass(kw_only=True)
class Load:
    """Dead force [F] and moment [F·L] at a node, times the load factor of the stages."""

    at: str | int | Table
    rod: str | None = None
    force: Vector | None = None
    moment: Vector | None = None


@dataclass(kw_only=True)
class LineLoad:
    """Dead force [F/L] and moment [F] per reference length on a whole rod, times the load factor of the stages."""

    force: Vector | None = None
    moment: Vector | None = None
    rod: str | None = None


@dataclass(kw_only=True)
class Plane:
    """A plane that rods rest on, without friction: ``normal`` [a unit vector] points towards the rods, ``point`` [L] is on
    it. Several need names, by which stages move them."""

    normal: Vector
    point: Vector | None = None
    name: str | None = None


@dataclass(kw_only=True)
class Stage:
    """What moves, in so many ``steps``. All targets are absolute and all ramps of a stage move together.

    ``excess_link``: turns, or ``{"rod": …, "to": turns}``; so ``link`` [turns] and ``sigma``. ``pose``: ``{"at": …,
    "position": [x, y, z], "quaternion": [w, x, y, z]}`` and what else the key takes in scene files. ``rotation``: ``{"at": …, "axis": […], "turns": …}``.
    ``displacement``: ``{"at": …, "to": [x, y, z]}`` [L]. ``plane``: displacement along its normal [L], or ``{"name": …, "to": …}``. ``load``: the factor. ``pressure``: [F/L], or a table. Lists of
    tables move several nodes or rods.
    """

    steps: int = 1
    excess_link: float | Table | list[Table] | None = None
    rotation: Table | list[Table] | None = None
    displacement: Table | list[Table] | None = None
    load: float | None = None
    pressure: float | Table | list[Table] | None = None
    plane: float | Table | list[Table] | None = None
    pose: Table | list[Table] | None = None
    sigma: float | Table | list[Table] | None = None
    link: float | Table | list[Table] | None = None

    def _table(self) -> Table:
        ramp = _plain(self)
        steps = ramp.pop("steps")
        for key in ("excess_link", "sigma", "link", "pressure", "plane"):
            if key in ramp and not isinstance(ramp[key], (dict, list)):
                ramp[key] = {"to": ramp[key]}
        return {"ramp": ramp, "steps": steps}


def _plain(value: Any) -> Any:
    """The value as TOML knows it; keys that are None are left out."""
    if hasattr(value, "__dataclass_fields__"):
        return _plain({f.name: getattr(value, f.name) for f in fields(value)})
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items() if entry is not None}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    return value


def _check_threads(threads: int | None) -> None:
    if threads is not None and threads < 1:
        raise InputError(f"threads = {threads}: must be at least 1")


class Scene:
    """A problem, its stages and its solver's choices; checked when it is made.

    Every key is explained with the scene files; keyword arguments here have the same names.
    """

    def __init__(
        self,
        rods: Rod | Sequence[Rod],
        *,
        stages: Stage | Sequence[Stage] = (),
        supports: Sequence[Support] = (),
        joints: Sequence[Table] = (),
        loads: Sequence[Load] = (),
        line_loads: Sequence[LineLoad] = (),
        planes: Sequence[Plane] = (),
        contact: Table | None = None,
        solver: Table | None = None,
        fidelity: Literal["draft", "balanced", "reference"] | None = None,
        planar: bool = False,
        title: str = "",
        units: Table | None = None,
    ) -> None:
        stages = [stages] if isinstance(stages, Stage) else list(stages)
        scene = {
            "title": title,
            "planar": planar,
            "fidelity": fidelity,
            "units": units,
            "rods": [rods] if isinstance(rods, Rod) else list(rods),
            "supports": list(supports),
            "joints": list(joints),
            "loads": list(loads),
            "line_loads": list(line_loads),
            "planes": list(planes),
            "contact": contact,
            "solver": solver,
            "stages": [stage._table() for stage in stages],
        }
        self._read(tomli_w.dumps(_plain(scene)), Path())

    def _read(self, text: str, base_dir: Path) -> None:
        self._native = _supercoil.Scene(text, base_dir)
        self._text, self._base_dir = text, base_dir

    @classmethod
    def from_toml(cls, source: str | os.PathLike[str]) -> Scene:
        """Reads a scene from a file, or from text if ``source`` is a string of more than one line.

        Files named in a scene file are found relative to it, those named in text relative to the working directory.
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

        The contact diameter follows the concentration of sodium chloride, ``salt_mM`` from 10 to 1000 mmol/l. Without
        ``elements`` the fidelity sets the mesh.
        """
        if base_pairs < 1:
            raise InputError(f"base_pairs = {base_pairs}: must be at least 1")
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
        """The scene as the text of a scene file, as it was read or made."""
        return self._text

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
    ) -> Result:
        """Runs all stages.

        ``callback`` sees the start and every accepted state, and stops the run by returning False; its exceptions and
        Ctrl-C end the run and pass through. ``progress`` prints a line a step to the error stream. ``threads`` do not
        change the result; by default all are used. Other Python threads go on meanwhile.

        Raises :class:`InputError` and :class:`SolveError`; a run that does not converge has a status in its result.
        """
        _check_threads(threads)

        def seen(native: _supercoil.State) -> object:
            state = State(native)
            if progress:
                step = state.observation
                print(
                    f"step {step['step']}: stage {step['stage'] + 1} at {100 * step['fraction']:.0f} %, "
                    f"energy {step['energies']['total']:.6g}, {step['num_sites']} contact sites",
                    file=sys.stderr,
                )
            return None if callback is None else callback(state)

        watch = seen if progress or callback is not None else None
        return Result(self, *self._native.run(watch, threads))

    def solver(self, threads: int | None = None) -> Solver:
        """The solver, to be driven by hand; the stages of the scene are not run."""
        _check_threads(threads)
        return Solver(self, threads)

    def __reduce__(self) -> tuple[Any, ...]:
        return _scene_of, (self._text, self._base_dir)

    def __repr__(self) -> str:
        names = ", ".join(rod["name"] for rod in self.rods)
        return f"<Scene {self.title!r}: {names}>"


def _scene_of(text: str, base_dir: Path) -> Scene:
    scene = Scene.__new__(Scene)
    scene._read(text, base_dir)
    return scene


class Result:
    """How a run went."""

    def __init__(
        self, scene: Scene, state: _supercoil.State, steps: str, status: str, failure: str | None, seconds: float
    ) -> None:
        self.scene = scene
        #: The last accepted state.
        self.state = State(state)
        #: Reports of all accepted steps, the start first, as in ``summary.json``.
        self.steps: list[dict[str, Any]] = json.loads(steps)
        #: "converged", "stopped", or why the run went no further ("bent as tightly as it is thick" where a rod's
        #: thickness is the reason); "overlap" if it arrived with tubes inside each other
        #: where contact does not resist it.
        self.status = status
        #: What the last attempt failed at; None if it did not fail.
        self.failure = failure
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
        ``notes``. Where there is no number, as no gap where nothing is near, it is NaN."""
        columns = json.loads(self.scene._native.table(self._steps))
        missing = {name: [np.nan if value is None else value for value in values] for name, values in columns}
        return {name: np.array(values) for name, values in missing.items()}

    def to_pandas(self) -> Any:
        """The table as a ``pandas.DataFrame``; needs pandas."""
        import pandas

        return pandas.DataFrame(self.table)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes scene, last state and reports into a file for :meth:`load`."""
        Path(path).write_bytes(pickle.dumps(self))

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Result:
        """Reads what :meth:`save` wrote. The file is a pickle: read only what you trust."""
        result = pickle.loads(Path(path).read_bytes())
        if not isinstance(result, Result):
            raise InputError(f"{path}: must be a saved result, found {type(result).__name__}")
        return result

    def __reduce__(self) -> tuple[Any, ...]:
        state = self.state._native.to_bytes()
        return _result_of, (self.scene, state, self._steps, self.status, self.failure, self.seconds)

    def plot(self, x: str, y: str, ax: Any = None) -> Any:
        """Draws two columns of :attr:`table` against each other; returns the matplotlib axes. Needs matplotlib."""
        if ax is None:
            import matplotlib.pyplot

            ax = matplotlib.pyplot.figure().add_subplot()
        ax.plot(self.table[x], self.table[y], marker=".")
        ax.set_xlabel(x)
        ax.set_ylabel(y)
        return ax

    def _repr_png_(self) -> bytes:
        return self.state._repr_png_()

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self))}</p>{self.state._repr_html_()}"

    def __repr__(self) -> str:
        return f"<Result: {self.status} after {len(self.steps) - 1} steps, {self.seconds:.2f} s>"


def _result_of(scene: Scene, state: bytes, steps: str, status: str, failure: str | None, seconds: float) -> Result:
    return Result(scene, _supercoil.State.from_bytes(state), steps, status, failure, seconds)


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
    num_unstable: int
    state: State


@dataclass(frozen=True)
class EquilibriumPath:
    """A path of equilibria."""

    #: "Target", "MaxPoints", "StepTooSmall", "NoStart", "Stopped" or "BrokeDown".
    end: str
    points: list[PathPoint]


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
    ) -> StepReport:
        """Moves all that is given to its target in one step, without cut-back; targets as in :class:`Stage`.

        A step that does not converge leaves the solver where the attempt ended.
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
        )
        return StepReport(*self._native.step_to(tomli_w.dumps({"stages": [stage._table()]})))

    def follow(
        self,
        *,
        excess_link: float | Table | None = None,
        rotation: Table | None = None,
        displacement: Table | None = None,
        load: float | None = None,
        pressure: float | Table | None = None,
        step: float = 0.05,
        max_step: float = 0.2,
        max_points: int = 500,
    ) -> EquilibriumPath:
        """Follows the path of equilibria past limit points, stable or not, with one ramp as its parameter.

        ``step`` and ``max_step`` are arc lengths of the path: ds² = mean |δr|²/L² + mean |θ|² + (δλ/range)². The solver
        keeps the last point.
        """
        stage = Stage(
            excess_link=excess_link, rotation=rotation, displacement=displacement, load=load, pressure=pressure
        )
        text = tomli_w.dumps({"stages": [stage._table()]})
        end, points = self._native.follow(text, (step, max_step), max_points)
        return EquilibriumPath(end, [PathPoint(kind, value, unstable, State(state)) for kind, value, unstable, state in points])

    @property
    def state(self) -> State:
        """The present state; before the first step the start shape, settled."""
        return State(self._native.state())

    def num_unstable(self) -> int:
        """Number of unstable directions of the present state."""
        return self._native.num_unstable()
