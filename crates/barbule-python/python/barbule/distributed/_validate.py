"""Comparisons with full waves and with segments on a cluster."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from .. import _native
from .._opening import Name, structure_of
from .._progress import ProgressLike, watched
from .._validate import Against, ValidateOptions, _comparison, checked_options
from ..errors import InputError, MachineError
from ._engine import UNIT_SECONDS, asked, compute, refuse_unlike
from ._work import Watch, identity_of, opened_alike, placed, placed_media

if TYPE_CHECKING:
    from typing_extensions import Unpack


@dataclass(frozen=True)
class ComparisonWork:
    """A comparison as it is sent to workers; items are its units."""

    structure: str
    structure_hash: str
    media: tuple[tuple[str, str], ...]
    against: str
    #: JSON.
    options: str
    folder: str
    simd: str
    #: What full waves are given up at.
    memory_bytes: int

    @property
    def label(self) -> str:
        """What is done, in a word, for progress."""
        return "full waves" if self.against == "full-wave" else "segments"

    @property
    def identity(self) -> str:
        """A hash of what is computed and where it goes."""
        return identity_of(**asdict(self))

    def prepare(self, folder: Path, slots: int) -> PreparedComparison:
        """Opens the structure and plans on a worker. Units are not compared there, so that no material is asked for."""
        structure = opened_alike(self.structure, self.media, self.structure_hash)
        options = json.loads(self.options)
        return PreparedComparison(
            _comparison(
                structure, self.folder, self.against, options, False, dict(self.media), self.simd, None, self.memory_bytes
            )
        )


class PreparedComparison:
    """A comparison on a worker."""

    def __init__(self, comparison: _native.Comparison) -> None:
        self._comparison = comparison

    def run(self, item: int, threads: int, watch: Watch) -> None:
        """Computes a unit and keeps it, unless it is there."""
        self._comparison.run(item, threads, watch)

    def close(self) -> None:
        """Nothing stays open."""


def validate(
    structure: Name,
    output: Union[str, "PathLike[str]"],
    against: Against = "full-wave",
    *,
    client: Any,
    simd: str | None = None,
    media: Mapping[str, Name] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    unit_seconds: float = UNIT_SECONDS,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
    **options: Unpack[ValidateOptions],
) -> dict[str, Any]:
    """Compares the fast simulation with full waves or with segments on a cluster: `barbule.validate`, to the same numbers.

    Workers compute full waves of individuals and wavelengths, or far fields of segments, into the folder's ``units``; the fast simulation,
    numbers and figures are made where the client is. What is there is not computed again; the same call goes on, and so does
    ``barbule validate`` with the same options and folder.

    Args:
        structure: Whatever `barbule.open` opens; files lie where all workers see them.
        output: Folder for figures, ``numbers.json`` and tables that all workers see.
        against: ``full-wave``, or ``three-d`` for segments.
        client: A `distributed.Client`.
        simd: SIMD instructions of segments by name; the widest that all workers and this process have without. Full waves, and segments of
            crystals, need workers whose widest are alike.
        media: Media of your own by name, each a file of n and k that all workers see.
        cache: Folder of computed materials, for the client alone.
        unit_seconds: What a task is to take at least, on one thread, as foretold.
        threads: Threads of each task.
        retries: How often a failed task is tried again.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.
        options: As for `barbule.validate`.

    Returns:
        As `barbule.validate`.

    Raises:
        InputError: As `barbule.validate`; a worker cannot see the structure, lacks the memory or the instructions.
        MachineError: A task failed too often, or units are missing in the end.
    """
    if not unit_seconds > 0.0:
        raise InputError(f"units of {unit_seconds} s cannot be made; give more than 0")
    name, own = placed(structure), placed_media(media)
    opened = structure_of(name, dict(own))
    text = checked_options(against, options)
    cluster = asked(client, simd)
    folder = Path(output).absolute()
    kept = None if cache is None else Path(cache)
    memory_bytes = int(cluster.memory_bytes)
    planned = _comparison(opened, folder, against, options, True, dict(own), cluster.simd, kept, memory_bytes)
    if not planned.is_pinned:
        refuse_unlike(cluster, "full waves and crystals")
    work = ComparisonWork(
        structure=name,
        structure_hash=opened.hash,
        media=own,
        against=against,
        options=text,
        folder=str(folder),
        simd=cluster.simd,
        memory_bytes=memory_bytes,
    )
    missing = planned.missing()
    if missing:
        costs = planned.costs(threads)
        compute(
            work,
            _tasks(missing, [seconds * threads for seconds, _ in costs], unit_seconds),
            cluster,
            memory_bytes=max(costs[unit][1] for unit in missing),
            threads=threads,
            retries=retries,
            progress=progress,
        )
        missing = planned.missing()
    if missing:
        raise MachineError(
            f"{folder}: {len(missing)} of {len(planned)} units are missing or damaged although their tasks ended well; "
            "look whether all workers see the same folder"
        )
    with watched(progress) as watch:
        found: dict[str, Any] = json.loads(planned.finish(None, watch))
    return found


def _tasks(missing: Sequence[int], seconds: Sequence[float], least: float) -> list[range]:
    """Runs of units, each of which holds missing ones that take so long, s, together; the last one what is left. Units between that are
    there take no time."""
    tasks: list[range] = []
    first, held = missing[0], 0.0
    for unit in missing:
        if held >= least:
            tasks.append(range(first, unit))
            first, held = unit, 0.0
        held += seconds[unit]
    tasks.append(range(first, missing[-1] + 1))
    return tasks
