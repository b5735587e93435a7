"""The tutorials run, a strict type checker accepts them, and the book shows them as they are."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

TUTORIALS = sorted((Path(__file__).parents[3] / "docs/tutorials").glob("*.ipynb"))


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_tutorials_run(path, tmp_path):
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "tutorials are kept without outputs"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    shown = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in data or "image/svg+xml" in data for data in shown) >= 3


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_pages_of_tutorials_have_their_text_and_code(path):
    """`scripts/tutorials` has written them since the notebooks were edited."""
    nbformat = pytest.importorskip("nbformat")
    page = path.with_suffix(".md").read_text(encoding="utf-8")
    cells = nbformat.read(path, as_version=4).cells
    assert re.findall(r"```python\n(.*?)\n```", page, re.S) == [cell.source for cell in cells if cell.cell_type == "code"]
    for cell in cells:
        if cell.cell_type == "markdown":
            assert all(part in page for part in cell.source.split("\n\n")), cell.source
    pictures = re.findall(r"\]\(\.\./figures/tutorials/(.*?)\)", page)
    kept = (path.parents[1] / "figures/tutorials").glob(f"{path.stem}-*")
    assert sorted(pictures) == sorted(file.name for file in kept)


def test_tutorials_have_types(tmp_path):
    pytest.importorskip("mypy")
    nbformat = pytest.importorskip("nbformat")
    for path in TUTORIALS:
        cells = [cell.source for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]
        (tmp_path / f"{path.stem}_.py").write_text("\n\n".join(cells))
    files = sorted(str(path) for path in tmp_path.glob("*.py"))
    found = subprocess.run([sys.executable, "-m", "mypy", "--strict", *files], cwd=tmp_path, capture_output=True, text=True)
    assert found.returncode == 0, found.stdout
