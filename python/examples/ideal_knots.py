"""Prime knots pulled tight: length over diameter beside the published values (KnotInfo).

A closed braid of thin rod thickens until its tube is 1 % short of the ideal knot's. Whether it arrives there is the question: a
knot that jams in another shape does not. The published lengths are over the radius; half of that is the ropelength here.

    pip install database-knotinfo
    python ideal_knots.py [NAME ...]        # by default all of three to eight crossings: half an hour
"""

import sys
from collections.abc import Iterator

from supercoil import Result, Rod, Scene, Stage

#: How far from the published thickness the ramp ends. Nearer the strands, all at the limit, no longer settle.
SHORT_OF_IDEAL = 0.01
#: Cubic elements a diameter of the tight tube.
ELEMENTS_A_DIAMETER = 3
LENGTH = 300.0


def published() -> dict[str, float]:
    """Length over diameter of the ideal prime knots of three to eight crossings, by name."""
    from database_knotinfo import link_list

    small = (knot for knot in link_list() if knot["crossing_number"] in "345678" and knot["ropelength"])
    return {knot["name"]: float(knot["ropelength"]) / 2 for knot in small}


def tighten(name: str, ideal: float) -> Result:
    """The knot, from a thin rod to a thick one."""
    radius = LENGTH / (2 * ideal * (1 + SHORT_OF_IDEAL))
    section = {"bending": 100.0, "twisting": 100.0, "stretching": 1e4, "shearing": 1e4, "contact_radius": radius / 12}
    rod = Rod(
        name="rope",
        closed=True,
        shape={"kind": "knot", "name": name, "length": LENGTH},
        section=section,
        elements=round(ELEMENTS_A_DIAMETER * ideal),
    )
    return Scene(rod, stages=Stage(section={"contact_radius": radius}, steps=30), title=f"{name}, tight").run()


def rows(names: list[str]) -> Iterator[tuple[str, float, float, str]]:
    """Name, ropelength found, that published, and the status of the run."""
    ideal = published()
    for name in names or ideal:
        result = tighten(name, ideal[name])
        found = result.table["ropelength"]
        assert set(result.table["knot"]) == {name}, "a strand has passed through another"
        yield name, float(found[-1]), ideal[name], result.status


if __name__ == "__main__":
    print("knot    found   published  above   status")
    for name, found, ideal, status in rows(sys.argv[1:]):
        print(f"{name:5} {found:8.3f} {ideal:9.3f}  {100 * (found / ideal - 1):+6.2f} %  {status}", flush=True)
