"""Whole scenes as Mitsuba's dictionaries."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Union

from .._labels import media_of
from .._opening import Name
from .._progress import ProgressLike, watched
from .._scene import Scene
from ..errors import doubt
from ._base import mi

#: Folders of scenes for which nobody named one: they go when the process ends.
_folders: list[tempfile.TemporaryDirectory[str]] = []


def scene(
    name: Scene | Name,
    folder: Union[str, "PathLike[str]", None] = None,
    *,
    size: tuple[int, int] | None = None,
    samples: int = 64,
    seed: int = 1,
    without: Sequence[str] = (),
    media: Mapping[str, Name] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    progress: ProgressLike = True,
) -> dict[str, Any]:
    """A scene as a dictionary for ``mitsuba.load_dict``: shapes, surfaces, lights, sky and camera.

    Linear values of its pictures are those of ``Picture.planes()["linear_srgb"]``: 1 is a white diffuse surface in a sky of daylight of
    radiance 1. Lengths are mm. What stands behind the scene is not in it: where the scene has a colour or a picture there, the picture has
    an alpha channel.

    Args:
        name: A `barbule.Scene`, or what ``barbule render`` takes: a preset, a scene file, a material or a structure.
        folder: Where its files are written: PLY meshes and tables of BRDFs; one that lasts as long as the process without.
        size: Width and height, pixels; the scene's own, or 1280 × 800, without.
        samples: Samples per pixel.
        seed: Seed of feather and instances: the same as of ``Scene.render`` for the same barbules with the same glints.
        without: Names of parts that are left out, as the program's mattes call them: ``["down"]``.
        media: Media of your own by name, each a file of n and k.
        cache: Folder of computed materials; that of the command line without one.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Raises:
        InputError: A surface or lamp that Mitsuba has nothing for, or over 350,000 barbules.
        ValueError: The variant is not spectral.
    """
    if not mi.is_spectral:
        raise ValueError(f"scene: '{mi.variant()}' is not spectral; choose a variant such as llvm_ad_spectral")
    opened = name if isinstance(name, Scene) else Scene.load(name, media=media, progress=progress)
    if folder is None:
        _folders.append(tempfile.TemporaryDirectory(prefix="barbule-"))
        folder = _folders[-1].name
    place = Path(folder).absolute()
    wide, high = opened.pixels(size)
    kept = None if cache is None else Path(cache)
    with watched(progress) as watch:
        text = opened._native.mitsuba(place, [wide, high], samples, seed, list(without), media_of(media), kept, watch)
    found = json.loads(text)
    for remark in found["remarks"]:
        doubt(remark)
    return {key: _plugin(value, place) for key, value in found["scene"].items()}


def _plugin(value: Any, folder: Path) -> Any:
    """A value of the tree as Mitsuba takes it."""
    if isinstance(value, list):
        return mi.ScalarPoint3f(value)
    if not isinstance(value, dict):
        return value
    if "file" in value:
        return str(folder / value["file"])
    if "matrix" in value:
        return mi.ScalarTransform4f(value["matrix"])
    return {key: _plugin(part, folder) for key, part in value.items()}
