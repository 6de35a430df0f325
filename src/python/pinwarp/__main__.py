"""`python -m pinwarp`: the command line."""

from ._cli import main

main()
