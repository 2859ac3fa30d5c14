"""Contact and topology of curves of one's own; knows no rods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _supercoil
from ._inputs import numbers

__all__ = ["Curve", "detect", "link", "writhe"]


@dataclass(kw_only=True)
class Curve:
    """A polyline through ``points`` (n, 3) [L] with a contact ``radius`` [L]: one number, or one a segment. ``closed`` joins the
    last point to the first."""

    points: ArrayLike
    radius: float | ArrayLike
    closed: bool = False


def _points(argument: str, points: ArrayLike) -> NDArray[np.float64]:
    return np.ascontiguousarray(np.atleast_2d(numbers(argument, points)))


def _curve(k: int, curve: Curve) -> tuple[NDArray[np.float64], list[float], bool]:
    radii = np.atleast_1d(numbers(f"curves[{k}].radius", curve.radius)).tolist()
    return _points(f"curves[{k}].points", curve.points), radii, curve.closed


def detect(curves: Sequence[Curve], range: float = 0.0) -> dict[str, NDArray[Any]]:
    """All local minima of the distance between curves, and between parts of one that are not neighbours, whose gap
    (distance minus both radii) is at most ``range`` [L].

    One entry of each array a site: ``curve_a``, ``segment_a`` (c,), ``u_a`` (c,) in [0, 1] on the segment, ``arc_a``
    (c,) [L], the same with ``_b``, ``gap`` (c,) [L], ``angle`` (c,) between the tangents, rad, ``normal`` (c, 3) from a
    to b. Raises :class:`supercoil.InputError`.
    """
    return _supercoil.detect([_curve(k, curve) for k, curve in enumerate(curves)], range)


def link(a: ArrayLike, b: ArrayLike) -> float:
    """Linking number of two closed polygons ``a`` (n, 3) and ``b`` (m, 3), an integer up to rounding.

    Raises :class:`supercoil.InputError` for points that are not finite, which it names. Where polygons cross each other the
    number is the mean of those beside the crossing.
    """
    return _supercoil.linking_number(_points("a", a), _points("b", b))


def writhe(points: ArrayLike, closed: bool = True) -> float:
    """Writhe of the polygon through ``points`` (n, 3), turns; ``closed`` joins the last to the first.

    Raises :class:`supercoil.InputError` for points that are not finite.
    """
    return _supercoil.writhe(_points("points", points), closed)
