"""What a cluster computes: work that is described on the client, prepared once on each worker and done item by item."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from .. import _native
from .._labels import media_of, text_of
from .._native import Structure
from .._opening import Name, structure_of
from ..errors import InputError

#: The program's version.
VERSION = _native.version()

#: What native calls tell of their progress, from the thread that called them; an exception stops them.
Watch = Callable[[str, int, int], Any]


class Prepared(Protocol):
    """Work on a worker, for several threads at once."""

    def run(self, item: int, threads: int, watch: Watch) -> None:
        """Computes an item and puts it where results go, unless it is there; the same bits whoever does it, and how often."""

    def close(self) -> None:
        """Gives back what the work has taken."""


class Work(Protocol):
    """Work as it is sent to workers: small, and the same everywhere."""

    @property
    def label(self) -> str:
        """What is done, in a word, for progress."""

    @property
    def identity(self) -> str:
        """A hash of all that decides the results."""

    def prepare(self, folder: Path, slots: int) -> Prepared:
        """Opens what the items need; `folder` is the worker's own and goes with it, and `slots` are its threads."""


def identity_of(**parts: Any) -> str:
    """The head of a hash of a description and of the program's version."""
    text = json.dumps({"version": VERSION, **parts}, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def placed(name: Name) -> str:
    """A name as it opens in any folder: a file that is there by its whole path, everything else as it stands."""
    text = text_of("name", name)
    below = " (below)" if text.endswith(" (below)") else ""
    path = Path(text.removesuffix(below))
    # Species and stacks are no paths, whatever lies in the folder where somebody works.
    is_path = isinstance(name, os.PathLike) or path.suffix or len(path.parts) > 1
    return f"{path.absolute()}{below}" if is_path and path.exists() else text


def placed_media(media: Mapping[str, Name] | None) -> tuple[tuple[str, str], ...]:
    """Media of the caller's own, with whole paths."""
    return tuple(media_of({name: placed(file) for name, file in (media or {}).items()}))


def opened_alike(name: str, media: Sequence[tuple[str, str]], expected: str) -> Structure:
    """A structure as a worker opens it, which must be the client's.

    Raises:
        InputError: The file that the name stands for is missing here, or says something else.
    """
    structure = structure_of(name, dict(media))
    if structure.hash != expected:
        raise InputError(
            f"{name} is another structure on this worker than where the work began; "
            "put its file on a file system that all of them see, or install the same version of barbule"
        )
    return structure
