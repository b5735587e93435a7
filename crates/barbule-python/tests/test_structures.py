"""Structures, sections and errors."""

import json

import numpy as np
import pytest

import barbule


def test_individuals_are_the_same_everywhere(tmp_path):
    starling = barbule.open("starling:pink")
    one, again = starling.instance(3, seed=5), barbule.open("starling:pink").instance(3, seed=5)
    assert one.json() == again.json() != starling.instance(4, seed=5).json()
    one.save(tmp_path / "section.json")
    assert barbule.open(tmp_path / "section.json").instance(0).json() == one.json()
    assert json.loads(one.json())["name"] == one.name and one.width_um == 25.0


def test_sections_are_arrays():
    section = barbule.open("starling").instance(0)
    x, z = section.boundaries[0]
    assert x.shape == z.shape and x.min() == pytest.approx(-12.5) and len(section.media) == len(section.boundaries) + 1
    above, inside = section.media_at([0.0, 0.0], [3.0, float(np.interp(0.0, x, z)) - 0.05])
    assert (above, inside) == ("air", "keratin")
    bubbles = barbule.open("hummingbird").instance(0).inclusions
    assert len(bubbles) > 100 and bubbles[0]["outline"][0].ndim == 1


def test_lower_sides_and_crystals():
    assert barbule.open("mallard (below)").is_lower_side
    assert barbule.open("mallard").underside().name == barbule.open("mallard (below)").name
    assert barbule.open("mallard").count is None and barbule.open("air/keratin:300/air").count == 1
    assert "pink" in barbule.species()["starling"]


def test_notebooks_have_pictures():
    assert barbule.open("starling")._repr_svg_().startswith("<svg")
    assert barbule.open("starling").instance(0).figure("png")[:4] == b"\x89PNG"
    assert "rgb" in barbule.Material.load("starling")._repr_html_()
    assert barbule.render("starling", size=(8, 6), samples=1)._repr_png_()[:4] == b"\x89PNG"


def test_errors_say_what_where_and_what_to_do(tmp_path):
    with pytest.raises(barbule.InputError, match="did you mean 'starling'"):
        barbule.open("starlng")
    scene = tmp_path / "mine.toml"
    scene.write_text('preset = "starling"\n[camera]\nwidth_mm = -1\n')
    with pytest.raises(barbule.InputError) as caught:
        barbule.Scene.load(scene)
    assert isinstance(caught.value, ValueError)
    assert caught.value.file == str(scene) and caught.value.key == "camera.width_mm" and "width_mm" in str(caught.value)
    broken = tmp_path / "broken.toml"
    broken.write_text('preset = "starling"\n[camera\n')
    with pytest.raises(barbule.InputError) as caught:
        barbule.Scene.load(broken)
    assert caught.value.line == 2
    with pytest.raises(barbule.InputError, match="threads"):
        barbule.film("air/keratin:300/air", threads=0)
    with pytest.raises(barbule.InputError, match="at or past grazing"):
        barbule.film("air/keratin:300/air", angles_deg=[90])


def test_own_media(tmp_path):
    table = tmp_path / "resin.csv"
    table.write_text("300,1.6,0.01\n830,1.5,0\n")
    found = barbule.film("air/resin:320/air", [550.0], media={"resin": table})
    assert 0 < float(np.asarray(found["A_s"])[0, 0]) < 0.1


def test_what_is_open_is_no_name():
    starling, material = barbule.open("starling"), barbule.Material.load("starling")
    scene = barbule.Scene.load("starling")
    for call, said in (
        (lambda: barbule.open(starling), "'name' is a Structure"),
        (lambda: barbule.film(starling), "'stack' is a Structure"),
        (lambda: barbule.crystal(starling), "'lattice' is a Structure"),
        (lambda: barbule.see([starling], "starling"), "'things' is a Structure"),
        (lambda: barbule.vision.sensitivities(None), "'bird' is None"),
        (lambda: barbule.Scene.load(material), "'name' is a Material"),
        (lambda: scene.with_material(material), "'name' is a Material"),
        (lambda: barbule.intervals(starling), "'structure' is a Structure"),
        (lambda: barbule.export(starling, "gltf", "x.gltf"), "'what' is a Structure"),
        (lambda: barbule.spectrum(scene), "'structure' is a Scene"),
    ):
        with pytest.raises(TypeError, match=f"{said}; give its name or a file"):
            call()


def test_files_written_by_python_say_their_version(tmp_path):
    picture = barbule.render("starling", size=(8, 6), samples=1)
    picture.save(tmp_path / "a.png")
    picture.save(tmp_path / "a.exr")
    png, exr = (tmp_path / "a.png").read_bytes(), (tmp_path / "a.exr").read_bytes()
    assert b"iTXtversion\0" in png
    assert b"barbule_version\0" in exr and b"barbule_barbule_version" not in exr
