"""Atlases on a cluster."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import ceil
from os import PathLike
from pathlib import Path
from typing import Any, Union

from .. import _native
from .._opening import Name
from .._progress import ProgressLike, watched
from ..errors import InputError, MachineError
from ._engine import UNIT_SECONDS, asked, compute
from ._fill import runs
from ._mirror import is_url
from ._work import Watch, identity_of, placed_media

#: How often what is damaged or lost is computed again before the call gives up.
MOST_REPAIRS = 2


@dataclass(frozen=True)
class AtlasWork:
    """An atlas as it is sent to workers; items are its units."""

    plan: str
    store: str
    seed: int
    media: tuple[tuple[str, str], ...]
    simd: str

    label = "simulating"

    @property
    def identity(self) -> str:
        """A hash of what is computed and where it goes."""
        return identity_of(**asdict(self))

    def opened(self) -> _native.AtlasUnits:
        """The atlas with its store, which refuses another plan than its own."""
        return _native.AtlasUnits(Path(self.plan), Path(self.store), self.seed, self.media, self.simd)

    def prepare(self, folder: Path, slots: int) -> PreparedAtlas:
        """Opens plan and store on a worker."""
        return PreparedAtlas(self.opened())


class PreparedAtlas:
    """An atlas on a worker."""

    def __init__(self, units: _native.AtlasUnits) -> None:
        self._units = units

    def run(self, item: int, threads: int, watch: Watch) -> None:
        """Computes a unit, unless it is there."""
        self._units.run(item, threads, watch)

    def close(self) -> None:
        """Ends the announcement that this worker computes."""
        self._units.end()


def atlas(
    plan: Name,
    store: Union[str, "PathLike[str]"],
    *,
    client: Any,
    seed: int = 1,
    media: Mapping[str, Name] | None = None,
    simd: str | None = None,
    unit_seconds: float = UNIT_SECONDS,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> None:
    """Computes the atlas of a plan on a cluster, or goes on with it: `barbule.atlas`, to the same bits.

    What is killed, cancelled or damaged costs the units that were at work; the same call goes on. `xarray.open_zarr` opens the store, and
    `barbule.atlas` with the same plan draws it.

    Args:
        plan: The file of the plan (TOML); it and what it names lie where all workers see them.
        store: A folder that all workers see.
        client: A `distributed.Client`.
        seed: Seed of individuals and of samples.
        media: Media of your own by name, each a file of n and k that all workers see.
        simd: SIMD instructions by name; the widest that all workers and this process have without. A store that is there keeps its own.
        unit_seconds: What a task is to take at least, on one thread, as foretold: shorter units go together.
        threads: Threads of each task; workers should have as many slots as cores, and tasks one thread.
        retries: How often a failed task is tried again.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Raises:
        InputError: The plan cannot be, a worker cannot see it, lacks the memory or has another version; the store is another plan's.
        MachineError: A task failed too often, or units are missing in the end.
    """
    place = os.fspath(store)
    if is_url(place):
        raise InputError(f"{place}: an atlas is written into a folder that all workers see; give one")
    if not unit_seconds > 0.0:
        raise InputError(f"'unit_seconds' is {unit_seconds}; give a time above 0")
    place = str(Path(place).absolute())
    cluster = asked(client, simd or _native.AtlasUnits.simd_of(Path(place)))
    work = AtlasWork(str(Path(plan).absolute()), place, seed, placed_media(media), cluster.simd)
    units = work.opened()
    missing = _missing(units)
    together, memory_bytes = 1, 0
    if missing:
        with watched(progress) as watch:
            seconds, memory_bytes = units.foretell(threads, watch)
        together = max(1, ceil(unit_seconds / max(seconds, 1e-6)))
        # No slot without work because tasks are long.
        together = min(together, ceil(len(missing) / cluster.slots))
    for _ in range(1 + MOST_REPAIRS):
        if not missing:
            break
        tasks = runs(missing, together)
        compute(work, tasks, cluster, memory_bytes=memory_bytes, threads=threads, retries=retries, progress=progress)
        missing = _missing(units)
    if missing:
        raise MachineError(
            f"{place}: {len(missing)} of {len(units)} units are missing or damaged although their tasks ended well; "
            "look whether all workers see the same store"
        )
    units.end()


def _missing(units: _native.AtlasUnits) -> list[int]:
    return [unit for unit in range(len(units)) if not units.is_done(unit)]
