"""One round of ipctk's LBVH on a polyline: build, list of edge pairs whose boxes, inflated by the radius, overlap. CPU time, one thread.

    pip install ipctk==1.6.1 numpy
    python ipctk_round.py points.f64 repeat        # x y z of each point as f64, little endian
"""

import sys
import time

import ipctk
import numpy as np

RADIUS = 1.0


def median_seconds(repeat, run):
    times = []
    for _ in range(repeat):
        before = time.process_time()
        result = run()
        times.append(time.process_time() - before)
    return sorted(times)[repeat // 2], result


def main():
    points = np.asfortranarray(np.fromfile(sys.argv[1]).reshape(-1, 3))
    repeat = int(sys.argv[2])
    n = len(points) - 1
    edges = np.asfortranarray(np.stack([np.arange(n), np.arange(1, n + 1)], axis=1).astype(np.int32))
    faces = np.zeros((0, 3), dtype=np.int32, order="F")
    ipctk.set_num_threads(1)
    tree = ipctk.LBVH()
    build, _ = median_seconds(repeat, lambda: tree.build(points, edges, faces, RADIUS))
    # The result stays in C++: no list of Python objects is made.
    listing, candidates = median_seconds(repeat, tree.detect_collision_candidates)
    print(f"ipctk build {build:.6f}\nipctk list {listing:.6f}\nipctk pairs {len(candidates)}")


main()
