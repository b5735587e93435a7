"""Films, spectra, fields, crystals and gratings from Python, against formulas and each other."""

import numpy as np
import pytest

import barbule


def test_a_quarter_wave_film_reflects_what_the_formula_says():
    """R = ((n₀n₂ − n₁²)/(n₀n₂ + n₁²))² at normal incidence."""
    found = barbule.film("1/1.38:99.63768115942029/1.52", [550.0])
    expected = ((1.52 - 1.38**2) / (1.52 + 1.38**2)) ** 2
    for polarization in ("s", "p"):
        assert float(found[f"R_{polarization}"][0, 0]) == pytest.approx(expected, rel=1e-12)
    assert complex(found["r_s"][0, 0]) == pytest.approx(-complex(found["r_p"][0, 0]))


def test_light_is_reflected_transmitted_or_absorbed():
    found = barbule.film("air/6*(melanin:99/keratin:100)/air", range(400, 701, 50), [0, 30, 60, 85])
    for polarization in ("s", "p"):
        parts = [np.asarray(found[f"{what}_{polarization}"]) for what in "RTA"]
        np.testing.assert_allclose(sum(parts), 1.0, atol=1e-12)
        layers = np.asarray(found[f"A_layer_{polarization}"])
        assert layers.shape == (12, 4, 7)
        np.testing.assert_allclose(layers.sum(axis=0), parts[2], atol=1e-12)


def test_gradients_are_differences():
    def stack(thickness):
        return f"air/keratin:{thickness!r}/melanin:150/1.3"

    nm, angles, step = [420.0, 550.0, 680.0], [0.0, 50.0], 1e-3
    found = barbule.film(stack(320.0), nm, angles, gradients=True)
    above, below = (barbule.film(stack(320.0 + sign * step), nm, angles) for sign in (1, -1))
    for polarization in ("s", "p"):
        for name, of in (("r", f"dr_dd_{polarization}"), ("R", f"dR_dd_{polarization}")):
            name = f"{name}_{polarization}"
            difference = (np.asarray(above[name]) - np.asarray(below[name])) / (2 * step)
            np.testing.assert_allclose(np.asarray(found[of])[..., 0], difference, atol=1e-9)
    assert found["dR_dn_s"].shape == (2, 3, 3)


def test_lists_ranges_and_strided_singles_are_the_same_numbers():
    nm = np.arange(400, 701, 10)
    doubled = np.repeat(nm, 2).astype(np.float32)[::2]
    films = [barbule.film("air/keratin:500/air", given) for given in (nm, list(nm), range(400, 701, 10), doubled)]
    for other in films[1:]:
        np.testing.assert_array_equal(np.asarray(films[0]["R_s"]), np.asarray(other["R_s"]))


def test_a_spectrum_is_the_mean_of_its_individuals():
    found = barbule.spectrum("starling:pink", [450, 550, 650], [0, 40], instances=6, threads=1)
    individuals = np.asarray(found["individuals"])
    assert individuals.shape == (6, 2, 3)
    np.testing.assert_allclose(np.asarray(found["reflectance"]), individuals.mean(axis=0))
    np.testing.assert_allclose(np.asarray(found["std"]), individuals.std(axis=0, ddof=1))
    again = barbule.spectrum("starling:pink", [450, 550, 650], [0, 40], instances=6, threads=2)
    np.testing.assert_array_equal(individuals, np.asarray(again["individuals"]))


