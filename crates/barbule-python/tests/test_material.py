"""Materials: batches, samples, tables, making them, and pictures."""

import json
import threading
from pathlib import Path

import numpy as np
import pytest

import barbule

NM = [450.0, 500.0, 550.0, 600.0, 650.0]


def directions(count, seed=1):
    """Unit vectors over the hemisphere, cosine-weighted."""
    random = np.random.default_rng(seed)
    radius, turn = np.sqrt(random.random(count)), 2 * np.pi * random.random(count)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], axis=-1)


@pytest.fixture(scope="module")
def starling():
    return barbule.Material.load("starling")


def test_batches_are_broadcast(starling):
    wi, wo = directions(5, 1), directions(7, 2)
    whole = starling.eval(NM, wi[:, None, :], wo, instance=np.arange(5)[:, None])
    assert whole.shape == (5, 7, 5) and whole.dtype == np.float32
    for i in range(5):
        for k in range(7):
            np.testing.assert_array_equal(whole[i, k], starling.eval(NM, wi[i], wo[k], instance=i))
    assert starling.eval(550, wi[0], wo[0]).shape == ()
    assert starling.eval(550, wi, wo[0], threads=1).shape == (5,)
    own = np.array([NM, NM[::-1]])
    np.testing.assert_allclose(
        starling.eval(own, wi[0], wo[0])[1], starling.eval(NM, wi[0], wo[0])[::-1], rtol=1e-6
    )


def test_types_and_strides_do_not_matter(starling):
    wi, wo = directions(64, 3), directions(64, 4)
    usual = starling.eval(NM, wi, wo)
    np.testing.assert_array_equal(usual, starling.eval(NM, np.asfortranarray(wi), np.repeat(wo, 2, axis=0)[::2]))
    single = starling.eval(np.float32(NM), wi.astype(np.float32), wo.astype(np.float32))
    np.testing.assert_allclose(single, usual, rtol=1e-3, atol=1e-4)
    np.testing.assert_array_equal(usual, starling.eval(NM, wi, wo, threads=1))


def test_bad_arguments_are_refused(starling):
    with pytest.raises(barbule.InputError, match="'wi' in row 1 .* unit vectors"):
        starling.eval(550, [[0, 0, 1], [0, 0, 2]], [0, 0, 1])
    with pytest.raises(barbule.InputError, match="'wi' in row 0 .* unit vectors"):
        starling.eval(550, [np.nan, 0, 1], [0, 0, 1])
    for bad, said in (([], "is empty"), ([np.nan], "holds NaN"), ([-5.0], "holds -5"), ([0.55], "holds 0.55; give 300 to 830 nm")):
        with pytest.raises(barbule.InputError, match=said):
            starling.eval(bad, [0, 0, 1], [0, 0, 1])
    for bad in (np.nan, -5.0, 0.55):
        for asked in (lambda nm: starling.albedo(nm, [0, 0, 1]), lambda nm: starling.sample(nm, [0, 0, 1], [0.5, 0.5])):
            with pytest.raises(barbule.InputError, match="'wavelength_nm' holds .*; give 300 to 830 nm"):
                asked(bad)
    assert starling.eval([550], np.zeros((0, 3)), [0, 0, 1]).shape == (0, 1)
    with pytest.raises(barbule.InputError, match="'samples' is 0"):
        barbule.render("starling", size=(8, 6), samples=0)
    with pytest.raises(ValueError, match="last axis"):
        starling.eval(550, [0, 1], [0, 0, 1])
    with pytest.raises(TypeError, match="whole numbers"):
        starling.eval(550, [0, 0, 1], [0, 0, 1], instance=1.5)
    with pytest.raises(ValueError, match="0 or more"):
        starling.eval(550, [0, 0, 1], [0, 0, 1], instance=-1)
    assert float(starling.eval(550, [0, 0, 1], [0, 0, -1])) == 0.0


