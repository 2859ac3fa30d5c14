"""The console script ``supercoil``: the command line, as ``cargo install`` has it."""

import sys

from . import _supercoil


def main() -> None:
    """Runs the command line with the arguments of the process and exits with its code."""
    sys.exit(_supercoil.program(["supercoil", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
