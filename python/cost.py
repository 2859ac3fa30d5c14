"""What does the binding cost? A run from Python against one from the command line, in pairs.

    python cost.py path/to/supercoil [pairs]

CPU seconds on one thread, outputs of the command line turned off, each pair in the other order than the one before. The
run from Python is counted from the scene's text to its result; the interpreter's start is not part of it. That of the
command line has its start and its tables in it, some hundredths of a second.
"""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from supercoil import Scene

SCENE = Path(__file__).parents[1] / "examples" / "minicircle.toml"
QUIET = ["--set", "output.vtk=false", "--set", "output.picture=false", "--quiet", "--force", "--threads", "1"]


def of_program(program: str) -> float:
    """CPU seconds of the command line."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([program, "run", SCENE, "--out", folder, *QUIET], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def of_binding() -> float:
    """CPU seconds of a run from Python."""
    before = time.process_time()
    result = Scene.from_toml(SCENE).run(threads=1)
    assert result.converged
    return time.process_time() - before


def main() -> None:
    program = sys.argv[1] if len(sys.argv) > 1 else os.environ["SUPERCOIL_PROGRAM"]
    pairs = int(sys.argv[2]) if len(sys.argv) > 2 else 7
    ratios = []
    for pair in range(pairs):
        if pair % 2 == 0:
            a, b = of_program(program), of_binding()
        else:
            b = of_binding()
            a = of_program(program)
        ratios.append(b / a)
        print(f"command line {a:.3f} s, Python {b:.3f} s: {100 * (b / a - 1):+.1f} %")
    middle = statistics.median(ratios)
    print(f"median of {pairs} pairs: {100 * (middle - 1):+.1f} % (+2 % is the most that is meant)")


if __name__ == "__main__":
    main()