def test_light_that_does_not_come_is_refused():
    section = barbule.open("starling").instance(0)
    for call, said in (
        (lambda: barbule.spectrum("starling", [500], [120]), "between -90 and 90"),
        (lambda: barbule.spectrum("starling", [500], [0], instances=0), "from 1 to 10000"),
        (lambda: barbule.spectrum("starling", [500], [0], cone_deg=-5), "'cone_deg' is -5"),
        (lambda: barbule.far_fields(section, [500], azimuths=0), "'azimuths' is 0"),
        (lambda: barbule.far_fields(section, [500], phi_deg=[90]), "'phi_deg' holds 90"),
        (lambda: barbule.crystal("mallard", [500], [95]), "'phi_deg' holds 95"),
        (lambda: barbule.far_fields(section, [500], elements_per_wavelength=np.inf), "'elements_per_wavelength' is inf; give a number from 4 to 200"),
        (lambda: barbule.far_fields(section, [500], solver="full-wave", elements_per_wavelength=1e9), "give a number from 4 to 200"),
        (lambda: barbule.spectrum("starling", [500], plane="acros"), "'plane' is 'acros'; give 'across' or 'along'"),
        (lambda: barbule.spectrum("starling", [500], polarization=3), "'polarization' is 3; give None, 1 or 2"),
    ):
        with pytest.raises(barbule.InputError, match=said):
            call()


def test_polarizations_make_unpolarized_light():
    of = {p: barbule.spectrum("mallard", [500], [45], instances=2, polarization=p) for p in (None, 1, 2)}
    mean = (np.asarray(of[1]["reflectance"]) + np.asarray(of[2]["reflectance"])) / 2
    np.testing.assert_allclose(np.asarray(of[None]["reflectance"]), mean, rtol=1e-6)


def test_far_fields_carry_what_is_reflected():
    """∫ intensity dφ is the reflected part, and a flat film's is that of Fresnel's formulas."""
    section = barbule.open("air/keratin:320/melanin").instance(0)
    found = barbule.far_fields(section, [532.0], phi_deg=[0.0, 30.0], azimuths=2000)
    intensity = np.asarray(found["intensity"])[0, 0]
    total = intensity.sum(axis=-1) * np.pi / 2000
    np.testing.assert_allclose(total, np.asarray(found["reflected"])[0, 0], rtol=2e-3)
    film = barbule.film("air/keratin:320/melanin", [532.0], [0.0])
    assert total[0].mean() == pytest.approx(float(film["R_s"][0, 0]), rel=2e-2)


def test_thicknesses_that_look_like_micrometres_are_doubted():
    with pytest.warns(barbule.DoubtWarning, match="did you mean 300"):
        barbule.film("air/keratin:0.3/air", [550.0])


def test_full_waves_see_what_the_fast_simulation_sees():
    thin = barbule.open("1/1.55:300/1").instance(0)
    light = dict(phi_deg=[0.0], window="beam", azimuths=720)
    fast = barbule.far_fields(thin, [600.0], **light)
    with pytest.warns(barbule.DoubtWarning):
        full = barbule.far_fields(thin, [600.0], **light, solver="full-wave")
    np.testing.assert_allclose(np.asarray(fast["reflected"]), np.asarray(full["reflected"]), rtol=0.03)
    assert np.asarray(full["absorbed_um"]).max() < 1e-3 * np.asarray(full["scattered_um"]).max()


def test_three_methods_see_one_crystal():
    found = [
        np.asarray(barbule.crystal("mallard", [520.0], [0.0, 30.0], solver=solver)["R"])
        for solver in ("multipole", "rcwa")
    ]
    np.testing.assert_allclose(found[0], found[1], atol=0.01)


def test_a_grating_sends_its_first_order_where_the_grating_equation_says():
    x = np.arange(512) / 512 * 40.0
    grooves = barbule.Heights.of(np.tile(0.05 * np.sin(2 * np.pi * x / 1.0), (4, 1)), (40.0, 0.4))
    assert grooves.height_um.shape == (4, 512)
    sines = np.linspace(0.3, 0.8, 101)
    f = [
        float(np.asarray(grooves.spectrum([550.0], [0, 0, 1], [s, 0, np.sqrt(1 - s * s)])["f"])[0])
        for s in sines
    ]
    assert sines[int(np.argmax(f))] == pytest.approx(0.55, abs=0.006)


def test_white_is_white():
    found = barbule.colours(range(380, 781, 5), np.ones((2, 81)))
    np.testing.assert_allclose(np.asarray(found["xyz"])[:, 1], 1.0, atol=1e-3)
    assert np.asarray(found["srgb"]).min() >= 253
    assert barbule.delta_e_2000([0.2, 0.2, 0.2], [0.21, 0.2, 0.2]) > 1.0


