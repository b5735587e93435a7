"""The command line in the wheel, docstrings, and the package's own types."""

import doctest
import importlib
import pkgutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import barbule


def command(*words):
    return [sys.executable, "-m", "barbule", *words]


def test_the_command_comes_with_the_wheel(tmp_path):
    done = subprocess.run(command("film", "air/keratin:595/air", "--json"), capture_output=True, text=True)
    assert done.returncode == 0 and '"wavelength_nm"' in done.stdout
    refused = subprocess.run(command("render", "starlng", "-o", str(tmp_path / "a.png")), capture_output=True, text=True)
    assert refused.returncode == 2 and "did you mean" in refused.stderr and "Traceback" not in refused.stderr
    assert subprocess.run(command("--version"), capture_output=True, text=True).stdout.split()[-1] == barbule.__version__


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_stops_the_command_well(tmp_path):
    store = tmp_path / "s.zarr"
    running = subprocess.Popen(
        command("simulate", "starling", "-o", str(store), "--threads", "1"), stderr=subprocess.PIPE, text=True
    )
    for _ in range(600):
        if list(store.glob("digest/c.*")):
            break
        time.sleep(0.1)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert running.returncode == 130 and "units done; the same command goes on" in said, said


def modules():
    yield barbule
    for found in pkgutil.iter_modules(barbule.__path__):
        if found.name not in ("__main__", "_native", "_accessor", "mitsuba"):
            yield importlib.import_module(f"barbule.{found.name}")


def test_examples_of_docstrings_run():
    tried = 0
    for module in modules():
        found = doctest.testmod(module)
        assert found.failed == 0
        tried += found.attempted
    assert tried > 20


def test_all_that_is_public_is_documented():
    for name in barbule.__all__:
        documented = getattr(barbule, name).__doc__
        assert documented or name in ("species",), name


def test_the_package_is_typed():
    pytest.importorskip("mypy")
    package = Path(barbule.__file__).parent
    assert (package / "py.typed").is_file()
    found = subprocess.run([sys.executable, "-m", "mypy", "--strict", "-p", "barbule"], capture_output=True, text=True)
    assert found.returncode == 0, found.stdout


def test_memory_is_a_limit():
    """Too little is refused before any work, and enough gives the same bits as all."""
    small = {"wavelengths_nm": [500.0, 600.0], "directions": (2, 2), "instances": 2, "progress": False}
    with pytest.raises(barbule.InputError, match="memory"):
        barbule.characterize("starling", memory_bytes=1000, **small)
    assert barbule.characterize("starling", memory_bytes=1 << 30, **small).hash == barbule.characterize("starling", **small).hash
