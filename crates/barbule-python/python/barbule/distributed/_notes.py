"""Small files beside pictures, by which one that is there is known."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from pathlib import Path


def is_noted(path: Path, identity: str) -> bool:
    """Whether a picture is there, is whole, and is of this identity."""
    try:
        found = json.loads(_note_of(path).read_text(encoding="utf-8"))
        return bool(found == {"identity": identity, "picture": _sum(path)})
    except (OSError, ValueError):
        return False


def note(path: Path, identity: str) -> None:
    """Writes the note beside a picture, whole or not at all."""
    with tempfile.NamedTemporaryFile("w", dir=path.parent, prefix=".note-", delete=False, encoding="utf-8") as file:
        json.dump({"identity": identity, "picture": _sum(path)}, file)
    os.replace(file.name, _note_of(path))


def _note_of(path: Path) -> Path:
    return path.with_name(f".{path.name}.json")


def _sum(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
