"""Micrographs, traced."""

import numpy as np
import pytest

import barbule


def rods() -> np.ndarray:
    """Discs of 40 px in a square lattice of 60 px, dark on grey."""
    y, x = np.mgrid[0:300, 0:380]
    u, v = (x - 10) % 60 - 30, y % 60 - 30
    rng = np.random.default_rng(1)
    return np.where(u * u + v * v < 400, 0.2, 0.6) * (1 - 0.2 * x / 380) + rng.normal(0, 0.01, y.shape)


def test_a_lattice_is_traced_from_an_array_and_from_a_file(tmp_path):
    found = barbule.trace(rods(), nm_per_px=2.5, cortex_nm=200)
    lattice = found.measures["lattice"]
    assert lattice["period_nm"]["mean"] == pytest.approx(150, rel=2e-3)
    assert lattice["diameter_nm"]["mean"] == pytest.approx(100, rel=1e-2) and lattice["hollow_nm"]["mean"] == 0
    assert found.rods_px.shape == (30, 4) and found.flat.shape == (300, 380)
    found.save(tmp_path / "rods.toml")
    assert barbule.open(tmp_path / "rods.toml").name
    for refused in (lambda: found.text("yaml"), lambda: found.save(tmp_path / "rods.yaml")):
        with pytest.raises(barbule.InputError, match="toml"):
            refused()
    assert 0 < float(barbule.crystal(tmp_path / "rods.toml", [500.0], [0.0])["reflectance"][0, 0]) < 1
    assert found.figure("png")[:4] == b"\x89PNG" and found._repr_svg_().startswith("<svg")
    whole = barbule.trace((rods().clip(0, 1) * 65535).astype(np.uint16), nm_per_px=2.5).measures["lattice"]
    assert whole["period_nm"]["mean"] == pytest.approx(lattice["period_nm"]["mean"], rel=1e-3)


def test_what_cannot_be_traced_is_refused_in_words(tmp_path):
    for image, options, words in [
        (np.zeros((200, 200)), {}, "no two classes"),
        (np.zeros((200, 20)), {}, "at least 32"),
        (np.zeros((200, 200, 3)), {}, "3 axes"),
        ((255 * rods()).astype(int), {}, "'image' holds int64; give uint8, uint16, or numbers from 0 to 1"),
        (255 * rods(), {}, "'image' holds .*; give numbers from 0 to 1, or uint8"),
        (tmp_path / "none.png", {}, "no such file"),
        (rods(), {"kind": "crystal"}, "'kind' is 'crystal'"),
        (rods(), {"kind": "layers"}, "no layers"),
        (rods(), {"thresholds": [50, 90]}, "'thresholds'"),
        (rods(), {"crop": (0, 0, 900, 10)}, "'crop'"),
    ]:
        with pytest.raises(barbule.InputError, match=words):
            barbule.trace(image, nm_per_px=1.0, **options)
