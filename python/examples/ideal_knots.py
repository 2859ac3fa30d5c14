"""Prime knots pulled tight: length over diameter beside the published values (KnotInfo).

A closed rod thickens until its tube is 1 % short of the ideal knot's. Whether it arrives there is the question: a knot that jams in
another shape does not, and from a closed braid eight of 35 do not arrive. So a chain of beads that repel each other looks for
a shape to begin with: 100 times it is pulled at random and let go, and the best shape is kept. What counts is the tightest
state of the rod that is at rest and passes all checks. The published lengths are over the radius; half of that is the
ropelength here.

    pip install database-knotinfo
    python ideal_knots.py [NAME ...]        # by default all of three to eight crossings: an hour
"""

import json
import sys
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from supercoil import Result, Rod, Scene, Stage

Floats = NDArray[np.float64]

#: How far from the published thickness the ramps end, the fast one and the slow one. Nearer the strands, all at the limit, no
#: longer settle.
SHORT_OF_IDEAL = (0.03, 0.01)
#: Steps of the fast ramp, and of the slow one: the second number is for knots that do not arrive with the first. More steps find
#: more states that pass all checks.
FAST_STEPS, SLOW_STEPS = 4, (8, 20)
#: Where a knot has arrived, over the published length.
ARRIVED = 1.015
#: Cubic elements a diameter of the tight tube.
ELEMENTS_A_DIAMETER = 3
LENGTH = 300.0
#: Radius of the tube to begin with, over half the chain's smallest distance.
LOOSE = 0.95

#: Beads a diameter of the tight tube.
BEADS_A_DIAMETER = 4
#: The tight tube's in the unit of the chain, the distance of beads; 5 % above the ideal length.
DIAMETER = BEADS_A_DIAMETER / 1.05
PULLS = 100
#: Powers of the repulsion, one after the other, and steps of descent with each.
POWERS = (4, 8, 16, 32)
DESCENT = 150
#: Smallest distance of beads of two strands, over that of neighbouring beads, and largest step, over the smallest distance d.
#: Bonds are at least sqrt(d^2 - 1/2) apart, more than two of the longest steps, so no strand passes through another.
CLOSEST, LARGEST_STEP = 0.8, 0.2
#: Waves along the chain move alike up to this number, the shorter ones less: else these limit the steps.
SMOOTH = 5


def knots() -> dict[str, tuple[float, list[int]]]:
    """Length over diameter of the ideal prime knots of three to eight crossings, and a braid word, by name."""
    from database_knotinfo import link_list

    small = (knot for knot in link_list() if knot["crossing_number"] in set("345678") and knot["ropelength"])
    return {knot["name"]: (float(knot["ropelength"]) / 2, json.loads(knot["braid_notation"])) for knot in small}


def closed_braid(word: list[int]) -> Floats:
    """Points on the closed braid of a word about the z-axis; its strands are 1 apart."""
    strands = max(map(abs, word)) + 1
    inmost = max(2.5 * len(word) / (2 * np.pi) - (strands - 1) / 2, 2.0)
    part = np.linspace(0, 1, 16, endpoint=False)
    place = 0
    pieces: list[Floats] = []
    while not pieces or place != 0:
        for slot, letter in enumerate(word):
            left = abs(letter) - 1
            side = {left: 1, left + 1: -1}.get(place, 0)
            out = inmost + place + side * (1 - np.cos(np.pi * part)) / 2
            angle = 2 * np.pi * (slot + part) / len(word)
            height = side * np.sign(letter) * np.sin(np.pi * part) ** 2 / 2
            pieces.append(np.stack([out * np.cos(angle), out * np.sin(angle), height], axis=1))
            place += side
    return np.concatenate(pieces)


def even(points: Floats, beads: int) -> Floats:
    """A closed chain of beads on a polygon, 1 apart."""
    closed = np.concatenate([points, points[:1]])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.linspace(0, arc[-1], beads, endpoint=False)
    chain: Floats = np.stack([np.interp(at, arc, x) for x in closed.T], axis=1)
    chain /= np.mean(np.linalg.norm(np.roll(chain, -1, axis=0) - chain, axis=1))
    return chain


