"""Materials, scenes and films in files of other programs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Literal, TypedDict, Union

from . import _native
from ._labels import media_of, text_of
from ._material import Material
from ._opening import Name
from ._progress import ProgressLike, watched
from ._scene import Scene
from .errors import doubt, idle

Format = Literal["mitsuba", "bsdf", "bsdf-rgb", "pbrt", "osl", "usd", "gltf", "openpbr", "csv", "exr"]


class Written(TypedDict):
    """What `export` wrote, and how far it is from what was exported.

    Example:
        >>> import barbule, tempfile, warnings
        >>> warnings.simplefilter("ignore", barbule.DoubtWarning)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     film: barbule.Written = barbule.export("air/keratin:595/air", "gltf", folder + "/film.gltf")
        >>> len(film["files"]) > 0 and film["bytes"] > 0
        True
    """

    #: The files, the one asked for first, and folders of further ones.
    files: list[str]
    #: Bytes of all of them.
    bytes: int
    #: ∫|f' − f| cosθ over ∫f cosθ, over views up to 70° from the normal, lights and 403 to 695 nm (or R, G, B); None of exact scenes.
    relative_l1: float | None
    #: The same without the modulus.
    bias: float | None
    #: Mean ΔE00 of all light that is reflected towards twelve views, in D65.
    delta_e: float | None
    #: What is lost or shown differently, a sentence each.
    remarks: list[str]
    #: Numbers of the format's own.
    details: dict[str, object] | None


def export(
    what: Material | Scene | Name,
    to: Format,
    path: Union[str, "PathLike[str]"],
    *,
    size_mb: float = 40.0,
    picture: tuple[int, int] | None = None,
    samples: int = 64,
    without: Sequence[str] = (),
    seed: int = 1,
    media: Mapping[str, Name] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> Written:
    """Writes a material, a scene or a film for another program, as ``barbule export`` does.

    Args:
        what: A material (``bsdf``, ``bsdf-rgb``, ``osl``, ``csv``, ``exr``), a scene (``mitsuba``, ``pbrt``, ``usd``), or a stack
            (``gltf``, ``openpbr``): something that is open, or a name as on the command line.
        to: What for.
        path: The file; shapes and tables that belong to it lie beside it.
        size_mb: Most MB of a ``.bsdf``.
        picture: Of scenes width and height, pixels; the scene's own, or 1280 × 800, without.
        samples: Of scenes samples per pixel.
        without: Of scenes names of parts that are left out, as mattes call them: ``down``, ``shaft``.
        seed: Seed of feathers and their barbules.
        media: Media of your own by name, each a file of n and k.
        cache: Folder of computed materials; that of the command line without one.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Raises:
        InputError: What the format has nothing for, a file that cannot be written.

    Example:
        >>> import barbule, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     film = barbule.export("air/keratin:595/air", "gltf", folder + "/film.gltf")
        >>> film["delta_e"] > 0.0
        True
    """
    given = what._native if isinstance(what, (Material, Scene)) else text_of("what", what)
    if isinstance(what, Material):
        of_scenes = (("picture", picture), ("without", list(without) or None), ("media", media))
        for name, said in of_scenes:
            if said is not None:
                idle(name, "a Material is exported as it is")
    kept = None if cache is None else Path(cache)
    with watched(progress) as watch:
        text = _native.export(
            given, to, Path(path), size_mb, picture, samples, list(without), seed, media_of(media), kept, threads, watch
        )
    written: Written = json.loads(text)
    for remark in written["remarks"]:
        doubt(remark)
    return written
