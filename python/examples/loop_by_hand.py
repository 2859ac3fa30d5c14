"""What force closes a rod to a loop, its end carried towards its start step by step? EI = 1, length 1."""

import math

from supercoil import Rod, Scene, Support

section = {"bending": 1.0, "twisting": 1.5, "stretching": 1e5, "shearing": 1e5, "contact_radius": 0.0}
arc = {"kind": "arc", "radius": 1.0, "turns": 1.0 / math.tau}
arc |= {"start": [0, 0, 0], "tangent": [1, 0, 0], "towards": [0, 1, 0]}
rod = Rod(shape=arc, section=section, elements=12)
ends = [Support(at="start", position=True, rotation=["x", "y"]), Support(at="end", position=True)]
solver = Scene(rod, supports=ends).solver()
solver.settle()
for shift in (-0.1, -0.2, -0.3, -0.4):
    report = solver.step_to(displacement={"at": "end", "to": [shift, 0, 0]})
    force = solver.state.reactions[1]["force"]
    print(f"end carried by {shift:.1f}: {report.status}, end force ({force[0]:.3f}, {force[1]:.3f}, {force[2]:.3f}) EI/L²")
