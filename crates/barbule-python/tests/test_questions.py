"""The Python of the pages of questions, and of the page that shows all interfaces, runs as it is written."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGES = [ROOT / "docs/api.md", *sorted((ROOT / "docs/guide/questions").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_python_of_a_page_runs(page, tmp_path):
    os.symlink(ROOT / "examples", tmp_path / "examples")
    blocks = re.findall(rf"```python {page.stem}\.py\n(.*?)```", page.read_text(encoding="utf-8"), re.S)
    assert len(blocks) == 1, "a page has one program, called as the page is"
    found = subprocess.run([sys.executable, "-c", blocks[0]], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert found.returncode == 0, found.stderr
    assert found.stdout.strip(), "it says something"
