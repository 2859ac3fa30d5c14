"""States: everything known of an accepted equilibrium, as arrays."""

from __future__ import annotations

import base64
import html
import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _supercoil
from ._inputs import check_count
from .errors import InputError

if TYPE_CHECKING:
    import os

Floats = NDArray[np.float64]

_SITE_NUMBERS = ("rod_a", "rod_b", "arc_a", "arc_b", "gap", "force", "center", "spread", "angle", "force_on_a", "feet")
_INDICES = ("rod_a", "rod_b")
_SHAPES: dict[str, tuple[int, ...]] = {
    "arc_a": (2,),
    "arc_b": (2,),
    "center": (2,),
    "spread": (2,),
    "force_on_a": (3,),
    "feet": (2, 3),
}


@dataclass(frozen=True)
class Modes:
    """Softest modes of m shapes over n nodes, ascending."""

    #: (m,) eigenvalues over B/L⁴ of the smallest bending stiffness and the longest rod; of rods with masses ω² over that.
    eigenvalues: Floats
    #: B/L⁴ [F/L²].
    unit: float
    #: (m,) frequencies of rods with masses [1/T, T² = mass·L/F]; None without.
    frequencies: Floats | None
    #: (m, 4) shares of stretch, shear, bend and twist in the elastic energy.
    participation: Floats
    #: (m, n, 3) displacements [L]; a shape has the root mean square 1.
    displacements: Floats
    #: (m, n, 3) rotation vectors [rad].
    rotations: Floats


