"""What people type, opened."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Union

from . import _native
from ._labels import media_of, text_of
from ._material import Material
from ._native import Structure
from ._progress import ProgressLike, watched
from .errors import idle

#: The name of something, or a file.
Name = Union[str, "PathLike[str]"]


def open(
    name: Name,
    *,
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> Structure | Material:
    """Opens what the command line opens.

    Args:
        name: A species with or without a variant (``starling:pink``), a stack (``air/keratin:595/air``), a section, species, stack or
            lattice file, a folder of sections, or a material file. With `` (below)`` behind it, a species' lower side.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        A structure, or of a material file a material.

    Raises:
        InputError: Nothing is called so; the nearest names are offered.

    Example:
        >>> import barbule
        >>> barbule.open("starling:pink").width_um
        25.0
    """
    text = text_of("name", name)
    with watched(progress) as watch:
        found = _native.open(text, media_of(media), threads, watch)
    return Material(found) if isinstance(found, _native.Material) else found


def structure_of(given: Structure | Name, media: Mapping[str, Name] | None = None) -> Structure:
    """A structure, opened if it is a name."""
    if isinstance(given, Structure):
        if media:
            idle("media", "the structure is open already; barbule.open takes them")
        return given
    found = open(text_of("structure", given), media=media, progress=False)
    if isinstance(found, Structure):
        return found
    raise TypeError(f"{given} is a material, where a structure is needed")
