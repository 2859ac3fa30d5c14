"""``python -m supercoil``: the command line."""

from ._cli import main

main()