def repulsion(chain: Floats, power: int) -> tuple[float, Floats, float]:
    """log(L (Σ 1/d^q + Σ 1/(2R)^q)^(1/q)), its forces, and the smallest distance.

    d are the distances of strands, R the radii of curvature. With growing q this is the logarithm of the ropelength.
    """
    index = np.arange(len(chain))
    apart = np.abs(index[:, None] - index)
    square = np.sum(chain**2, axis=1)
    distance2 = (square[:, None] + square - 2 * chain @ chain.T) / DIAMETER**2
    # the tightest bend is half a turn in this length
    distance2[np.minimum(apart, len(chain) - apart) < 1.5 * DIAMETER] = np.inf
    inverse = 1 / distance2
    # powers of 2 by squares: many times as fast
    pairs = inverse
    for _ in range(power.bit_length() - 2):
        pairs = pairs * pairs
    bonds = np.roll(chain, -1, axis=0) - chain
    bends = (bonds - np.roll(bonds, 1, axis=0)) * DIAMETER / 2
    bend2 = np.sum(bends**2, axis=1)
    total = np.sum(pairs) + np.sum(bend2 ** (power / 2))
    pull = pairs * inverse / DIAMETER**2
    straighten = bend2[:, None] ** (power / 2 - 1) * bends * DIAMETER / 2
    forces = 2 * (np.sum(pull, axis=1)[:, None] * chain - pull @ chain)
    forces -= np.roll(straighten, 1, axis=0) + np.roll(straighten, -1, axis=0) - 2 * straighten
    tangents = bonds / np.linalg.norm(bonds, axis=1)[:, None]
    tension = (tangents - np.roll(tangents, 1, axis=0)) / len(chain)
    return float(np.log(total) / power), forces / total + tension, float(DIAMETER * np.sqrt(np.min(distance2)))


def descend(chain: Floats, power: int, load: Floats | None = None) -> tuple[Floats, float]:
    """The chain after a descent under its repulsion and a load, and its energy. The descent is smooth along the chain."""
    beads = len(chain)
    slow = 1 / (SMOOTH**2 + np.arange(beads // 2 + 1) ** 2)[:, None]
    lowest, step, way = np.inf, LARGEST_STEP / 4, np.zeros_like(chain)
    for _ in range(DESCENT):
        trial = even(chain + step * way, beads)
        energy, forces, closest = repulsion(trial, power)
        if load is not None:
            trial -= np.mean(trial, axis=0)
            energy, forces = energy - float(np.sum(load * trial)), forces + load
        if energy < lowest and closest > CLOSEST:
            chain, lowest, step = trial, energy, min(1.2 * step, LARGEST_STEP)
            way = np.fft.irfft(np.fft.rfft(forces, axis=0) * slow, beads, axis=0)
            way *= closest / np.max(np.linalg.norm(way, axis=1))
        else:
            step /= 2
    return chain, lowest


def start(word: list[int], ideal: float) -> Floats:
    """The best shape of a chain that is pulled at random again and again, each time from the best so far."""
    random = np.random.default_rng(0)
    braid = closed_braid(word)
    around = np.sum(np.linalg.norm(np.roll(braid, -1, axis=0) - braid, axis=1))
    # the second for two braids of five strands: else these are nearer to each other than the beads are
    beads = round(max(BEADS_A_DIAMETER * ideal, 1.11 * around))
    best = even(braid, beads)
    lowest = np.inf
    for _ in range(PULLS):
        # long waves only; as strong as the tension, about
        waves = np.fft.rfft(random.normal(size=best.shape), axis=0)
        waves[7:] = 0
        load = np.fft.irfft(waves, beads, axis=0)
        load /= beads * DIAMETER * np.mean(np.linalg.norm(load, axis=1))
        chain, _ = descend(best, POWERS[0], load)
        for power in POWERS:
            chain, energy = descend(chain, power)
        if energy < lowest:
            best, lowest = chain, energy
    return best


def tighten(word: list[int], ideal: float) -> Iterator[Result]:
    """The knot of a braid word, from the chain's shape to a tube as thick as it can be: a run with few steps, then with more."""
    chain = start(word, ideal)
    _, _, closest = repulsion(chain, 2)
    scale = LENGTH / len(chain)
    section = {
        "bending": 100.0,
        "twisting": 100.0,
        "stretching": 1e4,
        "shearing": 1e4,
        "contact_radius": LOOSE * scale * closest / 2,
    }
    rod = Rod(name="rope", closed=True, points=chain * scale, section=section, elements=round(ELEMENTS_A_DIAMETER * ideal))
    # a little more than that of the chain, which cuts corners
    length = Scene(rod).rods[0]["length"]
    for slow_steps in SLOW_STEPS:
        stages = [
            Stage(section={"contact_radius": length / (2 * ideal * (1 + short))}, steps=steps)
            for short, steps in zip(SHORT_OF_IDEAL, (FAST_STEPS, slow_steps), strict=True)
        ]
        yield Scene(rod, stages=stages, title="tight knot").run()


def rows(names: list[str]) -> Iterator[tuple[str, float, float, str]]:
    """Name, smallest ropelength of a converged state, that published, and how the last run ended."""
    ideal = knots()
    for name in names or ideal:
        length, word = ideal[name]
        found, status = np.inf, ""
        for result in tighten(word, length):
            table, status = result.table, result.status
            assert set(table["knot"]) == {name}, "a strand has passed through another"
            found = min(found, *table["ropelength"][table["status"] == "converged"].tolist())
            if found <= ARRIVED * length:
                break
        yield name, found, length, status


if __name__ == "__main__":
    print("knot    found   published  above   status")
    for name, found, ideal, status in rows(sys.argv[1:]):
        print(f"{name:5} {found:8.3f} {ideal:9.3f}  {100 * (found / ideal - 1):+6.2f} %  {status}", flush=True)
