"""From structures to materials: campaigns and fits."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Union

from numpy.typing import ArrayLike

from . import _native
from ._labels import numbers, plain
from ._material import Material
from ._native import Structure
from ._opening import Name, structure_of
from ._progress import ProgressLike, watched
from .errors import InputError


def _options(
    wavelengths_nm: ArrayLike | None,
    directions: tuple[int, int],
    instances: int | None,
    tilt_deg: float,
    polarized: bool,
    thin: int | None,
    seed: int,
    mirror: bool,
) -> str:
    options: dict[str, Any] = {
        "directions": directions,
        "instances": instances,
        "tilt_deg": tilt_deg,
        "polarized": polarized,
        "thin": thin,
        "seed": seed,
        "mirror": mirror,
    }
    if wavelengths_nm is not None:
        options["wavelengths_nm"] = numbers(wavelengths_nm)
    for name, count in (("instances", instances), ("thin", thin), ("seed", seed)):
        if count is not None and count < 0:
            raise InputError(f"'{name}' is {count}; give 0 or more")
    return json.dumps({name: plain(name, value) for name, value in options.items()})


def characterize(
    structure: Structure | Name,
    *,
    wavelengths_nm: ArrayLike | None = None,
    directions: tuple[int, int] = (20, 20),
    instances: int | None = None,
    tilt_deg: float = 2.0,
    polarized: bool = False,
    thin: int | None = None,
    seed: int = 1,
    mirror: bool = False,
    halo: bool = False,
    sigma: float | None = None,
    store: Union[str, "PathLike[str]", None] = None,
    cache: Union[str, "PathLike[str]", None] = None,
    media: Mapping[str, Name] | None = None,
    memory_bytes: int | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> Material:
    """Simulates a structure and fits its material; minutes at the usual sampling, a second with ``thin=10``.

    Ctrl-C, or a `progress` that raises, stops it; with a `store` the same call goes on, to the same bits.

    Args:
        structure: A structure, or whatever `barbule.open` opens.
        wavelengths_nm: Vacuum wavelengths, rising; 300 to 700 in steps of 8 without.
        directions: cosθ_i in so many equal steps up to 1, cosφ_i likewise.
        instances: Random individuals; 50 without, 12 of a thinned campaign.
        tilt_deg: Largest tilt of an individual about its axis.
        polarized: Whether both incident polarizations are kept apart.
        thin: Every so many-th wavelength and direction only: a quick look.
        seed: Seed of individuals and tilts.
        mirror: Whether each individual counts with its mirror image.
        halo: Whether the spread along the barbule is measured in three dimensions.
        sigma: The spread along the barbule; 0.04 without.
        store: Folder of the campaign, kept and resumed.
        cache: Folder of computed tables; that of the command line without one.
        media: Media of your own by name, each a file of n and k.
        memory_bytes: What may be taken at most, by fewer wavelengths at once; what the machine has left without.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Example:
        >>> import barbule
        >>> material = barbule.characterize("starling:pink", thin=10)
        >>> len(material.wavelengths_nm)
        6
    """
    opened = structure_of(structure, media)
    options = _options(wavelengths_nm, directions, instances, tilt_deg, polarized, thin, seed, mirror)
    with watched(progress) as watch:
        return Material(
            _native.characterize(
                opened, options, halo, sigma, _path(store), _path(cache), memory_bytes, threads, watch
            )
        )


def simulate(
    structure: Structure | Name,
    store: Union[str, "PathLike[str]"],
    *,
    wavelengths_nm: ArrayLike | None = None,
    directions: tuple[int, int] = (20, 20),
    instances: int | None = None,
    tilt_deg: float = 2.0,
    polarized: bool = False,
    thin: int | None = None,
    seed: int = 1,
    mirror: bool = False,
    keep_fields_nm: Sequence[float] = (),
    shard: tuple[int, int] = (0, 1),
    cache: Union[str, "PathLike[str]", None] = None,
    media: Mapping[str, Name] | None = None,
    memory_bytes: int | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> tuple[int, int]:
    """Fills a campaign's store (Zarr), or goes on with it: what is there is not computed again.

    Args:
        structure: A structure, or whatever `barbule.open` opens.
        store: The store's folder; other readers open it as Zarr.
        wavelengths_nm: As for `characterize`, and so the next ones.
        directions: As for `characterize`.
        instances: As for `characterize`.
        tilt_deg: As for `characterize`.
        polarized: As for `characterize`.
        thin: As for `characterize`.
        seed: As for `characterize`.
        mirror: As for `characterize`.
        keep_fields_nm: Wavelengths at which the fields of all individuals are kept.
        shard: ``(i, n)``: the i-th of n parts, for several processes on one store.
        cache: Folder of computed tables; that of the command line without one.
        media: Media of your own by name, each a file of n and k.
        memory_bytes: What may be taken at most, by fewer wavelengths at once; what the machine has left without.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        How many units were computed, and how many were there.

    Example:
        >>> import barbule, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     first = barbule.simulate("starling", folder + "/S.zarr", thin=10)
        ...     again = barbule.simulate("starling", folder + "/S.zarr", thin=10)
        >>> first[1] == 0, again == (0, first[0])
        (True, True)
    """
    opened = structure_of(structure, media)
    options = _options(wavelengths_nm, directions, instances, tilt_deg, polarized, thin, seed, mirror)
    kept = [float(nm) for nm in keep_fields_nm]
    with watched(progress) as watch:
        return _native.simulate(opened, Path(store), options, kept, shard, _path(cache), memory_bytes, threads, watch)


def fit(
    store: Union[str, "PathLike[str]"],
    *,
    sigma: float | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> Material:
    """Fits the material of a store that `simulate` has filled.

    Args:
        store: The store's folder.
        sigma: The spread along the barbule; 0.04 without.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Raises:
        InputError: Units are missing or damaged.

    Example:
        >>> import barbule, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     done = barbule.simulate("starling", folder + "/S.zarr", thin=10)
        ...     material = barbule.fit(folder + "/S.zarr")
        >>> len(material.wavelengths_nm)
        6
    """
    with watched(progress) as watch:
        return Material(_native.fit(Path(store), sigma, threads, watch))


def _path(given: Union[str, "PathLike[str]", None]) -> Path | None:
    return None if given is None else Path(given)