def test_results_are_datasets_with_units():
    xarray = pytest.importorskip("xarray")
    found = barbule.film("air/keratin:595/air", range(400, 701, 10), [0, 45])
    assert isinstance(found, xarray.Dataset)
    assert found["wavelength"].attrs["units"] == "nm"
    assert found["r_s"].dims == ("angle", "wavelength")
    assert found.barbule.colours().shape == (2, 3)
    assert found.barbule.reflectance().shape == (2, 31)


def test_results_without_xarray_have_the_same_names(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "xarray", None)
    found = barbule.film("air/keratin:595/air", [450, 550], [0])
    assert isinstance(found, barbule.Arrays)
    assert found["R_s"].dims == ("angle", "wavelength") and found["wavelength"].units == "nm"
    assert np.asarray(found["R_s"]).shape == (1, 2) and "R_s" in repr(found)


def test_instruments_read_structures_and_materials():
    film = barbule.spectrum("air/1.56:410/air", [450.0, 511.0], [0, 4], instrument="probe:10")
    # Projected solid angle is even over sin²θ.
    angles = np.degrees(np.arcsin(np.sin(np.radians(10)) * np.sqrt((np.arange(40) + 0.5) / 40)))
    plane_waves = barbule.film("air/1.56:410/air", [450.0, 511.0], angles)
    mirrored = 0.5 * (np.asarray(plane_waves["R_s"]) + np.asarray(plane_waves["R_p"])).mean(axis=0)
    read = np.asarray(film["reflectance"])
    np.testing.assert_allclose(read[0] * np.sin(np.radians(10)) ** 2, mirrored, rtol=1e-3)
    assert (read[1] < read[0]).all() and film.attrs["reference"] == "white"
    material = barbule.Material.load("starling")
    of_material = barbule.spectrum(material, [500.0], instrument="sphere")
    of_fields = barbule.spectrum("starling", [500.0], instrument="sphere", tilt_deg=1.5, instances=20)
    np.testing.assert_allclose(np.asarray(of_material["reflectance"]), np.asarray(of_fields["reflectance"]), rtol=0.1)
    for wrong in ({"instrument": "probe:0"}, {"tilt_deg": 2.0}, {"instrument": "sphere", "cone_deg": 5.0}):
        with pytest.raises(barbule.InputError):
            barbule.spectrum("starling", [500.0], instances=1, **wrong)


def test_tilts_are_one_number_or_two():
    read = lambda tilt: np.asarray(  # noqa: E731
        barbule.spectrum("air/keratin:200/air", [500.0], instrument="probe:10", tilt_deg=tilt, progress=False)["reflectance"]
    )
    for tilt in ([5.0, 2.0], np.array([5.0, 2.0])):
        np.testing.assert_array_equal(read(tilt), read((5.0, 2.0)))
    with pytest.raises(barbule.InputError, match="'tilt_deg' holds 3 numbers; give one for slopes and turns"):
        read([1.0, 2.0, 3.0])


def test_more_individuals_than_there_are_is_said():
    with pytest.warns(barbule.DoubtWarning, match="'instances' is 9, but there is 1 section: it is simulated"):
        found = barbule.spectrum("air/keratin:200/air", [500.0], instances=9, progress=False)
    assert found["individuals"].shape[0] == 1


def test_the_law_of_angles_gives_the_index_with_its_interval():
    angles = np.array([0.0, 20.0, 40.0, 60.0])
    peaks = 640 * np.sqrt(1 - (np.sin(np.radians(angles)) / 1.5) ** 2) + [0.5, -0.5, -0.5, 0.5]
    law = barbule.angle_law(angles, peaks)
    assert law.index is not None and law.index.low < 1.5 < (law.index.high or np.inf)
    assert law.normal_nm.low < 640 < (law.normal_nm.high or 0) and law.b_nm_per_deg.value > 0
    with pytest.raises(barbule.InputError, match="needs 3 angles"):
        barbule.angle_law(angles[:2], peaks[:2])


