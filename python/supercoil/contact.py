"""Contact and topology of curves of one's own; knows no rods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _supercoil

__all__ = ["Curve", "detect", "link", "writhe"]


@dataclass(kw_only=True)
class Curve:
    """A polyline through ``points`` (n, 3) [L] with a contact ``radius`` [L]: one number, or one a segment. ``closed`` joins the
    last point to the first."""

    points: ArrayLike
    radius: float | ArrayLike
    closed: bool = False


def _points(points: ArrayLike) -> NDArray[np.float64]:
    return np.ascontiguousarray(np.atleast_2d(np.asarray(points, dtype=np.float64)))


def detect(curves: Sequence[Curve], range: float = 0.0) -> dict[str, NDArray[Any]]:
    """All local minima of the distance between curves, and between parts of one that are not neighbours, whose gap
    (distance minus both radii) is at most ``range`` [L].

    One entry of each array a site: ``curve_a``, ``segment_a`` (c,), ``u_a`` (c,) in [0, 1] on the segment, ``arc_a``
    (c,) [L], the same with ``_b``, ``gap`` (c,) [L], ``angle`` (c,) between the tangents, rad, ``normal`` (c, 3) from a
    to b. Raises :class:`supercoil.InputError`.
    """
    native = [(_points(c.points), np.atleast_1d(np.asarray(c.radius, dtype=float)).tolist(), c.closed) for c in curves]
    return _supercoil.detect(native, range)


def link(a: ArrayLike, b: ArrayLike) -> float:
    """Linking number of two closed polygons ``a`` (n, 3) and ``b`` (m, 3), an integer up to rounding.

    Raises :class:`supercoil.InputError` for points that are not finite, which it names. Where polygons cross each other the
    number is the mean of those beside the crossing.
    """
    return _supercoil.linking_number(_points(a), _points(b))


def writhe(points: ArrayLike, closed: bool = True) -> float:
    """Writhe of the polygon through ``points`` (n, 3), turns; ``closed`` joins the last to the first.

    Raises :class:`supercoil.InputError` for points that are not finite.
    """
    return _supercoil.writhe(_points(points), closed)
