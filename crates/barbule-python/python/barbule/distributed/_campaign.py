"""Campaigns on a cluster."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, Union

from .. import _native
from .._make import _options
from .._material import Material
from .._native import Structure
from .._opening import Name, structure_of
from .._progress import ProgressLike, watched
from ..errors import InputError, MachineError
from ._engine import UNIT_SECONDS, Cluster, asked, compute
from ._mirror import Mirror, is_url, options_text
from ._work import Watch, identity_of, opened_alike, placed, placed_media

#: How often what is damaged or lost is computed again before the call gives up.
MOST_REPAIRS = 2


@dataclass(frozen=True)
class CampaignWork:
    """A campaign as it is sent to workers; items are its portions."""

    structure: str
    structure_hash: str
    media: tuple[tuple[str, str], ...]
    options: str
    keep_fields_nm: tuple[float, ...]
    store: str
    #: JSON; not in the identity, since it has credentials.
    storage_options: str
    simd: str
    seconds: float
    cache: str | None
    #: What describes a store that workers do not see: keys and texts.
    descriptions: tuple[tuple[str, str], ...] = ()

    label = "simulating"

    @property
    def identity(self) -> str:
        """A hash of what is computed and where it goes."""
        parts = asdict(self)
        del parts["storage_options"]
        return identity_of(**parts)

    def mirror(self) -> Mirror | None:
        """The object store, if it is one."""
        return Mirror(self.store, json.loads(self.storage_options)) if is_url(self.store) else None

    def campaign(self, structure: Structure, folder: Path) -> _native.Campaign:
        """The campaign with its store in a folder."""
        cache = None if self.cache is None else Path(self.cache)
        kept = list(self.keep_fields_nm)
        return _native.Campaign(structure, folder, self.options, kept, self.simd, self.seconds, cache, None)

    def prepare(self, folder: Path, slots: int) -> PreparedCampaign:
        """Opens structure and store on a worker; instances are prepared with the first portion."""
        structure = opened_alike(self.structure, self.media, self.structure_hash)
        mirror = self.mirror()
        if mirror is None:
            return PreparedCampaign(self.campaign(structure, Path(self.store)), None, Path(self.store), slots)
        local = folder / "store.zarr"
        for key, text in self.descriptions:
            (local / key).parent.mkdir(parents=True, exist_ok=True)
            (local / key).write_text(text, encoding="utf-8")
        return PreparedCampaign(self.campaign(structure, local), mirror, local, slots)


@dataclass(frozen=True)
class HaloWork:
    """The halo of a campaign's material; items are its units, which are kept beside the store."""

    campaign: CampaignWork

    label = "halo"

    @property
    def identity(self) -> str:
        """A hash of what is computed and where it goes."""
        return identity_of(halo=self.campaign.identity)

    def prepare(self, folder: Path, slots: int) -> PreparedHalo:
        """Opens structure and store on a worker."""
        work = self.campaign
        structure = opened_alike(work.structure, work.media, work.structure_hash)
        return PreparedHalo(work.campaign(structure, Path(work.store)))


class PreparedHalo:
    """A halo on a worker."""

    def __init__(self, campaign: _native.Campaign) -> None:
        self._campaign = campaign

    def run(self, item: int, threads: int, watch: Watch) -> None:
        """Simulates a unit and keeps it, unless it is there."""
        self._campaign.run_halo(item, threads, watch)

    def close(self) -> None:
        """Nothing stays open."""


class PreparedCampaign:
    """A campaign on a worker."""

    def __init__(self, campaign: _native.Campaign, mirror: Mirror | None, folder: Path, slots: int) -> None:
        self._campaign = campaign
        self._mirror = mirror
        self._folder = folder
        self._slots = slots

    def run(self, item: int, threads: int, watch: Watch) -> None:
        """Computes what the store lacks of a portion."""
        if self._mirror is None:
            if not self._campaign.is_done(item):
                self._computed(item, threads, watch)
            return
        missing = [unit for unit in self._campaign.files(item) if not self._mirror.has(unit[-1])]
        if not missing:
            return
        self._computed(item, threads, watch)
        for unit in missing:
            self._mirror.put(self._folder, unit)
        for unit in self._campaign.files(item):
            # The last first: what is left when a worker is killed here is no unit.
            for key in reversed(unit):
                (self._folder / key).unlink(missing_ok=True)

    def _computed(self, item: int, threads: int, watch: Watch) -> None:
        # The other slots have nothing to do before.
        self._campaign.prepare(self._slots, watch)
        self._campaign.run(item, threads, watch)

    def close(self) -> None:
        """Is seen in the store no more; the instances go with the object."""
        self._campaign.leave()