def test_thicknesses_that_spread_make_means_and_deviations():
    nm, angles = [450.0, 550.0, 650.0], [0.0, 30.0]
    found = barbule.film("air/keratin:595±40/air", nm, angles, instances=20, seed=3)
    one = barbule.film("air/keratin:595/air", nm, angles)
    std = np.asarray(found["std"])
    assert std.shape == (2, 3) and (std > 0.01).all() and "std" not in one
    assert np.abs(np.asarray(found["R_s"]) - np.asarray(one["R_s"])).max() > 1e-3
    for polarization in ("s", "p"):
        parts = [np.asarray(found[f"{what}_{polarization}"]) for what in "RTA"]
        np.testing.assert_allclose(sum(parts), 1.0, atol=1e-12)
    again = barbule.film("air/keratin:595±40/air", nm, angles, instances=20, seed=3, threads=1)
    np.testing.assert_array_equal(std, np.asarray(again["std"]))
    assert np.asarray(barbule.film("air/keratin:595±40/air", nm, instances=1)["std"]).max() == 0
    with pytest.raises(barbule.InputError, match="derivatives are of one stack; leave out the spreads"):
        barbule.film("air/keratin:595±40/air", nm, gradients=True)
    with pytest.raises(barbule.InputError, match="'instances' is 0"):
        barbule.film("air/keratin:595±40/air", nm, instances=0)


def test_wavelengths_that_cannot_be_simulated_are_refused(tmp_path):
    section, patch = barbule.open("starling").instance(0), barbule.Heights.sample("sinusoid")
    for call in (
        lambda: barbule.film("air/keratin:595/air", [0.5, 0.6]),
        lambda: barbule.spectrum("starling", [200, 500]),
        lambda: barbule.spectrum("starling", [500, 900], instrument="probe:10"),
        lambda: barbule.crystal("mallard", [0.5]),
        lambda: barbule.far_fields(section, [900]),
        lambda: patch.spectrum([200], [0, 0, 1], [0, 0, 1]),
        lambda: barbule.intervals("starling", [200, 500]),
        lambda: barbule.see("starling", "starling", wavelengths_nm=[200, 700]),
        lambda: barbule.validate("starling", tmp_path, wavelengths_nm=[200]),
    ):
        with pytest.raises(barbule.InputError, match="'wavelengths_nm': .* nm is outside 300 to 830 nm"):
            call()


def test_colours_need_what_the_eye_sees():
    for nm in ([300, 400], [500]):
        with pytest.raises(barbule.InputError, match="too little of what the eye sees; give wavelengths from 400 to 700 nm"):
            barbule.colours(nm, np.full(len(nm), 0.5))
    with pytest.warns(barbule.DoubtWarning, match="its end values are held"):
        found = barbule.colours([420, 680], [0.5, 0.5], "D50")
    np.testing.assert_allclose(np.asarray(found["xyz"])[0, 1], 0.5, rtol=1e-3)
    with pytest.raises(barbule.InputError, match="too little"):
        barbule.colours([500], 0.5)
    # Data may reach further than simulations.
    assert barbule.colours([250, 900], [1.0, 1.0])["xyz"].shape == (1, 3)
    for pair, name in (([np.nan, 0.2, 0.2], [0.2] * 3), "one"), (([0.2] * 3, [0.2, np.inf, 0.2]), "other"):
        with pytest.raises(barbule.InputError, match=f"'{name}' holds"):
            barbule.delta_e_2000(*pair)


def test_directions_of_heights_are_unit_vectors():
    patch = barbule.Heights.sample("sinusoid")
    for wi, wo, said in (
        ([0, 0, 2], [0, 0, 1], r"'wi' is \(0, 0, 2\), of length 2.000; give a unit vector"),
        ([0, 0, 1], [0, np.nan, 1], "'wo' is"),
    ):
        with pytest.raises(barbule.InputError, match=said):
            patch.spectrum([500], wi, wo)
