"""How accurate the fast simulation is: the same structures by it and by full waves, or by segments in three dimensions."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

from . import _native
from ._labels import media_of, one_of, plain, text_of
from ._native import Structure
from ._opening import Name, structure_of
from ._progress import ProgressLike, watched
from .errors import InputError

if TYPE_CHECKING:
    from typing_extensions import Unpack

#: What the fast simulation is compared with.
Against = Literal["full-wave", "three-d"]


class ValidateOptions(TypedDict, total=False):
    """What is compared; what is left out is usual.

    Example:
        >>> import barbule
        >>> options: barbule.ValidateOptions = {"wavelengths_nm": [600], "phi_deg": [0], "instances": 10}
        >>> try:
        ...     barbule.validate("starling", "folder", "full-wave", **options)
        ... except barbule.InputError as error:
        ...     print(error)
        'instances' is for segments; leave it out against 'full-wave'
    """

    #: Vacuum wavelengths, rising; 400 to 694 nm in steps of 12 (of segments 42, with `quick` fewer) without.
    wavelengths_nm: Sequence[float]
    #: Width of a species' barbule; its own without.
    width_um: float
    #: Layers or rows of a species that counts them.
    layers: int
    #: Less of all: a barbule 6 µm wide from 0° and 30° against full waves, ten segments at three wavelengths.
    quick: bool
    #: Seed of individuals; 1 without.
    seed: int
    #: Full waves: azimuths of the light; 0, 30 and 60 without.
    phi_deg: Sequence[float]
    #: Full waves: nodes per wavelength in the denser medium at each boundary; 10 without.
    elements_per_wavelength: float
    #: Full waves: how layers end at the sides, ``open`` or ``closed``.
    ends: Literal["open", "closed"]
    #: Full waves: whether the top stands in its own light in the fast simulation's formulas.
    shadowing: bool
    #: Full waves: over what the fast simulation averages inclusions along the top; 0 is not at all.
    smooth_um: float
    #: Full waves: the first individual, from 0.
    instance: int
    #: Full waves: how many individuals; 1 without.
    individuals: int
    #: Segments: how many are averaged; 50 without.
    instances: int
    #: Segments: how long they are; the barbule's width without.
    length_um: float
    #: Segments: standard deviation of each boundary's height; 0.01 without, and 0 is invariant along the barbule.
    roughness_um: float
    #: Segments: correlation lengths of these heights, across and along; 0.5 without.
    correlation_um: tuple[float, float]
    #: Segments: the material that they are compared with; the structure's own, where it is at hand, without.
    material: Name


_FULL_WAVES = {"phi_deg", "elements_per_wavelength", "ends", "shadowing", "smooth_um", "instance", "individuals"}
_SEGMENTS = {"instances", "length_um", "roughness_um", "correlation_um", "material"}


def validate(
    structure: Structure | Name,
    output: Union[str, "PathLike[str]"],
    against: Against = "full-wave",
    *,
    simd: str | None = None,
    media: Mapping[str, Name] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    memory_bytes: int | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
    **options: Unpack[ValidateOptions],
) -> dict[str, Any]:
    """Compares the fast simulation with full waves of the same sections, or with segments in three dimensions.

    Ctrl-C, or a `progress` that raises, stops it; the same call goes on, to the same bits: what is done is kept in the folder's ``units``.

    Args:
        structure: A structure, or whatever `barbule.open` opens.
        output: Folder for figures, ``numbers.json`` and tables, as ``barbule validate`` writes them.
        against: ``full-wave``, or ``three-d`` for segments.
        simd: SIMD instructions of segments by name; the widest of this processor without.
        media: Media of your own by name, each a file of n and k.
        cache: Folder of computed materials; that of the command line without one.
        memory_bytes: What may be taken at most; what the machine has left without.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.
        options: What is compared, see `ValidateOptions`.

    Returns:
        What ``numbers.json`` holds: powers are parts of the incident power, angles degrees.

    Raises:
        InputError: A number out of range, a section without a top, more memory than there is.

    Example:
        >>> import barbule, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     found = barbule.validate("air/keratin:300/air", folder, wavelengths_nm=[600], phi_deg=[0], elements_per_wavelength=5)
        >>> abs(found["incidences"][0]["mean_power_error"]) < 0.1
        True
    """
    opened = structure_of(structure, media)
    kept = None if cache is None else Path(cache)
    planned = _comparison(opened, output, against, options, True, media, simd, kept, memory_bytes)
    planned.check_memory(threads, memory_bytes)
    with watched(progress) as watch:
        found: dict[str, Any] = json.loads(planned.finish(threads, watch))
    return found


def checked_options(against: str, options: Mapping[str, Any]) -> str:
    """Options as JSON, without the material.

    Raises:
        InputError: One belongs to the other comparison, or there is no such comparison.
        TypeError: One is unknown.
    """
    one_of("against", against, ("full-wave", "three-d"))
    others, whose = (_SEGMENTS, "segments") if against == "full-wave" else (_FULL_WAVES, "full waves")
    for name in options:
        if name not in ValidateOptions.__annotations__:
            raise TypeError(f"validate() got an unexpected keyword argument '{name}'")
        if name in others:
            raise InputError(f"'{name}' is for {whose}; leave it out against '{against}'")
    if options.get("ends") is not None:
        one_of("ends", options["ends"], ("open", "closed"))
    given = {name: plain(name, value) for name, value in options.items() if name != "material" and value is not None}
    return json.dumps(given, sort_keys=True)


def _comparison(
    structure: Structure,
    output: Union[str, "PathLike[str]"],
    against: str,
    options: Mapping[str, Any],
    with_material: bool,
    media: Mapping[str, Name] | None,
    simd: str | None,
    cache: Path | None,
    memory_bytes: int | None,
) -> _native.Comparison:
    """The comparison, planned."""
    text, material = checked_options(against, options), options.get("material")
    name = None if material is None else text_of("material", material)
    return _native.Comparison(
        structure, Path(output), against, text, with_material, name, media_of(media), simd, cache, memory_bytes
    )
