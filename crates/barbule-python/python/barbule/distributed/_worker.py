"""What runs on workers. Only imported where Dask is."""

from __future__ import annotations

import shutil
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from distributed import WorkerPlugin, get_worker  # type: ignore[import-not-found, import-untyped, unused-ignore]
from distributed.system import MEMORY_LIMIT  # type: ignore[import-not-found, import-untyped, unused-ignore]

from .. import _native
from ..errors import InputError, MachineError
from ._work import VERSION, Prepared, Watch, Work

#: The resource of Dask by which tasks say what memory they take, bytes, where all workers are started with it.
MEMORY = "barbule-memory"

#: How often a task that waits for memory looks whether it is still wanted, s.
LOOK_S = 0.1

#: After how long without a task a worker gives back what it has prepared, s: the client may be gone without a word.
IDLE_S = 60.0

#: The names of work that is to stop, in this process.
_stopping: set[str] = set()


class Stopped(Exception):
    """The client does not want the work any more, or the worker ends."""


def about_here(dask_worker: Any) -> dict[str, Any]:
    """What the client has to know of a worker, which Dask gives under this name."""
    return {
        "version": VERSION,
        "simd": _native.simd(),
        "memory_bytes": _memory_bytes(dask_worker),
        "threads": dask_worker.state.nthreads,
        "declares_memory": MEMORY in dask_worker.state.total_resources,
    }


def stop(name: str) -> None:
    """Stops the native calls of some work in this process."""
    _stopping.add(name)


def forget(name: str, dask_worker: Any) -> None:
    """Stops some work in this process, and gives back what it has taken."""
    plugin = dask_worker.plugins.get(name)
    if isinstance(plugin, Preparation):
        plugin.teardown(dask_worker)


def _memory_bytes(worker: Any) -> float:
    """What a worker may take, by its limit and by what it was started with."""
    limit = float(worker.memory_manager.memory_limit or MEMORY_LIMIT)
    return min(limit, float(worker.state.total_resources.get(MEMORY, limit)))


class Budget:
    """Memory that is shared out to the tasks of this process."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._taken = 0.0

    @contextmanager
    def share(self, bytes_: float, limit: float, watch: Watch) -> Iterator[None]:
        """Waits until so much is free of what the worker may take. A task that finds all of it free never waits."""
        with self._changed:
            while self._taken > 0.0 and self._taken + bytes_ > limit:
                self._changed.wait(LOOK_S)
                watch("waiting", 0, 1)
            self._taken += bytes_
        try:
            yield
        finally:
            with self._changed:
                self._taken -= bytes_
                self._changed.notify_all()


_budget = Budget()


class Preparation(WorkerPlugin):  # type: ignore[misc, unused-ignore]
    """Work on a worker: prepared with its first item, whichever thread has it, and once."""

    def __init__(self, name: str, work: Work) -> None:
        self.name = name
        self._work = work

    def setup(self, worker: Any) -> None:
        """Nothing that takes long: the worker's other threads wait meanwhile."""
        # Where it is set up again, it was torn down before.
        _stopping.discard(self.name)
        self._lock = threading.Lock()
        self._slots = worker.state.nthreads
        self._prepared: Prepared | None = None
        self._users = 0
        self._idle = threading.Timer(IDLE_S, self._give_back)
        self._folder = Path(tempfile.mkdtemp(prefix="barbule-", dir=worker.local_directory))

    def teardown(self, worker: Any) -> None:
        """Stops what still runs, and forgets."""
        stop(self.name)
        self._idle.cancel()
        self._close()
        shutil.rmtree(self._folder, ignore_errors=True)

    @contextmanager
    def prepared(self) -> Iterator[Prepared]:
        """The work, opened as long as tasks need it and a while longer."""
        with self._lock:
            if self.name in _stopping:
                raise Stopped(f"{self.name} was stopped")
            self._idle.cancel()
            if self._prepared is None:
                self._prepared = self._work.prepare(self._folder, self._slots)
            prepared = self._prepared
            self._users += 1
        try:
            yield prepared
        finally:
            with self._lock:
                self._users -= 1
                if not self._users and self._prepared is not None:
                    self._idle = threading.Timer(IDLE_S, self._give_back)
                    self._idle.daemon = True
                    self._idle.start()

    def _give_back(self) -> None:
        with self._lock:
            if not self._users:
                self._close()

    def _close(self) -> None:
        prepared, self._prepared = self._prepared, None
        if prepared is not None:
            prepared.close()


def run_items(name: str, number: int, first: int, end: int, threads: int, memory_bytes: float) -> int:
    """A task: computes items, and gives nothing back but its own number."""
    worker = get_worker()
    plugin = worker.plugins.get(name)
    if not isinstance(plugin, Preparation):
        raise MachineError("the worker does not know this work any more; call the same function again to go on")
    watch = _watch(name, worker, worker.get_current_task())
    with _budget.share(memory_bytes, _memory_bytes(worker), watch), plugin.prepared() as prepared:
        for item in range(first, end):
            watch("", item, end)
            prepared.run(item, threads, watch)
    return number


def _watch(name: str, worker: Any, key: Any) -> Watch:
    """Raises as soon as the client has stopped the work, or given up this task."""

    def watch(label: str, done: int, total: int) -> None:
        task = worker.state.tasks.get(key)
        if name in _stopping or (task is not None and task.state in ("cancelled", "released", "forgotten")):
            raise Stopped(f"{name} was stopped")

    return watch


def refuse_versions(found: dict[str, dict[str, Any]]) -> None:
    """Refuses workers with another version of the program.

    Raises:
        InputError: There are some; the first is named.
    """
    for address, about in found.items():
        if about["version"] != VERSION:
            raise InputError(
                f"the worker {address} has barbule {about['version']}, and here is {VERSION}; install one version everywhere"
            )

