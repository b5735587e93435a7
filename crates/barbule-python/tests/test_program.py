"""The command line in the wheel, docstrings, and the package's own types."""

import ast
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


def examples():
    """All examples of docstrings, each once: those of public names, of the modules' other names, and of methods."""
    found = {}
    for module in modules():
        for test in doctest.DocTestFinder().find(module):
            if test.examples:
                found[test.docstring] = test
    for name in barbule.__all__:
        test = doctest.DocTestParser().get_doctest(getattr(barbule, name).__doc__, {}, name, None, None)
        found.setdefault(test.docstring, test)
    return list(found.values())


@pytest.mark.parametrize("test", examples(), ids=lambda test: test.name)
def test_examples_of_docstrings_run(test):
    if "from distributed import" in test.docstring:
        pytest.importorskip("distributed")
    assert doctest.DocTestRunner().run(test).failed == 0


@pytest.mark.parametrize("name", barbule.__all__)
def test_each_public_name_has_an_example(name):
    found = doctest.DocTestParser().get_examples(getattr(barbule, name).__doc__)
    assert any(name in example.source for example in found)
    assert not any(example.options.get(doctest.SKIP) for example in found)


def test_types_of_the_native_module_show_the_same_examples():
    written = ast.parse((Path(barbule.__file__).parent / "_native.pyi").read_text(encoding="utf-8"))
    shown = {node.name: ast.get_docstring(node) for node in written.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    sources = lambda text: [(example.source, example.want) for example in doctest.DocTestParser().get_examples(text)]
    for name in ("Picture", "Section", "Structure", "species"):
        assert sources(shown[name]) == sources(getattr(barbule, name).__doc__), name


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
