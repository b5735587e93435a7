"""What goes wrong, with the place in the user's file as attributes."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

__all__ = ["BarbuleError", "DoubtWarning", "InputError", "MachineError", "NotSettledError"]


class BarbuleError(Exception):
    """The base of all errors of Barbule.

    The message is one sentence: what was found, where, what is allowed and what to do.

    Attributes:
        file: The file that it is about, or None.
        line: The line in it, from 1, or None.
        column: The column in it, from 1, or None.
        key: The key in it, as in ``lights[2].strength``, or None.

    Example:
        >>> import barbule
        >>> try:
        ...     barbule.Scene.parse("[camera]\\nwidth = 2\\n")
        ... except barbule.BarbuleError as error:
        ...     print(error.line, error.key)
        2 camera.width
    """

    file: str | None
    line: int | None
    column: int | None
    key: str | None

    def __init__(
        self,
        message: str = "",
        *,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        key: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.column = column
        self.key = key


class InputError(BarbuleError, ValueError):
    """Something that the caller can mend: an argument, a file's contents, a missing or unwritable file.

    Example:
        >>> import barbule
        >>> try:
        ...     barbule.open("starlng")
        ... except barbule.InputError as error:
        ...     print("did you mean 'starling'?" in str(error))
        True
    """


class MachineError(BarbuleError, RuntimeError):
    """The machine's fault: a full disk, a failed read in the middle of a file, no memory.

    Example:
        >>> import barbule
        >>> try:
        ...     picture = barbule.render("starling", size=(24, 16), samples=1)
        ... except barbule.MachineError as error:
        ...     print("try another machine:", error)
    """


class NotSettledError(BarbuleError, ArithmeticError):
    """A computation that did not reach its accuracy.

    Example:
        >>> import barbule
        >>> try:
        ...     found = barbule.crystal("mallard", [500.0])
        ... except barbule.NotSettledError as error:
        ...     print("another solver may do:", error)
        >>> found["reflectance"].shape
        (1, 1)
    """


class DoubtWarning(UserWarning):
    """What was given is done as it says, but probably meant otherwise.

    Example:
        >>> import barbule, warnings
        >>> with warnings.catch_warnings(record=True) as said:
        ...     warnings.simplefilter("always", barbule.DoubtWarning)
        ...     film = barbule.open("air/keratin:0.3/air")
        >>> "did you mean 300?" in str(said[0].message)
        True
    """


_PACKAGE = str(Path(__file__).parent)


def doubt(message: str) -> None:
    """Warns of what was given, on the line outside of this package that gave it."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, DoubtWarning, stacklevel=level)


def idle(name: str, why: str) -> None:
    """Warns that an argument that was given changes nothing."""
    doubt(f"'{name}' has no effect here: {why}")
