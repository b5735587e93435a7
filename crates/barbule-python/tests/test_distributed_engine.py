"""What carries work to a cluster: tasks that fail, memory, and what workers hold."""

import dataclasses
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import pytest

import barbule
from barbule.distributed import _engine, _work

distributed = pytest.importorskip("distributed")


@dataclasses.dataclass(frozen=True)
class Failing:
    """Work whose tasks fail some times, each leaving a file for each attempt."""

    folder: Path
    #: By item: how often it fails, and with what.
    failures: tuple

    label = "failing"
    identity = "failing"

    def prepare(self, folder, slots):
        return self

    def run(self, item, threads, watch):
        attempts = len(list(self.folder.glob(f"{item}-*")))
        (self.folder / f"{item}-{attempts}").write_text("")
        times, error = self.failures[item]
        if attempts < times:
            raise error

    def close(self):
        pass


def test_failed_tasks_are_tried_again_and_what_is_wrong_is_raised_at_once(client, tmp_path):
    def attempts(name, failures, **how):
        folder = tmp_path / name
        folder.mkdir()
        tasks = [range(item, item + 1) for item in range(len(failures))]
        work = Failing(folder, tuple(failures))
        try:
            _engine.compute(work, tasks, _engine.asked(client), memory_bytes=1, progress=False, **how)
        finally:
            there = [path.name.split("-")[0] for path in folder.iterdir()]
            counts.append([there.count(str(item)) for item in range(len(failures))])

    counts = []
    attempts("again", [(0, None), (2, OSError("the disk is away")), (1, MemoryError())])
    assert counts.pop() == [1, 3, 2]
    with pytest.raises(barbule.MachineError, match="a task failed 2 times.*the disk is away"):
        attempts("often", [(9, OSError("the disk is away"))], retries=1)
    assert counts.pop() == [2]
    with pytest.raises(barbule.InputError, match="^no such bird$"):
        attempts("wrong", [(9, barbule.InputError("no such bird"))])
    assert counts.pop() == [1]


def test_workers_without_the_memory_are_refused_before_any_work(tmp_path):
    with (
        distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None, resources={"barbule-memory": 2e6}) as small,
        distributed.Client(small) as client,
    ):
        assert _engine.asked(client).declare_memory
        store = tmp_path / "s.zarr"
        with pytest.raises(barbule.InputError, match="of memory, and a worker has 2 MB; give fewer instances, or larger workers"):
            barbule.distributed.simulate("starling", store, client=client, thin=10, progress=False)
        assert not list(store.glob("digest/c.*"))
        # What is as large as the worker is sent, to one slot at a time.
        _engine.compute(Failing(tmp_path, ((0, None),)), [range(1)], _engine.asked(client), memory_bytes=2e6, progress=False)


def test_workers_begin_no_more_than_fits_their_memory():
    from barbule.distributed._worker import Budget, Stopped

    budget, most, at_once, lock = Budget(), [0], [0], threading.Lock()

    def task(bytes_):
        with budget.share(bytes_, 10.0, lambda *_: None):
            with lock:
                at_once[0] += bytes_
                most[0] = max(most[0], at_once[0])
            time.sleep(0.01)
            with lock:
                at_once[0] -= bytes_

    tasks = [threading.Thread(target=task, args=(4,)) for _ in range(8)]
    for each in tasks:
        each.start()
    for each in tasks:
        each.join()
    assert most[0] == 8

    def stopped(*_):
        raise Stopped

    with budget.share(8.0, 10.0, stopped), pytest.raises(Stopped), budget.share(8.0, 10.0, stopped):
        pass
    # More than there is, alone.
    task(20)


def test_workers_give_back_what_nobody_has_used_for_a_while(tmp_path, monkeypatch):
    from barbule.distributed import _worker

    class Opened:
        closed = 0

        def prepare(self, folder, slots):
            return self

        def close(self):
            self.closed += 1

    monkeypatch.setattr(_worker, "IDLE_S", 0.05)
    work = Opened()
    plugin = _worker.Preparation("idle", work)
    plugin.setup(types.SimpleNamespace(state=types.SimpleNamespace(nthreads=1), local_directory=tmp_path))
    for opened in (1, 2):
        with plugin.prepared() as prepared:
            assert prepared is work
            time.sleep(0.1)
            assert work.closed == opened - 1
        time.sleep(0.2)
        assert work.closed == opened
    plugin.teardown(None)
    assert work.closed == 2 and not list(tmp_path.iterdir())
    with pytest.raises(_worker.Stopped), plugin.prepared():
        pass


def test_a_worker_that_opens_another_structure_says_so(tmp_path):
    pink, green = (barbule.open(f"starling:{name}").hash for name in ("pink", "green"))
    assert _work.opened_alike("starling:pink", (), pink).hash == pink
    with pytest.raises(barbule.InputError, match="is another structure on this worker"):
        _work.opened_alike("starling:pink", (), green)
    file = tmp_path / "a.toml"
    file.write_text("")
    assert _work.placed(f"{file} (below)") == f"{file} (below)"
    assert _work.placed("air/keratin:300/air") == "air/keratin:300/air"


def test_without_dask_a_sentence_says_what_to_install(tmp_path):
    program = """
import sys
sys.modules["distributed"] = None
import barbule
try:
    barbule.distributed.characterize("starling", client=None, store="s.zarr")
except barbule.InputError as error:
    print(error)
"""
    found = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    assert "pip install 'barbule[distributed]'" in found.stdout, found.stderr
