"""`python -m barbule`: the command line."""

from ._program import main

main()