def test_places_of_an_arch_have_the_whole_for_their_mean(starling):
    dove = barbule.Material.load("rock-dove")
    wi, wo = [0, 0, 1], [np.sin(0.4), 0, np.cos(0.4)]
    whole = dove.eval(NM, wi, wo, instance=[3, 4])
    places = (np.arange(40) + 0.5) / 20 - 1
    each = np.array([dove.eval(NM, wi, wo, instance=[3, 4], place=x) for x in places])
    np.testing.assert_allclose(each.mean(0), whole, rtol=2e-3)
    # Half-way between both directions normals lean towards +x.
    assert places[each[:, 0, 0].argmax()] > 0.3 and each.max() > 1.5 * whole.max()
    np.testing.assert_array_equal(starling.eval(NM, wi, wo, place=-1), starling.eval(NM, wi, wo))
    for bad in (1.1, np.nan):
        with pytest.raises(barbule.InputError, match="'place' is .*; give a number from -1 to 1"):
            dove.eval(NM, wi, wo, place=bad)


def test_samples_follow_their_density_and_carry_the_albedo(starling):
    """∫ f cosθ dω by samples is the albedo; ∫ pdf dω over the hemisphere is 1."""
    random = np.random.default_rng(5)
    wi = np.array([0.2, 0.1, np.sqrt(1 - 0.05)])
    wo, density = starling.sample(550, wi, random.random((100_000, 2)))
    np.testing.assert_allclose(density, starling.pdf(550, wi, wo), rtol=1e-9)
    albedo = float((starling.eval(550, wi, wo) * wo[:, 2] / density).mean())
    assert albedo == pytest.approx(float(starling.albedo(550, wi)), rel=5e-3)
    everywhere = directions(400_000, 6)
    assert float((starling.pdf(550, wi, everywhere) * np.pi / everywhere[:, 2]).mean()) == pytest.approx(1.0, abs=0.02)


def test_tables_are_the_materials_own_memory(starling):
    tables, header = starling.tables(), starling.header()
    assert header["version"] == 3 and tables["nodes"].shape == (header["thetas"], header["phis"], header["waves"], 16)
    again = starling.tables()["nodes"]
    assert tables["nodes"].__array_interface__["data"][0] == again.__array_interface__["data"][0]
    with pytest.raises(ValueError, match="read-only"):
        tables["nodes"][0, 0, 0, 0] = 1.0
    np.testing.assert_array_equal(tables["wavelengths_nm"], starling.wavelengths_nm)
    kept = barbule.Material.load("starling").tables()["codes"]
    assert int(np.abs(kept).max()) > 1000  # its owner is gone by now


def test_a_material_is_made_saved_and_opened(tmp_path):
    made = barbule.characterize("starling:pink", thin=10, cache=tmp_path)
    made.save(tmp_path / "pink.barbule")
    opened = barbule.open(tmp_path / "pink.barbule")
    assert isinstance(opened, barbule.Material) and opened.hash == made.hash
    np.testing.assert_array_equal(opened.eval(NM, [0, 0, 1], [0, 0, 1]), made.eval(NM, [0, 0, 1], [0, 0, 1]))
    assert made.info["name"] == "starling:pink" and made.source == "memory"
    with pytest.raises(barbule.InputError, match="not there yet"):
        barbule.Material.load("air/keratin:320/air", may_compute=False, cache=tmp_path)


def test_a_campaign_stops_and_goes_on_to_the_same_bits(tmp_path):
    seen = []

    def stop(label, done, total):
        seen.append((label, done, total))
        if label == "simulating" and done > total // 4:
            raise KeyboardInterrupt

    options = dict(thin=3, instances=10, seed=3)
    with pytest.raises(KeyboardInterrupt):
        barbule.simulate("starling", tmp_path / "s.zarr", **options, progress=stop, threads=1)
    computed, found = barbule.simulate("starling", tmp_path / "s.zarr", **options)
    assert computed > 0 and found > 0 and seen
    whole = barbule.characterize("starling", **options, cache=tmp_path)
    assert barbule.fit(tmp_path / "s.zarr").to_bytes() == whole.to_bytes()
    assert barbule.simulate("starling", tmp_path / "s.zarr", **options) == (0, computed + found)


