"""Atlases: sizes of a species or stack swept into one store of spectra, colours and materials."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import NamedTuple, Union

from . import _native
from ._labels import media_of
from ._opening import Name
from ._progress import ProgressLike, watched


class Outcome(NamedTuple):
    """What a run of an atlas did.

    Example:
        >>> import barbule
        >>> done = barbule.Outcome(computed=4, found=12, repaired=0, unit_seconds={0: 1.5, 1: 1.4, 2: 1.6, 3: 1.5})
        >>> sum(done.unit_seconds.values()) / done.computed
        1.5
    """

    #: Units computed now.
    computed: int
    #: Units that were there and whole.
    found: int
    #: Units that were there but damaged, and were computed again.
    repaired: int
    #: Seconds of each unit computed now, by its number.
    unit_seconds: dict[int, float]


class Forecast(NamedTuple):
    """What an atlas will take on this machine, as `foretell` gives it.

    Example:
        >>> import barbule
        >>> takes = barbule.Forecast(714, 12, 40, 2_000_000, 300_000_000, 2, (0.2, 0.3), 90.0)
        >>> f"{takes.cells} structures, {takes.seconds:.0f} s on {takes.cores} cores"
        '714 structures, 90 s on 2 cores'
    """

    #: Structures.
    cells: int
    #: Units of work.
    units: int
    #: Files of the finished store.
    files: int
    #: Bytes of the finished store.
    bytes: int
    #: Memory of one process, bytes.
    memory_bytes: int
    #: Cores that the times are for.
    cores: int
    #: Seconds of each structure that was tried.
    cell_seconds: tuple[float, ...]
    #: Seconds of everything.
    seconds: float


def atlas(
    plan: Name,
    store: Union[str, "PathLike[str]"],
    *,
    shard: tuple[int, int] = (0, 1),
    seed: int = 1,
    media: Mapping[str, Name] | None = None,
    simd: str | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    memory_bytes: int | None = None,
    page: Union[str, "PathLike[str]", None] = None,
    picture: Union[str, "PathLike[str]", None] = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> Outcome:
    """Computes the atlas of a plan into a store (Zarr), or goes on with it; `xarray.open_zarr` opens it.

    Ctrl-C, or a `progress` that raises, stops it; the same call goes on, to the same bits, whatever the parts and threads.

    Args:
        plan: The file of the plan (TOML): which keys are swept, over which values.
        store: The store's folder.
        shard: ``(i, n)``: the i-th of n parts, for several processes on one store.
        seed: Seed of individuals and of samples.
        media: Media of your own by name, each a file of n and k.
        simd: SIMD instructions, alike on all machines of one store; the widest of this processor without.
        cache: Folder of computed tables; that of the command line without one.
        memory_bytes: What may be taken at most; what the machine has left without.
        page: Folder of a page for browsers: maps, spectra, a file of each structure.
        picture: File of the map of colours (``.svg``, ``.pdf`` or ``.png``).
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        How many units were computed and were there, and the seconds of each that was computed.

    Raises:
        InputError: The plan cannot be, or the store is of another one; the message names the key.
        MachineError: The store cannot be written.

    Example:
        >>> import barbule, pathlib, tempfile
        >>> plan = '''
        ... barbule = 1
        ... name = "films"
        ... structure = "air/keratin:300/melanin"
        ... wavelengths_nm = "400:700:20"
        ... [[vary]]
        ... key = "layer1"
        ... values = "250:350:50"
        ... '''
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "films.toml")
        ...     _ = file.write_text(plan)
        ...     done = barbule.atlas(file, pathlib.Path(folder, "films.zarr"))
        >>> done.computed > 0 and done.found == 0
        True
    """
    given_media = media_of(media)
    drawn = _path(page), _path(picture)
    with watched(progress) as watch:
        computed, found, repaired, seconds = _native.atlas(
            Path(plan), Path(store), shard, seed, given_media, simd, _path(cache), memory_bytes, *drawn, threads, watch
        )
    return Outcome(computed, found, repaired, dict(seconds))


def foretell(
    plan: Name,
    *,
    seed: int = 1,
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> Forecast:
    """What the atlas of a plan will take, from a few structures that are tried at a few wavelengths.

    Args:
        plan: The file of the plan (TOML).
        seed: Seed of individuals and of samples.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Raises:
        InputError: The plan cannot be; the message names the key.

    Example:
        >>> import barbule, pathlib, tempfile
        >>> plan = '''
        ... barbule = 1
        ... name = "films"
        ... structure = "air/keratin:300/melanin"
        ... wavelengths_nm = "400:700:20"
        ... [[vary]]
        ... key = "layer1"
        ... values = "250:350:50"
        ... '''
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "films.toml")
        ...     _ = file.write_text(plan)
        ...     barbule.foretell(file).cells
        3
    """
    given_media = media_of(media)
    with watched(progress) as watch:
        cells, units, files, size, memory, cores, cell_seconds, seconds = _native.foretell_atlas(
            Path(plan), seed, given_media, threads, watch
        )
    return Forecast(cells, units, files, size, memory, cores, tuple(cell_seconds), seconds)


def _path(given: Union[str, "PathLike[str]", None]) -> Path | None:
    return None if given is None else Path(given)