def simulate(
    structure: Name,
    store: Union[str, "PathLike[str]"],
    *,
    client: Any,
    wavelengths_nm: Sequence[float] | None = None,
    directions: tuple[int, int] = (20, 20),
    instances: int | None = None,
    tilt_deg: float = 2.0,
    polarized: bool = False,
    thin: int | None = None,
    seed: int = 1,
    mirror: bool = False,
    keep_fields_nm: Sequence[float] = (),
    storage_options: Mapping[str, Any] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    media: Mapping[str, Name] | None = None,
    simd: str | None = None,
    unit_seconds: float = UNIT_SECONDS,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> None:
    """Fills a campaign's store on a cluster, or goes on with it: `barbule.simulate`, to the same bits.

    What is killed, cancelled or damaged costs the portions that were at work; the same call goes on.

    Args:
        structure: Whatever `barbule.open` opens; files lie where all workers see them.
        store: A folder that all workers see, or a URL of fsspec's (``s3://bucket/S.zarr``).
        client: A `distributed.Client`.
        wavelengths_nm: As for `barbule.characterize`, and so the next ones.
        directions: As for `barbule.characterize`.
        instances: As for `barbule.characterize`.
        tilt_deg: As for `barbule.characterize`.
        polarized: As for `barbule.characterize`.
        thin: As for `barbule.characterize`.
        seed: As for `barbule.characterize`.
        mirror: As for `barbule.characterize`.
        keep_fields_nm: Wavelengths at which the fields of all individuals are kept.
        storage_options: What fsspec gets for a URL.
        cache: Folder of computed tables that all workers see: the orders of crystals are then solved once.
        media: Media of your own by name, each a file of n and k that all workers see.
        simd: SIMD instructions by name; the widest that all workers and this process have without. A store that is there keeps its own.
        unit_seconds: What a task is to take at least, on one thread, as foretold; campaigns that are shorter are one task.
        threads: Threads of each task; workers should have as many slots as cores, and tasks one thread.
        retries: How often a failed task is tried again.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Raises:
        InputError: A worker cannot see the structure, lacks the memory or has another version; the store is another campaign's.
        MachineError: A task failed too often, or units are missing in the end.
    """
    options = _options(wavelengths_nm, directions, instances, tilt_deg, polarized, thin, seed, mirror)
    work, opened, cluster = _described(
        structure, store, options, keep_fields_nm, storage_options, cache, media, simd, unit_seconds, client
    )
    how: dict[str, Any] = {"threads": threads, "retries": retries, "progress": progress}
    with tempfile.TemporaryDirectory(prefix="barbule-") as folder:
        _fill(_Opened(work, opened, Path(folder)), cluster, how)


def characterize(
    structure: Name,
    *,
    client: Any,
    store: Union[str, "PathLike[str]"],
    wavelengths_nm: Sequence[float] | None = None,
    directions: tuple[int, int] = (20, 20),
    instances: int | None = None,
    tilt_deg: float = 2.0,
    polarized: bool = False,
    thin: int | None = None,
    seed: int = 1,
    mirror: bool = False,
    halo: bool = False,
    sigma: float | None = None,
    storage_options: Mapping[str, Any] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    media: Mapping[str, Name] | None = None,
    simd: str | None = None,
    unit_seconds: float = UNIT_SECONDS,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> Material:
    """Simulates a structure on a cluster and fits its material here: `barbule.characterize`, to the same bits.

    Args:
        structure: As for `simulate`, and so all that is not named below.
        client: A `distributed.Client`.
        store: A folder that all workers see, or a URL of fsspec's (``s3://bucket/S.zarr``).
        wavelengths_nm: As for `barbule.characterize`, and so the next ones.
        directions: As for `barbule.characterize`.
        instances: As for `barbule.characterize`.
        tilt_deg: As for `barbule.characterize`.
        polarized: As for `barbule.characterize`.
        thin: As for `barbule.characterize`.
        seed: As for `barbule.characterize`.
        mirror: As for `barbule.characterize`.
        halo: As for `barbule.characterize`.
        sigma: The spread along the barbule; 0.04 without.
        storage_options: As for `simulate`, and so the next ones.
        cache: As for `simulate`.
        media: As for `simulate`.
        simd: As for `simulate`.
        unit_seconds: As for `simulate`.
        threads: As for `simulate`.
        retries: As for `simulate`.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Raises:
        InputError: As `simulate`.
        MachineError: As `simulate`.
    """
    options = _options(wavelengths_nm, directions, instances, tilt_deg, polarized, thin, seed, mirror)
    work, opened, cluster = _described(structure, store, options, (), storage_options, cache, media, simd, unit_seconds, client)
    if halo and is_url(work.store):
        raise InputError("a halo is kept in a folder beside the store; give a store in a folder that all workers see")
    how: dict[str, Any] = {"threads": threads, "retries": retries, "progress": progress}
    with tempfile.TemporaryDirectory(prefix="barbule-") as folder:
        here = _Opened(work, opened, Path(folder))
        here.campaign.check(sigma)
        _fill(here, cluster, how)
        if halo:
            _fill_halo(here, cluster, how)
        with watched(progress) as watch:
            return Material(here.campaign.material(sigma, halo, None, watch))


def _described(
    structure: Name,
    store: Union[str, "PathLike[str]"],
    options: str,
    keep_fields_nm: Sequence[float],
    storage_options: Mapping[str, Any] | None,
    cache: Union[str, "PathLike[str]", None],
    media: Mapping[str, Name] | None,
    simd: str | None,
    unit_seconds: float,
    client: Any,
) -> tuple[CampaignWork, Structure, Cluster]:
    """The work, its structure, and the cluster as it is asked for."""
    name, own = placed(structure), placed_media(media)
    opened = structure_of(name, dict(own))
    place = os.fspath(store)
    text = options_text(storage_options)
    if is_url(place):
        with tempfile.TemporaryDirectory(prefix="barbule-") as folder:
            there = Mirror(place, storage_options).fetch_descriptions(Path(folder))
            recorded = _native.Campaign.simd_of(Path(folder)) if there else None
    else:
        place = str(Path(place).absolute())
        recorded = _native.Campaign.simd_of(Path(place))
    cluster = asked(client, simd or recorded)
    work = CampaignWork(
        structure=name,
        structure_hash=opened.hash,
        media=own,
        options=options,
        keep_fields_nm=tuple(float(nm) for nm in keep_fields_nm),
        store=place,
        storage_options=text,
        simd=cluster.simd,
        seconds=float(unit_seconds),
        cache=None if cache is None else str(Path(cache).absolute()),
    )
    return work, opened, cluster


class _Opened:
    """A campaign where the client is, with its store or a copy of what describes it.

    Attributes:
        campaign: The campaign.
        work: What is sent to workers.
    """

    def __init__(self, work: CampaignWork, structure: Structure, scratch: Path) -> None:
        self._mirror = work.mirror()
        self._folder = Path(work.store) if self._mirror is None else scratch / "store.zarr"
        is_there = self._mirror is not None and self._mirror.fetch_descriptions(self._folder)
        self.campaign = work.campaign(structure, self._folder)
        self.work = work
        if self._mirror is None:
            return
        own = self.campaign.own_files()
        if not is_there:
            self._mirror.put(self._folder, own)
        texts = [(key, (self._folder / key).read_text(encoding="utf-8")) for key in own if key.endswith(".json")]
        self.work = replace(work, descriptions=tuple(texts))

    def missing(self) -> list[int]:
        """The portions that are not whole; of an object store what is there is copied here, and what is damaged deleted there."""
        portions = [self.campaign.files(item) for item in range(len(self.campaign))]
        if self._mirror is not None:
            lacking = [unit for units in portions for unit in units if not (self._folder / unit[-1]).exists()]
            self._mirror.fetch(self._folder, [key for unit in lacking for key in unit])
        missing = [item for item in range(len(portions)) if not self.campaign.is_done(item)]
        if self._mirror is not None:
            for item in missing:
                ends = [unit[-1] for unit in portions[item]]
                # Where some are not there yet, the others may well be whole.
                if all((self._folder / end).exists() for end in ends):
                    self._mirror.drop(ends)
                    for end in ends:
                        (self._folder / end).unlink(missing_ok=True)
        return missing


def _fill(store: _Opened, cluster: Cluster, how: Mapping[str, Any]) -> None:
    """Fills the store, and looks whether all of it is there."""
    campaign = store.campaign
    missing = store.missing()
    memory_bytes = 0
    for _ in range(1 + MOST_REPAIRS):
        if not missing:
            break
        if not memory_bytes:
            with watched(how["progress"]) as watch:
                memory_bytes = campaign.memory_bytes(how["threads"], watch)
        compute(store.work, [range(item, item + 1) for item in missing], cluster, memory_bytes=memory_bytes, **how)
        missing = store.missing()
    if missing:
        raise MachineError(
            f"{store.work.store}: {len(missing)} of {len(campaign)} portions are missing or damaged although their tasks ended well; "
            "look whether all workers see the same store"
        )
    campaign.end()


def _fill_halo(store: _Opened, cluster: Cluster, how: Mapping[str, Any]) -> None:
    """Simulates what is missing of the halo."""
    campaign = store.campaign
    missing = [unit for unit in range(campaign.halo_count) if not campaign.is_halo_done(unit)]
    if missing:
        tasks = [range(unit, unit + 1) for unit in missing]
        compute(HaloWork(store.work), tasks, cluster, memory_bytes=campaign.halo_bytes(how["threads"]), **how)
