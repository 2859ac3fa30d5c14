"""Adapter for cosseratbench, which compares programs for rods: the solver ``supercoil`` of its command line.

It is loaded by the entry point ``cosseratbench.solvers``; nothing else needs cosseratbench. Supercoil computes equilibria without friction:
a trajectory has the start shape in its first frame and the equilibrium in all others. What needs friction, dynamics or an end
driven in time is unsupported by name.
"""

from __future__ import annotations

import numpy as np
from cosseratbench import Capability, Scenario, Trajectory
from cosseratbench.scenario import Cylinder, End, EndCondition, Plane, Rod as BenchRod
from cosseratbench.solver import Diverged

import supercoil
from supercoil.scene import LineLoad, Load, Obstacle, Rod, Scene, Support
from supercoil.scene import Plane as Table
from supercoil.state import Floats, State

#: Nodes from one end of an element to the other; elements of this order.
_ORDER = 3
#: Stretch of a rod at its start, over its length, below which it starts unstretched: rounding of the length of a polyline.
_UNSTRETCHED = 1e-9
#: Points of a segment between two nodes that are compared with the ends of cylinders.
_PARTS = 8
#: Gap over a rod's radius up to which it counts as touching: points between nodes are on chords.
_NEAR = 0.01


def _objection(scenario: Scenario) -> str | None:
    """What of a scenario is outside the model."""
    if not scenario.quasi_static:
        return "dynamics: supercoil computes equilibria"
    touches = [*scenario.rods, *scenario.obstacles]
    if any(body.friction > 0.0 for body in touches):
        return "friction: contact is without"
    if any(rod.motion(end) is not None for rod in scenario.rods for end in End):
        return "an end driven in time: supercoil computes equilibria"
    return None


def _supports(rod: BenchRod, name: str) -> list[Support]:
    at = {End.START: "start", End.END: "end"}
    held = [(end, rod.condition(end)) for end in End if rod.condition(end) is not EndCondition.FREE]
    clamped = EndCondition.CLAMPED
    return [Support(rod=name, at=at[end], position=True, rotation=condition is clamped) for end, condition in held]