def test_stores_open_in_xarray_without_warnings(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    import warnings

    barbule.simulate("starling", tmp_path / "s.zarr", thin=10)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        store = xarray.open_zarr(tmp_path / "s.zarr")
    assert store["wavelength"].attrs["units"] == "nm" and store.sizes["wavelength"] == 6


def test_long_work_lets_other_threads_run():
    turns, done = 0, threading.Event()

    def spin():
        nonlocal turns
        while not done.is_set():
            turns += 1

    other = threading.Thread(target=spin)
    other.start()
    barbule.spectrum("starling", range(400, 701, 25), [0, 30, 60], instances=20, progress=False)
    done.set()
    other.join()
    assert turns > 10_000


def test_pictures_are_arrays(tmp_path):
    picture = barbule.render("starling", size=(24, 16), samples=2, spectral_nm=[450, 550, 650], compositing=True)
    planes = picture.planes()
    assert picture.rgb().shape == (16, 24, 3) and planes["spectrum"].shape == (16, 24, 3)
    assert planes["albedo"].shape == (16, 24, 3) and np.isfinite(planes["depth_mm"][planes["id"] > 0]).all()
    again = barbule.render("starling", size=(24, 16), samples=2, threads=1)
    np.testing.assert_array_equal(picture.rgb(), again.rgb())
    picture.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    other = barbule.Scene.parse('preset = "starling"\n[camera]\nwidth_mm = 0.8\n').with_material("starling:green")
    assert other.render(size=(8, 6), samples=1).shape == (6, 8)
    assert "width_mm = 0.8" in other.toml() and "starling:green" in repr(other)
    assert "starling" in barbule.presets()


def test_pictures_have_tone_white_and_quality():
    ball = """
sky = 1.0
[camera]
azimuth_deg = 0.0
elevation_deg = 80.0
width_mm = 3.0
[[lights]]
type = "sun"
azimuth_deg = 0.0
elevation_deg = 80.0
strength = 4.0
illuminant = "A"
[surfaces.white]
type = "diffuse"
colour = "#ffffff"
[[objects]]
surface = "white"
sphere_mm = 1.0
"""
    scene = barbule.Scene.parse(ball)
    warm = scene.render((16, 16), quality="draft", progress=False)
    assert [(name, light, round(kelvin)) for name, light, kelvin in warm.lamps][0][:2] == ("lights[0]", "A")
    neutral = scene.render((16, 16), quality="draft", white_balance="auto", progress=False)
    film = scene.render((16, 16), quality="draft", tone="filmic", progress=False)
    ratio = [picture.rgb()[8, 8, 2] / picture.rgb()[8, 8, 0] for picture in (warm, neutral)]
    assert ratio[0] < 0.8 and abs(ratio[1] - 1) < 0.06
    assert not np.array_equal(film.rgb(), warm.rgb())
    np.testing.assert_array_equal(film.planes()["xyz"], neutral.planes()["xyz"])
    with pytest.raises(barbule.InputError, match="did you mean 'final'"):
        scene.render((8, 8), quality="fnal", progress=False)
    with pytest.raises(barbule.InputError, match="Open Image Denoise"):
        scene.render((8, 8), denoise="/nowhere/libOpenImageDenoise.so.2", progress=False)


def test_golden_values_are_those_of_every_back_end():
    """The values by which every back end is held (`docs/formats/brdf-tables.md`), in double precision."""
    golden = json.loads((Path(__file__).parents[2] / "barbule/tests/it/data/brdf.json").read_text())
    nm, name = golden["wavelengths_nm"], golden["instance"]
    for one in golden["materials"]:
        material = barbule.Material.load(one["name"].replace("-", ":"))
        assert material.hash == one["hash"]
        for light in one["light"]:
            for key, instance in (("mean", None), ("drawn", name)):
                expected = np.array(light[key]).T
                found = material.eval(nm, light["wi"], light["wo"], instance=instance)
                np.testing.assert_allclose(found, expected, atol=2e-4 * expected.max())


def test_a_peacock_is_drawn_by_its_models():
    flat = barbule.render("peacock", model="film-2005", size=(12, 15), samples=1)
    assert flat.rgb().shape == (15, 12, 3)
    tubes = barbule.Scene.load("peacock", model="film-2005")
    assert "film-2005" in tubes.toml() and "film-2005" not in barbule.Scene.load("peacock").toml()
    with pytest.raises(barbule.InputError, match="has no models"):
        barbule.render("starling", model="film", size=(8, 6), samples=1)
    with pytest.raises(barbule.InputError, match="did you mean 'film'"):
        barbule.Scene.load("peacock", model="flim")


def test_samples_take_numbers_below_one(starling):
    for u in ([0.5, 1.0], [np.nan, 0.5], [-0.1, 0.5]):
        with pytest.raises(barbule.InputError, match="'u' holds .*; give numbers from 0 to below 1"):
            starling.sample(550, [0, 0, 1], u)
    with pytest.raises(barbule.InputError, match="'polarization' is 3"):
        barbule.Material.load("starling", polarization=3)


def test_options_are_numbers_of_any_kind(tmp_path):
    whole = barbule.characterize("air/keratin:400/melanin", thin=10, instances=2, cache=tmp_path)
    same = dict(thin=np.int64(10), instances=np.int32(2), directions=np.array([20, 20]), mirror=np.bool_(False), tilt_deg=np.float32(2.0))
    assert barbule.characterize("air/keratin:400/melanin", **same, cache=tmp_path).hash == whole.hash
    assert whole.name == "air/keratin:400/melanin (thinned)"
    for options, said in (({"tilt_deg": np.nan}, "'tilt_deg' is nan"), ({"wavelengths_nm": [500, np.inf]}, "'wavelengths_nm' is inf")):
        with pytest.raises(barbule.InputError, match=f"{said}; give a finite number"):
            barbule.characterize("starling", **options)
    with pytest.raises(barbule.InputError, match="'width_um' is inf; give a finite number"):
        barbule.validate("starling", tmp_path, width_um=np.inf)
    with pytest.raises(barbule.InputError, match="'ends' is 'opn'; give 'open' or 'closed'"):
        barbule.validate("starling", tmp_path, ends="opn")


def test_a_picture_has_the_size_that_its_scene_says():
    scene = barbule.Scene.parse('preset = "starling"\nsize = [12, 10]\n')
    assert scene.render(samples=1).shape == (10, 12) and scene.render((8, 6), samples=1).shape == (6, 8)
    assert barbule.Scene.load("starling").pixels() == (1280, 800)


def test_arguments_that_change_nothing_are_said_where_they_were_given(starling):
    structure = barbule.open("air/keratin:200/air")
    scene = barbule.Scene.load("starling")
    for call, name in (
        (lambda: barbule.film("air/keratin:200/air", instances=3), "instances"),
        (lambda: barbule.spectrum(structure, media={"x": "x.csv"}), "media"),
        (lambda: barbule.spectrum(starling, [550], instrument="probe:10", instances=3), "instances"),
        (lambda: barbule.render(scene, (8, 6), 1, model="film"), "model"),
    ):
        with pytest.warns(barbule.DoubtWarning, match=f"'{name}' has no effect here") as said:
            call()
        assert [one.filename for one in said] == [__file__]
    with pytest.warns(barbule.DoubtWarning, match="did you mean 600") as said:
        barbule.film("air/keratin:0.6/air", [550])
    assert said[0].filename == __file__
