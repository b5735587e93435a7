"""Work on a cluster of Dask: tasks that return their number alone, tried again, watched and stopped."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from .. import _native
from .._progress import ProgressLike, watched
from ..errors import BarbuleError, InputError, MachineError, NotSettledError
from ._dask import checked_client, dask_distributed
from ._work import Work

#: What a task takes at least, s, on one thread: so that Dask's own 3 to 10 ms are less than a percent.
UNIT_SECONDS = 2.0

#: How often workers may end, in good order, that have the same task.
MOST_ENDS = 20

#: How often workers may die while they are told of the work, before the call gives up.
MOST_REGISTRATIONS = 10


@dataclass(frozen=True)
class Cluster:
    """A client, and what its workers are.

    Attributes:
        client: The client.
        simd: The widest SIMD instructions that every worker has, and this process.
        memory_bytes: What the smallest worker may take.
        slots: Tasks that run at once.
        are_alike: Whether the widest SIMD instructions of all workers and of this process are the same.
        declare_memory: Whether all workers were started with the resource by which tasks say what memory they take.
    """

    client: Any
    simd: str
    memory_bytes: float
    slots: int
    are_alike: bool
    declare_memory: bool


def asked(client: Any, simd: str | None = None) -> Cluster:
    """Asks all workers what they are.

    Raises:
        InputError: There are none, one lacks barbule or has another version, or not all have the instructions `simd`.
    """
    checked_client(client)
    from . import _worker

    answers = client.run(_worker.about_here, on_error="return")
    # Workers that die meanwhile are none.
    found = {address: about for address, about in answers.items() if not isinstance(about, OSError)}
    if not found:
        raise InputError("the cluster has no workers yet; scale it, and give client.wait_for_workers(1)")
    for address, about in found.items():
        if isinstance(about, BaseException):
            raise InputError(f"the worker {address} cannot run barbule ({about}); install the same version there") from about
    _worker.refuse_versions(found)
    here = _native.simd()
    common = [name for name in here if all(name in about["simd"] for about in found.values())]
    if simd is not None and simd not in common:
        raise InputError(f"'simd' is '{simd}', which not all workers and this process have; all have {', '.join(common)}")
    return Cluster(
        client=client,
        simd=simd or common[0],
        memory_bytes=min(about["memory_bytes"] for about in found.values()),
        slots=sum(about["threads"] for about in found.values()),
        are_alike=all(about["simd"][0] == here[0] for about in found.values()),
        declare_memory=all(about["declares_memory"] for about in found.values()),
    )


def refuse_unlike(cluster: Cluster, what: str) -> None:
    """Refuses workers of several kinds for work whose last bits depend on the processor, and cannot be pinned.

    Raises:
        InputError: The widest SIMD instructions of the workers and of this process differ.
    """
    if not cluster.are_alike:
        raise InputError(f"{what} need workers with the same widest SIMD instructions as this process; choose machines that are alike")


def compute(
    work: Work,
    tasks: Sequence[range],
    cluster: Cluster,
    *,
    memory_bytes: float,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> None:
    """Computes runs of items on the workers of a cluster, each run in one task.

    Args:
        work: What is computed.
        tasks: The runs.
        cluster: Where.
        memory_bytes: What a task takes; no worker has more at once than it may take.
        threads: Threads of each task.
        retries: How often a task is tried again which failed or whose workers died, beside what Dask tries itself.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Raises:
        InputError: A task needs more memory than a worker has, or what a worker refuses.
        MachineError: A task failed too often.
    """
    if memory_bytes > cluster.memory_bytes:
        need, have = (f"{bytes_ / 1e6:.0f} MB" for bytes_ in (memory_bytes, cluster.memory_bytes))
        raise InputError(f"a task takes {need} of memory, and a worker has {have}; give fewer instances, or larger workers")
    if threads < 1 or retries < 0:
        raise InputError(f"'threads' is {threads} and 'retries' {retries}; give at least 1 and 0")
    if not tasks:
        return
    from ._worker import Preparation, forget

    client = cluster.client
    name = f"barbule-{work.identity}-{uuid.uuid4().hex[:8]}"
    total = sum(len(task) for task in tasks)
    sent = _Sent(cluster, name, tasks, memory_bytes, threads, retries)
    try:
        _register(client, Preparation(name, work), name)
        with watched(progress) as watch:
            for done in sent.finished():
                if watch is not None:
                    watch(work.label, done, total)
    except BaseException:
        # A cluster that is gone needs no word of it.
        with suppress(Exception):
            sent.cancel()
        raise
    finally:
        # Native calls end as they next look, where there are any. A worker that dies here keeps none of the others from hearing of it.
        with suppress(Exception):
            client.run(forget, name, on_error="ignore")
        with suppress(Exception):
            client.unregister_worker_plugin(name)


def _register(client: Any, plugin: Any, name: str) -> None:
    """Hands the work to all workers, those that come later among them."""
    for _ in range(MOST_REGISTRATIONS - 1):
        try:
            client.register_plugin(plugin, name=name)
            return
        except OSError:
            # A worker died meanwhile, and others may not have heard of it.
            continue
    client.register_plugin(plugin, name=name)


class _Sent:
    """Tasks that are on their way."""

    def __init__(
        self, cluster: Cluster, name: str, tasks: Sequence[range], memory_bytes: float, threads: int, retries: int
    ) -> None:
        self._client = cluster.client
        self._name = name
        self._tasks = tasks
        self._memory_bytes = memory_bytes
        self._declare = cluster.declare_memory
        self._threads = threads
        self._retries = retries
        self._sendings = [0] * len(tasks)
        self._failures = [0] * len(tasks)
        self._ends = [0] * len(tasks)
        self._pending: dict[Any, int] = {}

    def finished(self) -> Iterator[int]:
        """Sends all tasks; yields how many items are done, whenever a task is."""
        sent = [self._send(number) for number in range(len(self._tasks))]
        completed = dask_distributed().as_completed(sent, loop=self._client.loop)
        # Nothing else holds what has ended.
        del sent
        done = 0
        for future in completed:
            number = self._pending.pop(future)
            status = future.status
            if status == "finished":
                # Its result is its number: nothing is fetched that could die with a worker.
                done += len(self._tasks[number])
                future.release()
                yield done
            elif status in ("error", "cancelled"):
                self._judge(number, future, status)
                completed.add(self._send(number))
            else:
                # Its worker died before it was told of; Dask computes it again, and finds it done.
                self._pending[future] = number
                completed.add(future)

    def cancel(self) -> None:
        """Gives up all that is pending."""
        if self._pending:
            self._client.cancel(list(self._pending), force=True)
            self._pending.clear()

    def _send(self, number: int) -> Any:
        from ._worker import MEMORY, run_items

        task = self._tasks[number]
        future = self._client.submit(
            run_items,
            self._name,
            number,
            task.start,
            task.stop,
            self._threads,
            self._memory_bytes,
            key=f"{self._name}-{number}-{self._sendings[number]}",
            # Workers share out their memory anyway; so declared, the scheduler sends them no more than they can hold.
            resources={MEMORY: self._memory_bytes} if self._declare else None,
            # The first are sent first: neighbours share tables.
            priority=-number,
            pure=False,
        )
        self._sendings[number] += 1
        self._pending[future] = number
        return future

    def _judge(self, number: int, future: Any, status: str) -> None:
        """Lets a task be tried again, or raises."""
        if status == "cancelled":
            raise MachineError("the cluster dropped a task; call the same function again to go on")
        from ._worker import Stopped

        error = future.exception()
        if isinstance(error, Stopped):
            # Nobody stopped it here: its worker has ended in good order, as with its job's time.
            self._ends[number] += 1
            if self._ends[number] > MOST_ENDS:
                raise MachineError(
                    f"the workers of a task ended {self._ends[number]} times while they had it; give them more time than 'unit_seconds', "
                    "and call the same function again to go on"
                )
            return
        if isinstance(error, (InputError, NotSettledError)):
            raise error
        self._failures[number] += 1
        if self._failures[number] <= self._retries:
            return
        if isinstance(error, BarbuleError):
            raise error
        raise MachineError(
            f"a task failed {self._failures[number]} times ({error}); look into the workers' logs, and call the same function again to go on"
        ) from error
