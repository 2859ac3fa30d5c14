"""Prime knots pulled tight: length over diameter beside the published values (KnotInfo).

A closed braid of thin rod thickens until its tube is 1 % short of the ideal knot's. Whether it arrives there is the question: a
knot that jams in another shape does not. What counts is the tightest state that is at rest and passes all checks. The published
lengths are over the radius; half of that is the ropelength here.

    pip install database-knotinfo
    python ideal_knots.py [NAME ...]        # by default all of three to eight crossings: some hours
"""

import sys
from collections.abc import Iterator

import numpy as np

from supercoil import Result, Rod, Scene, Stage

#: How far from the published thickness the ramps end, the fast one and the slow one. Nearer the strands, all at the limit, no longer
#: settle.
SHORT_OF_IDEAL = (0.03, 0.01)
STEPS = (28, 20)
#: Cubic elements a diameter of the tight tube.
ELEMENTS_A_DIAMETER = 3
LENGTH = 300.0


def published() -> dict[str, float]:
    """Length over diameter of the ideal prime knots of three to eight crossings, by name."""
    from database_knotinfo import link_list

    small = (knot for knot in link_list() if knot["crossing_number"] in set("345678") and knot["ropelength"])
    return {knot["name"]: float(knot["ropelength"]) / 2 for knot in small}


def tighten(name: str, ideal: float) -> Result:
    """The knot, from a thin rod to a thick one."""
    radii = [LENGTH / (2 * ideal * (1 + short)) for short in SHORT_OF_IDEAL]
    section = {"bending": 100.0, "twisting": 100.0, "stretching": 1e4, "shearing": 1e4, "contact_radius": radii[0] / 12}
    rod = Rod(
        name="rope",
        closed=True,
        shape={"kind": "knot", "name": name, "length": LENGTH},
        section=section,
        elements=round(ELEMENTS_A_DIAMETER * ideal),
    )
    stages = [Stage(section={"contact_radius": r}, steps=steps) for r, steps in zip(radii, STEPS, strict=True)]
    return Scene(rod, stages=stages, title=f"{name}, tight").run()


def rows(names: list[str]) -> Iterator[tuple[str, float, float, str]]:
    """Name, smallest ropelength of a converged state, that published, and how the run ended."""
    ideal = published()
    for name in names or ideal:
        result = tighten(name, ideal[name])
        table = result.table
        assert set(table["knot"]) == {name}, "a strand has passed through another"
        yield name, float(np.min(table["ropelength"][table["status"] == "converged"])), ideal[name], result.status


if __name__ == "__main__":
    print("knot    found   published  above   status")
    for name, found, ideal, status in rows(sys.argv[1:]):
        print(f"{name:5} {found:8.3f} {ideal:9.3f}  {100 * (found / ideal - 1):+6.2f} %  {status}", flush=True)
