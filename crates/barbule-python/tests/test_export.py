"""Files for other programs: what is said of them, and what an independent reader makes of them."""

from __future__ import annotations

import json
from pathlib import Path

import barbule
import numpy as np
import pytest


def test_every_format_is_written_and_says_how_near_it_is(tmp_path: Path) -> None:
    starling = barbule.Material.load("starling")
    film = "air/keratin:595/air"
    for what, to, name, most in (
        (starling, "csv", "s.csv", None),
        (starling, "exr", "s.exr", None),
        ("starling", "osl", "s.osl", 0.4),
        (film, "gltf", "f.gltf", 0.3),
        (film, "openpbr", "f.mtlx", 0.2),
    ):
        written = barbule.export(what, to, tmp_path / name, progress=False)  # type: ignore[arg-type]
        assert Path(written["files"][0]) == tmp_path / name
        assert written["bytes"] == sum(Path(file).stat().st_size for file in written["files"])
        assert written["relative_l1"] is not None and written["bias"] is not None and written["delta_e"] is not None
        assert most is None or written["relative_l1"] < most
    assert json.loads((tmp_path / "f.gltf").read_text())["asset"]["version"] == "2.0"
    lines = [line for line in (tmp_path / "s.csv").read_text().splitlines() if not line.startswith("#")]
    values = dict(zip(lines[0].split(","), (float(cell) for cell in lines[500].split(","))))

    def direction(theta: float, phi: float) -> list[float]:
        theta, phi = np.radians([theta, phi])
        return [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]

    own = starling.eval(
        [500.0], direction(values["theta_i"], values["phi_i"]), direction(values["theta_s"], values["phi_s"])
    )
    assert abs(values["f_500"] - float(own[0])) < 1e-5 + 1e-4 * abs(float(own[0]))


def test_what_a_format_cannot_have_is_refused(tmp_path: Path) -> None:
    for what, to, end, word in (
        (barbule.Material.load("starling"), "gltf", "x.gltf", "is made of a stack"),
        (barbule.Scene.load("starling"), "bsdf", "x.bsdf", "is made of a material"),
        ("air/2*(keratin:100/air:100)/air", "openpbr", "x.mtlx", "layers"),
        ("starling", "bsfd", "x.bsdf", "bsdf"),
        ("starling", "pbrt", "x.obj", "end its name with .pbrt"),
    ):
        with pytest.raises(barbule.InputError, match=word):
            barbule.export(what, to, tmp_path / end, progress=False)  # type: ignore[arg-type]
    with pytest.raises(barbule.InputError, match="size_mb"):
        barbule.export("starling", "bsdf", tmp_path / "x.bsdf", size_mb=0.0)
    assert not list(tmp_path.iterdir())


def test_mitsuba_reads_what_was_said(tmp_path: Path) -> None:
    """`measured` evaluates the file as near to the material as `export` says, and samples as much light as it reflects."""
    mi = pytest.importorskip("mitsuba")
    path = tmp_path / "s.bsdf"
    said = barbule.export("starling", "bsdf", path, size_mb=5.0, progress=False)
    mi.set_variant("scalar_spectral")
    bsdf = mi.load_dict({"type": "measured", "filename": str(path)})
    starling = barbule.Material.load("starling", reciprocity="steeper")
    random = np.random.default_rng(2)
    nm = [433.0, 487.0, 541.0, 633.0]
    context, si = mi.BSDFContext(), mi.SurfaceInteraction3f()
    si.wavelengths = nm
    off, reflected, sampled, count = 0.0, 0.0, 0.0, 1500
    for _ in range(count):
        radius, turn = 0.9 * np.sqrt(random.random()), 2.0 * np.pi * random.random()
        wi = np.array([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1.0 - radius * radius)])
        si.wi = mi.Vector3f(wi[1], -wi[0], wi[2])
        wo, _ = starling.sample(541.0, wi, random.random(2))
        density = float(np.mean(starling.pdf(nm, wi, wo)))
        if density > 0.0 and wo[2] > 0.03:
            own = np.asarray(starling.eval(nm, wi, wo)) * wo[2]
            read = np.array(bsdf.eval(context, si, mi.Vector3f(wo[1], -wo[0], wo[2])))
            off += float(np.abs(read - own).sum()) / density
            reflected += float(own.sum()) / density
        _, weight = bsdf.sample(context, si, random.random(), mi.Point2f(random.random(2)))
        sampled += float(np.array(weight).sum())
    assert said["relative_l1"] is not None
    # 1500 pairs leave 1 % of noise in the one and 2 % in the other.
    assert off / reflected < said["relative_l1"] + 0.02
    assert abs(sampled / reflected - 1.0) < 0.06