class State:
    """A state of all rods. Nodes stand rod after rod: rod k has those of ``slice(*state.node_ranges[k])``.

    Lengths are in the scene's unit [L], forces in [F]; link, twist and writhe in turns. Arrays are made when they are
    asked for, then kept; they belong to the caller's process, not to the solver.
    """

    def __init__(self, native: _supercoil.State) -> None:
        self._native = native

    @cached_property
    def observation(self) -> dict[str, Any]:
        """All reports of the state, as in ``summary.json``: energies, links, sites, reactions, iterations, …"""
        observation: dict[str, Any] = json.loads(self._native.observation_json())
        return observation

    @cached_property
    def rod_names(self) -> list[str]:
        """Names of the rods, in their order."""
        return [rod[0] for rod in self._native.rods()]

    @cached_property
    def node_ranges(self) -> list[tuple[int, int]]:
        """First node and the one after the last, of every rod."""
        ends = np.cumsum([0] + [rod[3] for rod in self._native.rods()]).tolist()
        return list(zip(ends[:-1], ends[1:], strict=True))

    @cached_property
    def arc_lengths(self) -> Floats:
        """(n,) reference arc length of the nodes [L], from the start of each rod."""
        return self._native.arc_lengths()

    @cached_property
    def positions(self) -> Floats:
        """(n, 3) positions of the nodes [L]."""
        return self._native.positions()

    @cached_property
    def quaternions(self) -> Floats:
        """(n, 4) unit quaternions (w, x, y, z), scalar part first: d1, d2, d3 are the axes turned by them."""
        return self._native.quaternions()

    @cached_property
    def frames(self) -> Floats:
        """(n, 3, 3) frames of unit vectors: ``frames[i, k]`` is d1, d2, d3 of node i for k = 0, 1, 2; d3 runs along the rod."""
        w, x, y, z = self.quaternions.T
        d1 = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)
        d2 = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], axis=-1)
        d3 = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
        return np.stack([d1, d2, d3], axis=1)

    @cached_property
    def strain_arc_lengths(self) -> Floats:
        """(m,) reference arc length [L] of the integration points, where strains and stresses are known."""
        return self._native.strain_arc_lengths()

    @cached_property
    def strains(self) -> Floats:
        """(m, 6) Γ1, Γ2, Γ3 (1 at rest), K1, K2, K3 [1/L] at the integration points, natural strains included."""
        return self._native.strains()

    @cached_property
    def stresses(self) -> Floats:
        """(m, 6) forces [F] and moments [F·L] along d1, d2, d3 at the integration points."""
        return self._native.stresses()

    @cached_property
    def contact_force(self) -> Floats:
        """(n, 3) contact force per length on the nodes [F/L], spread over the width of the law, as pictures show it."""
        return self._native.contact_force()

    @cached_property
    def contacts(self) -> dict[str, NDArray[Any]]:
        """Contact sites, one entry of each array a site: ``rod_a``, ``rod_b`` (c,); ``arc_a``, ``arc_b`` (c, 2) [L];
        ``gap`` (c,) [L]; ``force`` (c,) [F]; ``center``, ``spread`` (c, 2) [L]; ``angle`` (c,) degrees; ``force_on_a``
        (c, 3) [F]; ``feet`` (c, 2, 3) [L]; ``kind`` (c,) "point" or "line"."""
        sites = self.observation["sites"]
        table: dict[str, NDArray[Any]] = {}
        for name in _SITE_NUMBERS:
            kind: type = np.int64 if name in _INDICES else np.float64
            values: NDArray[Any] = np.array([site[name] for site in sites], dtype=kind)
            table[name] = values.reshape((len(sites), *_SHAPES.get(name, ())))
        table["kind"] = np.array([site["kind"] for site in sites], dtype="U5")
        return table

    @property
    def energies(self) -> dict[str, float]:
        """Energies [F·L]: stretch, shear, bend, twist, contact, electrostatic, total."""
        return dict(self.observation["energies"])

    def _link_number(self, name: str) -> float:
        links = self.observation["links"]
        ends = self.observation["ends"]
        if not links and len(ends) == 1:
            # of an open rod whose end tangents are not parallel there is neither link nor writhe
            return float("nan") if ends[0][name] is None else float(ends[0][name])
        if len(links) != 1:
            closed = [self.rod_names[link["rod"]] for link in links]
            raise AttributeError(f"{name}: must be of exactly one closed rod, found {closed}: see state.links, state.ends")
        return float(links[0][name])

    @property
    def ends(self) -> list[dict[str, Any]]:
        """Of every open rod: ``start``, ``end`` [L], ``twist``, ``excess_twist``, ``link``, ``writhe`` [turns]; link and
        writhe are None where the end tangents are not parallel."""
        return list(self.observation["ends"])

    def end_moments(self, rod: str | None = None) -> dict[str, NDArray[Any]]:
        """Moments [F·L], in the global axes, that the supports exert at the ends of an open ``rod`` (by default the only one):
        ``start``, ``end`` (3,); zero at an end that is free to turn.

        Raises :class:`InputError` for a rod that is not there.
        """
        index = 0 if rod is None and len(self.rod_names) == 1 else self._rod_index(rod)
        first, end = self.node_ranges[index]
        moments = {"start": np.zeros(3), "end": np.zeros(3)}
        for reaction in self.reactions:
            if reaction["rod"] == index and reaction["node"] in (0, end - first - 1):
                moments["start" if reaction["node"] == 0 else "end"] += np.array(reaction["moment"])
        return moments

    def _rod_index(self, rod: str | None) -> int:
        if rod not in self.rod_names:
            raise InputError(f"rod = {rod!r}: must be one of {', '.join(map(repr, self.rod_names))}")
        return self.rod_names.index(rod)

    @property
    def links(self) -> list[dict[str, float]]:
        """Link numbers of the closed rods, turns; ``seam_moment`` [F·L]."""
        return list(self.observation["links"])

    @property
    def link(self) -> float:
        """Link of the one rod, turns; of several see :attr:`links`. Of an open one the link of the rod extended by straight
        lines, NaN where its end tangents are not parallel."""
        return self._link_number("link")

    @property
    def twist(self) -> float:
        """Twist of the one rod, turns."""
        return self._link_number("twist")

    @property
    def writhe(self) -> float:
        """Writhe of the one rod, turns; of an open one as :attr:`link`."""
        return self._link_number("writhe")

    @property
    def obstacle_reactions(self) -> list[dict[str, Any]]:
        """What each plane, cylinder, sphere, bead and grip exerts: ``obstacle`` (index: planes, obstacles, beads, grips), ``placement``
        (``level``, of a plane its displacement along its normal, of others the radius [L]; ``displacement`` [L], ``turns``;
        ``rotation``, of what a node carries, a rotation vector), ``force``, the integral of the pressure [F], ``force_on_rods`` [F]."""
        return list(self.observation["obstacle_reactions"])

    @property
    def joints(self) -> list[dict[str, Any]]:
        """Forces [F] and moments [F·L] that joints exert on the rods, one entry for each joined node: ``point``, ``rod``, ``node``,
        ``force``, ``moment``. Those of one ``point`` add up to zero; a pin has no moment, a hinge none about its axis."""
        return list(self.observation["joints"])

    @property
    def reactions(self) -> list[dict[str, Any]]:
        """Reactions of the supports: ``rod``, ``node``, ``force`` [F], ``moment`` [F·L]."""
        return list(self.observation["reactions"])

    @property
    def status(self) -> str:
        """"converged", or why not; "fails ..." where a check of the certificate does not hold."""
        return str(self.observation["status"])

    @property
    def certificate(self) -> list[dict[str, Any]]:
        """What holds of the state, by code that shares nothing with the solver: a dict for each check with its ``name``,
        ``value``, ``tolerance``, whether it ``holds``, and ``detail``, unit and place."""
        return list(self.observation["certificate"]["checks"])

    @property
    def notes(self) -> list[str]:
        """What to know of the state before believing it, in words."""
        return list(self.observation["notes"])

    def modes(self, count: int = 6, *, contacts: str = "law") -> Modes:
        """The ``count`` softest modes. ``contacts``: "law", "locked" or "free", see the page on the tangent of the manual.

        Raises :class:`InputError` for another word or a ``count`` below 1, and of a state that was pickled or read from a file.
        """
        check_count("count", count)
        eigenvalues, unit, frequencies, shares, shapes = self._native.modes(count, contacts)
        nodes = shapes.reshape(len(eigenvalues), -1, 6)
        swings = None if frequencies is None else np.array(frequencies)
        parts = np.array(shares).reshape(-1, 4)
        return Modes(np.array(eigenvalues), unit, swings, parts, nodes[:, :, :3], nodes[:, :, 3:])

    def gradient(self, of: str, to: str | Sequence[str], *, contacts: str | None = None) -> Floats:
        """Derivatives [unit of the observable per unit of the parameter], by the adjoint: (n,) of a list, () of one name.

        ``of``: "energy", "contact_force"; "twist", "writhe", "extension", "seam_moment" of the first rod, or
        "twist:name" of another; "position_x:name:node" …, "force_z:name:end", "moment_y:name:start" … of a support.

        ``to``: "load", "link", "pressure", "bending", "bending_1", "twisting", "stretching", "shearing",
        "contact_radius", "length", "natural_curvature_1", "natural_twist" …, of the first rod or "bending:name" of
        another; "displacement_x:name:end", "rotation_y:name:start" … of a support; "obstacle_level", "obstacle_x",
        "obstacle_turns" … of the first obstacle or "obstacle_level:name". "natural_strains" or "natural_strains:name",
        by itself: (rows, 6) of the rows of the rod's table, or of the steps of its sequence.

        ``contacts``: by default gaps that carry force stay closed under hard contact, and give under a penalty.

        Raises :class:`InputError` for names that are not these, and of a state that was pickled or read from a file.
        """
        if not isinstance(to, str):
            return np.array(self._native.gradient([of], list(to), contacts)[1][0])
        table = self._native.gradient_of_table(of, to, contacts)
        return np.array(self._native.gradient([of], [to], contacts)[1][0][0]) if table is None else table

    def values_and_gradients(
        self, of: Sequence[str], to: Sequence[str], *, contacts: str | None = None
    ) -> tuple[Floats, Floats]:
        """(m,) values of observables [each in its unit], and (m, n) derivatives with respect to parameters, by their names; ``of``,
        ``to``, ``contacts``, units and errors as of :meth:`gradient`.

        Raises :class:`InputError`.
        """
        values, slopes = self._native.gradient(list(of), list(to), contacts)
        return np.array(values), np.array(slopes).reshape(len(values), len(to))

    def one_sided(self) -> list[str]:
        """Why derivatives hold on one side only: contacts about to open. Empty if they hold on both."""
        return self._native.one_sided()

    def free_energy(self, kT: float | None = None, *, contacts: str = "free") -> float:
        """The harmonic free energy [F·L] at kT [F·L], by default that of the scene's temperature (in nm and pN).

        Only differences between states of the same rods on the same mesh mean anything. "free" and "locked" contacts
        are its two bounds.

        Raises :class:`InputError` without ``kT`` in other units, and of a state that was pickled or read from a file.
        """
        return self._native.free_energy(kT, contacts)

    def j_factor(self, open: State, kT: float | None = None, *, contacts: str = "free") -> float:
        """The J-factor [1/L³] of this ring, or loop between its clamps, by a state ``open`` of the same rod with a free end;
        ``kT`` and ``contacts`` as of :meth:`free_energy`.

        Raises :class:`InputError` for another rod or mesh, and of states that were pickled or read from a file.
        """
        return self._native.j_factor(open._native, kT, contacts)

    def covariance(self, of: Sequence[str], kT: float | None = None, *, contacts: str = "free") -> Floats:
        """(n, n) covariances of the observables ``of`` [unit of one times unit of the other], to leading order in ``kT``; names as in
        :meth:`gradient`, ``contacts`` as of :meth:`free_energy`.

        Raises :class:`InputError` for names that are not these, and of a state that was pickled or read from a file.
        """
        return np.array(self._native.covariance(list(of), kT, contacts))

    def anharmonicity(self, kT: float | None = None, count: int = 4) -> Floats:
        """(m,) of the ``count`` softest modes: how far the energy at their thermal amplitude is off the quadratic one, in units of
        ``kT``/2. Above 0.5 free energies and covariances are void: the next contact or saddle is as near.

        Raises :class:`InputError` without ``kT`` in other units, and of a state that was pickled or read from a file.
        """
        check_count("count", count)
        return np.array(self._native.anharmonicity(count, kT))

    def save_picture(self, path: str | os.PathLike[str], width: int = 800, height: int = 600) -> None:
        """Draws the rods as tubes, contact glowing, into the PNG file ``path`` of ``width`` times ``height`` pixels.

        Raises :class:`InputError` for a size that is too large, a file that cannot be written.
        """
        check_count("width", width)
        check_count("height", height)
        self._native.save_picture(path, width, height)

    def _repr_png_(self) -> bytes:
        """The picture, for notebooks."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "state.png"
            self.save_picture(path, 600, 450)
            return path.read_bytes()

    def _energies_html(self, unit: str = "F·L") -> str:
        energies = "".join(f"<tr><td>{kind}</td><td>{value:.6g}</td></tr>" for kind, value in self.energies.items())
        return f"<table><tr><th>energy</th><th>{html.escape(unit)}</th></tr>{energies}</table>"

    def _repr_html_(self) -> str:
        picture = base64.b64encode(self._repr_png_()).decode()
        image = f'<img src="data:image/png;base64,{picture}"/>'
        return f"<p>{html.escape(repr(self))}</p>{image}{self._energies_html()}"

    def plot(self, ax: Any = None) -> Any:
        """Draws the centrelines [L] into the matplotlib axes ``ax`` or new ones, to scale; returns them.

        Raises :class:`ImportError` without matplotlib.
        """
        if ax is None:
            import matplotlib.pyplot

            ax = matplotlib.pyplot.figure().add_subplot(projection="3d")
        for name, (first, end), rod in zip(self.rod_names, self.node_ranges, self._native.rods(), strict=True):
            nodes = [*range(first, end), *([first] if rod[1] else [])]
            ax.plot(*self.positions[nodes].T, label=name)
        ax.set_aspect("equal")
        return ax

    def to_pyvista(self) -> Any:
        """The centrelines as a ``pyvista.PolyData`` with frames and contact force; needs pyvista."""
        import pyvista

        lines: list[int] = []
        for (first, end), rod in zip(self.node_ranges, self._native.rods(), strict=True):
            nodes = [*range(first, end), *([first] if rod[1] else [])]
            lines += [len(nodes), *nodes]
        mesh = pyvista.PolyData(self.positions, lines=np.array(lines))
        for k, name in enumerate(("d1", "d2", "d3")):
            mesh.point_data[name] = self.frames[:, k]
        mesh.point_data["smoothed_contact_force_per_length"] = self.contact_force
        return mesh

    def _nodes(self) -> dict[str, NDArray[Any]]:
        """The columns of a ``final_state.csv``, from which other scenes start."""
        rods = [k for k, (first, end) in enumerate(self.node_ranges) for _ in range(first, end)]
        table = {"rod": np.array(rods), "arc_length": self.arc_lengths}
        table |= dict(zip("xyz", self.positions.T, strict=True))
        return table | dict(zip(("qw", "qx", "qy", "qz"), self.quaternions.T, strict=True))

    def __reduce__(self) -> tuple[Any, ...]:
        return _state_of, (self._native.to_bytes(),)

    def __repr__(self) -> str:
        nodes, sites = len(self.positions), self.observation["num_sites"]
        return f"<State of {', '.join(self.rod_names)}: {nodes} nodes, {sites} contact sites, {self.status}>"


def _state_of(data: bytes) -> State:
    return State(_supercoil.State.from_bytes(data))
