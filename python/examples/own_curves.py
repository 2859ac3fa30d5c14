"""Where do curves of one's own touch? No rods, any unit of length."""

import numpy as np

from supercoil import contact

t = np.linspace(0, 2 * np.pi, 100, endpoint=False)
ring = contact.Curve(points=np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), radius=0.1, closed=True)
rod = contact.Curve(points=[[1.3, 0.0, -1.0], [1.3, 0.0, 1.0]], radius=0.05)
sites = contact.detect([ring, rod], range=0.5)
print(f"{len(sites['gap'])} site: gap {sites['gap'][0]:.3f} at arc {sites['arc_a'][0]:.2f} and {sites['arc_b'][0]:.2f}")