def _rod(rod: BenchRod, name: str, n_elements: int) -> Rod:
    material = rod.material
    section = {"young": material.youngs_modulus, "shear_modulus": material.shear_modulus, "circle": rod.radius}
    return Rod(
        points=np.asarray(rod.centerline, dtype=float),
        section=section,
        elements=-(-n_elements // _ORDER),
        order=_ORDER,
        name=name,
    )


def _obstacle(index: int, body: Cylinder) -> Obstacle:
    axis = [float(x) for x in body.axis]
    center = [float(x) for x in body.center]
    return Obstacle(name=f"obstacle{index}", shape="cylinder", point=center, axis=axis, radius=body.radius)


def _scene(scenario: Scenario, names: list[str], n_elements: int) -> Scene:
    bodies = list(enumerate(scenario.obstacles))
    planes = [
        Table(name=f"obstacle{k}", point=list(body.point), normal=[float(x) for x in body.unit_normal])
        for k, body in bodies
        if isinstance(body, Plane)
    ]
    rods = list(zip(scenario.rods, names))
    ends = {End.START: "start", End.END: "end"}
    gravity = np.asarray(scenario.gravity, dtype=float)
    weights = [
        LineLoad(rod=name, force=[float(x) for x in gravity * rod.material.density * rod.area])
        for rod, name in rods
        if gravity.any()
    ]
    return Scene(
        [_rod(rod, name, n_elements) for rod, name in rods],
        supports=[support for rod, name in rods for support in _supports(rod, name)],
        loads=[Load(rod=name, at=ends[load.at], force=list(load.force)) for rod, name in rods for load in rod.loads],
        line_loads=weights,
        planes=planes,
        obstacles=[_obstacle(k, body) for k, body in bodies if isinstance(body, Cylinder)],
    )


def _nodes_at(values: Floats, at: Floats) -> Floats:
    """Values at parts 0 … 1 of a rod, interpolated as its elements do from those at their evenly spaced nodes."""
    elements = (len(values) - 1) // _ORDER
    element = np.minimum((at * elements).astype(int), elements - 1)
    u = (at * elements - element) * _ORDER
    out = np.zeros((len(at), values.shape[1]))
    for m in range(_ORDER + 1):
        others = [j for j in range(_ORDER + 1) if j != m]
        weight = np.prod([(u - j) / (m - j) for j in others], axis=0)
        out += weight[:, None] * values[_ORDER * element + m]
    return out


def _shape(state: State, rod: int, n_elements: int) -> tuple[Floats, Floats]:
    """Evenly spaced nodes of a rod, and d1 between neighbours, perpendicular to the line that joins them."""
    first, last = state.node_ranges[rod]
    positions, frames = state.positions[first:last], state.frames[first:last]
    nodes = _nodes_at(positions, np.linspace(0.0, 1.0, n_elements + 1))
    middles = (np.arange(n_elements) + 0.5) / n_elements
    return nodes, _across(_nodes_at(frames[:, 0, :], middles), np.diff(nodes, axis=0))


def _across(vectors: Floats, along: Floats) -> Floats:
    """Unit vectors perpendicular to others."""
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    vectors = vectors - (vectors * along).sum(axis=1, keepdims=True) * along
    across: Floats = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return across


def _turned(directors: Floats, nodes: Floats, angle: float) -> Floats:
    """Directors turned about the rod."""
    along = np.diff(nodes, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    turned: Floats = directors * np.cos(angle) + np.cross(along, directors) * np.sin(angle)
    return turned


def _angle_to(at_first: Floats, wanted: Floats, nodes: Floats) -> float:
    """Angle about the first element from one director to another."""
    along = (nodes[1] - nodes[0]) / np.linalg.norm(nodes[1] - nodes[0])
    return float(np.arctan2(np.cross(at_first, wanted) @ along, at_first @ wanted))


class Supercoil:
    """Equilibria of scenarios that are quasi-static and without friction."""

    name = "supercoil"
    capabilities = frozenset({
        Capability.STRETCH,
        Capability.SHEAR,
        Capability.ROD_CONTACT,
        Capability.CYLINDER_CONTACT,
        Capability.PLANE_CONTACT,
    })
    backend_version = supercoil.__version__

    def settings(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> dict[str, object]:
        """Numerical choices, as JSON values."""
        return {"elements": -(-n_elements // _ORDER), "order": _ORDER, "contact": "exact", "dissipation": None}

    def run(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> Trajectory:
        """The equilibrium that the start shape falls to.

        Raises ``NotImplementedError`` with what is outside the model, ``Diverged`` if no equilibrium was found.
        """
        if (objection := _objection(scenario)) is not None:
            raise NotImplementedError(objection)
        names = [f"rod{k}" for k in range(len(scenario.rods))]
        solver = _scene(scenario, names, n_elements).solver()
        first = [_shape(solver.state, k, n_elements) for k in range(len(names))]
        reports = [solver.settle()]
        stretched = [
            {"rod": name, "to": rod.length}
            for rod, name, size in zip(scenario.rods, names, solver.state.observation["sizes"])
            if abs(size["length"] / rod.length - 1.0) > _UNSTRETCHED
        ]
        if stretched:
            reports.append(solver.step_to(length=stretched))
        for report in reports:
            if report.status != "converged":
                raise Diverged(f"{report.status}: {report.error}")
        positions, directors = [], []
        for k, rod in enumerate(scenario.rods):
            start, d1 = rod.nodes(n_elements), rod.directors(n_elements)
            nodes, last = _shape(solver.state, k, n_elements)
            angle = _angle_to(first[k][1][0], d1[0], start)
            positions.append(np.stack([start, *[nodes] * (n_frames - 1)]))
            directors.append(np.stack([d1, *[_turned(last, nodes, angle)] * (n_frames - 1)]))
        _check_ends(scenario, positions)
        times = np.linspace(0.0, scenario.duration, n_frames)
        return Trajectory(times, tuple(positions), tuple(directors))


def _check_ends(scenario: Scenario, positions: list[Floats]) -> None:
    """Cylinders are endless here: none may be touched beyond its ends."""
    for rod, nodes in zip(scenario.rods, positions):
        for body in scenario.obstacles:
            if isinstance(body, Cylinder):
                parts = np.linspace(0.0, 1.0, _PARTS, endpoint=False)[:, None, None]
                points = ((1.0 - parts) * nodes[-1, :-1] + parts * nodes[-1, 1:]).reshape(-1, 3)
                offset = points - np.asarray(body.center)
                along = offset @ body.unit_axis
                across = np.linalg.norm(offset - along[:, None] * body.unit_axis, axis=1)
                touches = across < body.radius + (1.0 + _NEAR) * rod.radius
                if np.any(touches & (np.abs(along) > 0.5 * body.length)):
                    raise NotImplementedError("the end of a cylinder: cylinders are endless")
