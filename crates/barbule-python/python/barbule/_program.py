"""The command `barbule` of the wheel."""

from __future__ import annotations

import sys

from . import _native


def main() -> None:
    """Runs the command line on this process's arguments and ends it with the program's exit code."""
    sys.exit(_native.run(["barbule", *sys.argv[1:]]))
