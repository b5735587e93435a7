"""Work on a cluster of two processes: killed workers, stopped calls, damaged and remote stores, to the bits of one process."""

import dataclasses
import hashlib
import json
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import barbule
from barbule.distributed import _engine, _picture

pytest.importorskip("distributed")

BIRD = "starling:pink"
#: A hundred units, of few individuals: a second of work.
SMALL = {"wavelengths_nm": [450.0, 500.0, 550.0, 600.0, 650.0], "directions": (20, 2), "instances": 6}
#: Eight units, for stores whose files take longer than what is in them.
FEW = {"wavelengths_nm": [500.0, 600.0], "directions": (4, 2), "instances": 6}
#: So short that there are many tasks.
SHORT = 0.01


def by_one_process(folder, how):
    """The store of one process, and its material."""
    store = folder / "s.zarr"
    barbule.simulate(BIRD, store, **how, progress=False)
    return store, barbule.fit(store, progress=False)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return by_one_process(tmp_path_factory.mktemp("alone"), SMALL)


@pytest.fixture(scope="module")
def few_alone(tmp_path_factory):
    return by_one_process(tmp_path_factory.mktemp("few"), FEW)


def files(folder):
    """Every file of a folder, with a hash of its bytes."""
    found = (path for path in Path(folder).rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in found}


def kill(client, which=slice(None)):
    """Kills workers; what they had at work is lost with them."""
    for pid in sorted(client.run(os.getpid, on_error="ignore").values())[which]:
        os.kill(pid, signal.SIGKILL)


class Killer:
    """Progress that kills all workers when a task has ended, once."""

    def __init__(self, client, label="simulating"):
        self.client, self.label, self.has_killed = client, label, False

    def __call__(self, label, done, total):
        if label == self.label and not self.has_killed and done < total:
            self.has_killed = True
            kill(self.client)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_killed_workers_leave_the_bits_of_one_process(client, alone, tmp_path):
    store, killed = tmp_path / "s.zarr", []

    def kill_one_then_all():
        for which in (slice(1), slice(None)):
            while len(list(store.glob("digest/c.*"))) <= 20 * (len(killed) + 1):
                time.sleep(0.005)
            # Somewhere in its next units.
            time.sleep(random.uniform(0.0, 0.1))
            kill(client, which)
            killed.append(which)

    killer = threading.Thread(target=kill_one_then_all, daemon=True)
    killer.start()
    material = barbule.distributed.characterize(BIRD, client=client, store=store, **SMALL, unit_seconds=SHORT, progress=False)
    killer.join(timeout=5)
    assert len(killed) == 2
    client.wait_for_workers(2)
    assert len(list(store.glob("digest/c.*"))) >= 100
    assert files(store) == files(alone[0])
    assert material.hash == alone[1].hash
    # Again there is nothing to do.
    before = {path: path.stat().st_mtime_ns for path in store.rglob("*") if path.is_file()}
    barbule.distributed.simulate(BIRD, store, client=client, **SMALL, unit_seconds=SHORT, progress=False)
    assert before == {path: path.stat().st_mtime_ns for path in store.rglob("*") if path.is_file()}


class Enough(Exception):
    """What the caller raises to stop."""


def test_a_stopped_call_ends_on_the_workers_and_goes_on(client, alone, tmp_path):
    store = tmp_path / "s.zarr"

    def stop(label, done, total):
        if label == "simulating":
            raise Enough

    arguments = {"client": client, "store": store, "unit_seconds": SHORT, **SMALL}
    with pytest.raises(Enough):
        barbule.distributed.characterize(BIRD, progress=stop, **arguments)
    time.sleep(1.0)
    there = files(store)
    assert 0 < len(there) < len(files(alone[0]))
    time.sleep(1.0)
    assert files(store) == there and not any(client.processing().values())
    assert barbule.distributed.characterize(BIRD, progress=False, **arguments).hash == alone[1].hash
    assert files(store) == files(alone[0])


