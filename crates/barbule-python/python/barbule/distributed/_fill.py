"""Items of unknown length, in tasks of a few seconds."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from math import ceil

from .._progress import ProgressLike
from ..errors import MachineError
from ._engine import Cluster, compute
from ._work import Work


#: A round of trials that takes so long, s, is not repeated.
LONG_SECONDS = 30.0


def fill(
    work: Work,
    missing: Callable[[], Sequence[int]],
    cluster: Cluster,
    *,
    unit_seconds: float,
    memory_bytes: float,
    threads: int,
    retries: int,
    progress: ProgressLike,
    place: str,
) -> None:
    """Computes all items that are missing.

    How long an item takes is measured with the first of them, one on each worker's slot, and again when all is loaded; then as many go
    into a task as take `unit_seconds`.

    Args:
        work: What is computed.
        missing: Which items are not there, rising.
        cluster: Where.
        unit_seconds: What a task is to take at least, s.
        memory_bytes: As for `compute`, and so the next ones.
        threads: As for `compute`.
        retries: As for `compute`.
        progress: As for `compute`.
        place: Where items go, as it is said.

    Raises:
        MachineError: A task failed too often, or nothing came although tasks ended well.
    """
    together, measured = 1, 0
    while True:
        items = missing()
        if not items:
            return
        if together == 1 and measured < 2 and len(items) > cluster.slots:
            tasks = [range(item, item + 1) for item in items[: cluster.slots]]
        else:
            tasks = runs(items, together)
        is_trial = len(tasks) == cluster.slots < len(items) and together == 1 and measured < 2
        begun = time.monotonic()
        compute(work, tasks, cluster, memory_bytes=memory_bytes, threads=threads, retries=retries, progress=progress)
        seconds = max(time.monotonic() - begun, 1e-3)
        if is_trial:
            measured = 2 if seconds >= LONG_SECONDS else measured + 1
            if measured == 2 and seconds < unit_seconds:
                together = ceil(unit_seconds / seconds)
        elif len(missing()) == len(items):
            raise MachineError(f"{place}: nothing has come; look whether all workers see the same files")


def runs(items: Sequence[int], together: int) -> list[range]:
    """Runs of neighbours, none longer than `together`."""
    found: list[range] = []
    for item in items:
        if found and found[-1].stop == item and len(found[-1]) < together:
            found[-1] = range(found[-1].start, item + 1)
        else:
            found.append(range(item, item + 1))
    return found