def damage(store):
    """Flips a bit of a chunk, and loses the end of another unit."""
    chunks = sorted(store.glob("u/c.*"))
    bytes_ = bytearray(chunks[0].read_bytes())
    bytes_[len(bytes_) // 2] ^= 1
    chunks[0].write_bytes(bytes_)
    sorted(store.glob("digest/c.*"))[-1].unlink()


def test_what_is_damaged_or_lost_is_computed_again(client, few_alone, tmp_path):
    store = tmp_path / "s.zarr"
    barbule.simulate(BIRD, store, **FEW, progress=False)
    damage(store)
    barbule.distributed.simulate(BIRD, store, client=client, **FEW, unit_seconds=SHORT, progress=False)
    assert files(store) == files(few_alone[0])


def test_a_store_elsewhere_has_the_same_files(client, few_alone, tmp_path):
    pytest.importorskip("fsspec")
    store = tmp_path / "far" / "s.zarr"
    arguments = {"client": client, "store": f"file://{store}", **FEW, "unit_seconds": SHORT, "progress": False}
    assert barbule.distributed.characterize(BIRD, **arguments).hash == few_alone[1].hash
    assert files(store) == files(few_alone[0])
    damage(store)
    assert barbule.distributed.characterize(BIRD, **arguments).hash == few_alone[1].hash
    assert files(store) == files(few_alone[0])
    with pytest.raises(barbule.InputError, match="other parameters"):
        barbule.distributed.characterize(BIRD, **(arguments | {"seed": 2}))


def test_a_halo_is_that_of_one_process(client, tmp_path):
    small = {"wavelengths_nm": [600.0], "directions": (2, 2), "instances": 2, "halo": True, "progress": False}
    film = "air/keratin:300±5%/melanin:300/air"
    made = barbule.distributed.characterize(film, client=client, store=tmp_path / "s.zarr", **small)
    assert made.hash == barbule.characterize(film, **small).hash
    with pytest.raises(barbule.InputError, match="a halo is kept in a folder"):
        barbule.distributed.characterize(film, client=client, store=f"file://{tmp_path}/t.zarr", **small)


@pytest.fixture
def bucket(monkeypatch):
    """A bucket of a server here that speaks S3, and how fsspec reaches it."""
    pytest.importorskip("moto")
    s3fs = pytest.importorskip("s3fs")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    url = f"http://127.0.0.1:{port}"
    server = subprocess.Popen(
        [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    options = {"key": "nobody", "secret": "nothing", "client_kwargs": {"endpoint_url": url, "region_name": "eu-central-1"}}
    try:
        for _ in range(300):
            try:
                socket.create_connection(("127.0.0.1", port), timeout=1).close()
                break
            except OSError:
                time.sleep(0.1)
        files_ = s3fs.S3FileSystem(**options)
        files_.mkdir("feathers")
        yield "s3://feathers", options, files_
    finally:
        server.terminate()
        server.wait(timeout=20)


def open_strictly(store, options):
    """The shapes of a store's arrays, opened by xarray where every warning is an error."""
    pytest.importorskip("xarray")
    program = """
import json, sys
import xarray
found = xarray.open_zarr(sys.argv[1], storage_options=json.loads(sys.argv[2]))
print(json.dumps({name: [*array.shape] for name, array in found.variables.items()}))
"""
    # Of what comes with the object store's own packages they are not.
    command = [sys.executable, "-W", "error", *(["-W", "ignore::DeprecationWarning:botocore"] if options else []), "-c", program]
    found = subprocess.run([*command, store, json.dumps(options)], capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    return json.loads(found.stdout)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_object_stores_hold_the_same_objects(client, few_alone, bucket, tmp_path):
    url, options, remote = bucket
    arguments = {"client": client, "store": f"{url}/s.zarr", "storage_options": options, **FEW, "unit_seconds": SHORT}
    material = barbule.distributed.characterize(BIRD, **arguments, progress=(killer := Killer(client)))
    assert killer.has_killed and material.hash == few_alone[1].hash
    objects = remote.cat(remote.find("feathers/s.zarr"))
    hashes = {path.removeprefix("feathers/s.zarr/"): hashlib.sha256(bytes_).hexdigest() for path, bytes_ in objects.items()}
    assert hashes == files(few_alone[0])
    there, here = open_strictly(f"{url}/s.zarr", options), open_strictly(str(few_alone[0]), None)
    assert there == here and there["u"] == [2, 4, 2, 2, 400]
    birds = barbule.distributed.spectrum(
        ["air/keratin:300±5%/air", "air/keratin:200/air"], [500, 600], client=client, store=f"{url}/spectra.zarr", storage_options=options, instances=2,
        progress=False,
    )
    assert np.isfinite(birds["reflectance"].values).all()


def test_a_sweep_of_spectra_is_that_of_each(client, tmp_path):
    pytest.importorskip("xarray")
    names = ["starling:pink", "starling:green", "air/keratin:300±5%/air", "mallard"]
    how = {"instances": 3, "seed": 2}
    arguments = {"client": client, "store": tmp_path / "s.zarr", **how, "unit_seconds": 0.01, "progress": False}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = barbule.distributed.spectrum(names, [450, 550, 650], [0, 40], **arguments)
    for number, name in enumerate(names):
        one = barbule.spectrum(name, [450, 550, 650], [0, 40], **how, progress=False)
        assert np.array_equal(found["reflectance"][number], one["reflectance"])
        assert np.array_equal(found["std"][number], one["std"])
    assert found["wavelength"].attrs["units"] == "nm" and "done" not in found
    before = files(tmp_path / "s.zarr")
    barbule.distributed.spectrum(names, [450, 550, 650], [0, 40], **arguments)
    assert files(tmp_path / "s.zarr") == before
    with pytest.raises(barbule.InputError, match="was made with another 'structures'"):
        barbule.distributed.spectrum(names[:2], [450, 550, 650], [0, 40], **arguments)


def test_far_fields_and_crystals_are_those_of_one_process(client, tmp_path):
    pytest.importorskip("xarray")
    how = {"solver": "full-wave", "azimuths": 60, "elements_per_wavelength": 4.0, "memory_bytes": 1 << 29}
    thin = "air/keratin:300±5%/air"
    found = barbule.distributed.far_fields(
        thin, [600, 650], 0, [0, 20], client=client, store=tmp_path / "f.zarr", instances=2, **how, progress=False
    )
    section = barbule.open(thin).instance(1, 1)
    one = barbule.far_fields(section, [650], 0, [0, 20], **how, progress=False)
    assert np.array_equal(found["intensity"][1, 1], one["intensity"][0])
    assert np.array_equal(found["amplitude"][1, 1], one["amplitude"][0])
    assert np.allclose(found["phi_o"], one["phi_o"], atol=1e-12, rtol=0)
    crystal = barbule.distributed.crystal(
        "mallard:blue", [450, 500], [0, 30], client=client, store=tmp_path / "c.zarr", progress=False
    )
    alike = barbule.crystal("mallard:blue", [450, 500], [0, 30], progress=False)
    assert np.array_equal(crystal["R"].transpose("phi_i", "wavelength", "polarization"), alike["R"])


PLAN = """barbule = 1
name = "films"
structure = "starling"
wavelengths_nm = "400:700:50"
individuals = 2
unit_cells = 2

[[vary]]
key = "cortex_um"
values = "0.25:0.45:0.02"
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_an_atlas_is_that_of_one_process(client, tmp_path):
    plan, store = tmp_path / "plan.toml", tmp_path / "s.zarr"
    plan.write_text(PLAN)
    barbule.atlas(plan, tmp_path / "one.zarr", progress=False)
    killer, seen = Killer(client), []

    def progress(*step):
        seen.append(any((store / ".aside").glob("run-0-1-*")))
        killer(*step)

    arguments = {"client": client, "unit_seconds": 0.01}
    barbule.distributed.atlas(plan, store, progress=progress, **arguments)
    assert killer.has_killed and any(seen)
    assert files(store) == files(tmp_path / "one.zarr")
    sorted(store.glob("mean/c.*"))[0].write_bytes(b"half")
    barbule.distributed.atlas(plan, store, progress=False, **arguments)
    assert files(store) == files(tmp_path / "one.zarr")
    plan.write_text(PLAN.replace("individuals = 2", "individuals = 3"))
    for refused, sentence in [(store, "made by another plan"), ("s3://bucket/s.zarr", "a folder that all workers see")]:
        with pytest.raises(barbule.InputError, match=sentence):
            barbule.distributed.atlas(plan, refused, progress=False, **arguments)


def timeless(value):
    """Numbers without how long they took, and what made them."""
    if isinstance(value, dict):
        return {key: timeless(one) for key, one in value.items() if not key.endswith(("seconds", "speed_ratio", "made"))}
    return [timeless(one) for one in value] if isinstance(value, list) else value


FILM = "air/keratin:400±10%/air"
COMPARISONS = {
    "full-wave": {"wavelengths_nm": [600, 650], "phi_deg": [0], "elements_per_wavelength": 4.0, "individuals": 2},
    "three-d": {"wavelengths_nm": [600], "instances": 2, "length_um": 6.0},
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("against", COMPARISONS)
def test_comparisons_are_those_of_one_process(client, tmp_path, against):
    options = COMPARISONS[against]
    one = barbule.validate(FILM, tmp_path / "one", against, **options, progress=False)
    killer = Killer(client, {"full-wave": "full waves", "three-d": "segments"}[against])
    arguments = {"client": client, "unit_seconds": 1e-6, **options}
    several = barbule.distributed.validate(FILM, tmp_path / "several", against, **arguments, progress=killer)
    assert killer.has_killed
    assert timeless(several) == timeless(one)
    names = [{path.name for path in (tmp_path / name).rglob("*")} for name in ("one", "several")]
    assert names[0] == names[1] and {"units", "numbers.json"} < names[0]
    # Nothing is left to do, here or there.
    again = barbule.distributed.validate(FILM, tmp_path / "one", against, **arguments, progress=False)
    key = {"full-wave": "incidences", "three-d": "directions"}[against]
    assert again[key] == one[key]


def test_what_cannot_be_compared_is_refused(client, tmp_path):
    for options, sentence in [
        ({"against": "measured"}, "'against' is 'measured'"),
        ({"instances": 3}, "'instances' is for segments"),
        ({"against": "three-d", "phi_deg": [0]}, "'phi_deg' is for full waves"),
        ({"individuals": 0}, "0 individuals are to be compared"),
        ({"width_um": 6.0}, "'width_um' and 'layers' change species"),
        ({"against": "three-d", "length_um": 0.1}, "'length_um' is 0.1"),
        ({"phi_deg": [80]}, "'phi_deg': φ_i = 80°"),
    ]:
        for call, more in [(barbule.validate, {}), (barbule.distributed.validate, {"client": client})]:
            with pytest.raises(barbule.InputError, match=sentence):
                call(FILM, tmp_path / "v", **options, **more, progress=False)
    with pytest.raises(TypeError, match="unexpected keyword argument 'phi'"):
        barbule.validate(FILM, tmp_path / "v", phi=[0], progress=False)
    with pytest.raises(barbule.InputError, match="MB"):
        barbule.validate(FILM, tmp_path / "v", memory_bytes=1000, **COMPARISONS["full-wave"], progress=False)
    assert not (tmp_path / "v").exists()


def test_tasks_hold_missing_units_that_take_long_enough():
    from barbule.distributed._validate import _tasks

    assert _tasks([0, 1, 2, 5, 6], [1.0] * 9, 2.0) == [range(0, 2), range(2, 6), range(6, 7)]
    assert _tasks([3], [0.1] * 4, 2.0) == [range(3, 4)]
    assert _tasks([0, 1, 2], [5.0, 5.0, 5.0], 4.0) == [range(0, 1), range(1, 2), range(2, 3)]


def test_frames_are_the_pictures_of_one_process(client, tmp_path):
    frames = barbule.Scene.load("starling").frames(3, {"light": 40})
    arguments = {"client": client, "size": (24, 16), "samples": 1, "memory_bytes": 1 << 29, "progress": False}
    made = barbule.distributed.render_frames(frames, tmp_path / "F.png", **arguments)
    assert [path.name for path in made] == ["F-0000.png", "F-0001.png", "F-0002.png"]
    for frame, path in zip(frames, made):
        frame.render((24, 16), 1, progress=False).save(tmp_path / "one.png")
        assert (tmp_path / "one.png").read_bytes() == path.read_bytes()
    times = [path.stat().st_mtime_ns for path in made]
    made[1].write_bytes(b"half")
    again = barbule.distributed.render_frames(frames, tmp_path / "F.png", **arguments)
    assert [path.stat().st_mtime_ns == before for path, before in zip(again, times)] == [True, False, True]
    other = barbule.distributed.render_frames(frames[:1], tmp_path / "F.png", **(arguments | {"seed": 2}))
    assert other[0].stat().st_mtime_ns != times[0]


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_picture_in_parts_is_that_of_one_process(client, tmp_path):
    # Exposed by what the whole picture shows.
    scene = barbule.Scene.parse('preset = "starling"\nexposure = "auto"\n')
    how = {"size": (90, 60), "samples": 8, "spectral_nm": [500, 600], "compositing": True}
    arguments = {"client": client, "memory_bytes": 1 << 29, **how}
    scene.render(**how, progress=False).save(tmp_path / "one.exr")
    killer = Killer(client, "tiles")
    made = barbule.distributed.render(scene, tmp_path / "F.exr", tiles=1, unit_seconds=0.01, progress=killer, **arguments)
    assert killer.has_killed and made == tmp_path / "F.exr"
    assert made.read_bytes() == (tmp_path / "one.exr").read_bytes()
    # The parts are gone, and the picture is not rendered again.
    assert sorted(path.name for path in tmp_path.iterdir()) == [".F.exr.json", "F.exr", "one.exr"]
    time_ = made.stat().st_mtime_ns
    barbule.distributed.render(scene, made, tiles=2, progress=False, **arguments)
    assert made.stat().st_mtime_ns == time_
    # What is damaged is rendered again, in parts that are there already.
    made.write_bytes(b"half")
    for number, bytes_ in [(0, b""), (2, b"BARBFILM and more")]:
        (tmp_path / f"F.exr.part-{number}-of-3").write_bytes(bytes_)
    barbule.distributed.render(scene, made, tiles=2, progress=False, **arguments)
    assert made.read_bytes() == (tmp_path / "one.exr").read_bytes()
    assert len(list(tmp_path.iterdir())) == 3


def test_pictures_that_cannot_be_made_are_refused_before_any_work(client, tmp_path):
    for arguments, sentence in [
        ({"output": tmp_path / "no" / "F.png"}, "in a folder that is there"),
        ({"tiles": 0}, "'tiles' is 0; give a number from 1 to 2"),
        ({"noise": 2.0}, "'noise' is 2"),
        ({"scene": "starlign"}, "did you mean 'starling'"),
        ({"denoise": tmp_path / "none.so"}, "none.so"),
    ]:
        whole = {"scene": "starling", "output": tmp_path / "F.png", "size": (40, 20), "client": client, "progress": False}
        with pytest.raises(barbule.InputError, match=sentence):
            barbule.distributed.render(**(whole | arguments))
    work = _picture.PictureWork(
        scene=("starling", None), output=str(tmp_path / "F.png"), media=(), cache=None, size=(40, 20), samples=1, noise=None, quality=None,
        seed=1, spectral_nm=(), compositing=False, tone=None, white_balance=None, tiles=None, name="another",
    )
    with pytest.raises(barbule.InputError, match="is another one on this worker"):
        work.prepare(tmp_path, 1)
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_done_is_refused_before_any_work(client, tmp_path):
    run = barbule.distributed.characterize
    for arguments, sentence in [
        ({"client": "tcp://nowhere"}, "give a distributed.Client"),
        ({"unit_seconds": 0.0}, "units of 0 s cannot be made"),
        ({"simd": "mmx"}, "which not all workers and this process have"),
        ({"threads": 0}, "'threads' is 0"),
        ({"storage_options": {"key": object()}}, "cannot be sent to workers"),
        ({"sigma": 7.0}, "7"),
    ]:
        with pytest.raises(barbule.InputError, match=sentence):
            run(BIRD, **({"client": client, "store": tmp_path / "s.zarr", **SMALL, "progress": False} | arguments))
    poor = dataclasses.replace(_engine.asked(client), memory_bytes=1e6)
    with pytest.raises(barbule.InputError, match="a worker has 1 MB"):
        _engine.compute(None, [range(1)], poor, memory_bytes=2e6)


def test_the_status_of_a_store_names_the_workers_that_fill_it(client, tmp_path):
    seen = []

    def look(label, done, total):
        if label == "simulating" and 0 < done < total and not seen:
            command = [sys.executable, "-m", "barbule", "simulate", str(store), "--status", "--json"]
            seen.extend(json.loads(subprocess.run(command, capture_output=True, check=True).stdout)["running"])

    store = tmp_path / "many.zarr"
    barbule.distributed.simulate(BIRD, store, client=client, **SMALL, unit_seconds=SHORT, progress=look)
    workers = set(client.run(os.getpid).values())
    assert seen and {run["process"] for run in seen} <= workers
    seen.clear()
    store = tmp_path / "one.zarr"

    def look_once(label, done, total):
        look(label, done, total)
        if seen:
            raise Enough

    # It goes on while it is looked at.
    with pytest.raises(Enough):
        barbule.simulate(BIRD, store, **(SMALL | {"instances": 60}), shard=(1, 2), progress=look_once, threads=1)
    assert [(run["process"], run["shard"], run["shards"]) for run in seen] == [(os.getpid(), 1, 2)]
    assert not list(tmp_path.glob("*/.aside"))
