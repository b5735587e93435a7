"""Sizes from spectra, from arrays and from files."""

from pathlib import Path

import numpy as np
import pytest

import barbule

STARLING = Path(__file__).parents[3] / "examples/measured/starling-back.csv"


def test_a_film_is_found_from_two_angles_and_its_file_is_that_film(tmp_path):
    nm = np.arange(400.0, 701.0, 5.0)
    film = barbule.film("air/keratin:612/melanin", nm, [0.0, 40.0], progress=False)
    reflectance = 0.5 * (np.asarray(film["R_s"]) + np.asarray(film["R_p"]))
    scaled = reflectance * np.array([[0.4], [0.9]])
    found = barbule.fit_structure((nm, scaled), stack="air/keratin:?/melanin", angles_deg=[0.0, 40.0], progress=False)
    size = found.best.parameters["thickness_nm"]
    assert size.value == pytest.approx(612.0, abs=1e-3)
    assert size.low <= 612.0 <= size.high
    np.testing.assert_allclose(found.best.level, [0.4, 0.9], rtol=1e-4)
    np.testing.assert_allclose(found.best.fitted[1], scaled[1], atol=1e-6)
    found.save(tmp_path / "film.toml")
    again = barbule.film(tmp_path / "film.toml", nm, [0.0], progress=False)
    np.testing.assert_allclose(np.asarray(again["R_s"])[0], np.asarray(film["R_s"])[0], atol=1e-5)


def test_files_have_individuals_whose_scatter_is_given():
    found = barbule.fit_structure(STARLING, stack="air/keratin:?/melanin", progress=False)
    size = found.best.parameters["thickness_nm"]
    assert size.low < size.value < size.high
    assert size.between_samples_std > 0.0
    assert found.readings[0]["samples"] == 3
    worse = [one.worse_by for one in found.solutions]
    assert worse == sorted(worse) and worse[0] == 0.0


def test_what_cannot_be_fitted_is_refused():
    with pytest.raises(barbule.InputError, match="did you mean 'film'"):
        barbule.fit_structure(STARLING, "flim", progress=False)
    with pytest.raises(barbule.InputError, match=r"reflectances of the shape \(3,\); give \[angle, wavelength\]"):
        barbule.fit_structure(([400.0, 500.0], [0.1, 0.2, 0.3]), progress=False)


def test_arrays_are_fitted_where_structures_can_be_simulated():
    nm = np.arange(300.0, 831.0, 5.0)
    film = barbule.film("air/keratin:612/melanin", nm, progress=False)
    reflectance = 0.5 * (np.asarray(film["R_s"]) + np.asarray(film["R_p"]))
    wide, values = np.concatenate([[250.0], nm, [900.0]]), np.pad(reflectance, ((0, 0), (1, 1)), constant_values=9.0)
    found = barbule.fit_structure((wide, values), stack="air/keratin:?/melanin", progress=False)
    assert found.best.parameters["thickness_nm"].value == pytest.approx(612.0, abs=1e-3)
    assert found.readings[0]["wavelength_nm"][0] == 300.0
    with pytest.raises(barbule.InputError, match="fewer than two of its wavelengths, 0.3 to 0.83 nm, lie within 300 to 830 nm"):
        barbule.fit_structure((nm / 1000, reflectance), progress=False)


def test_misspelt_words_and_objects_are_refused():
    given = ([400.0, 500.0], [0.1, 0.2])
    with pytest.raises(barbule.InputError, match="'level' is 'fxed'; give 'free' or 'fixed'"):
        barbule.fit_structure(given, level="fxed", progress=False)
    with pytest.raises(barbule.InputError, match="'plane' is 'x'"):
        barbule.fit_structure(given, plane="x", progress=False)
    with pytest.raises(barbule.InputError, match="9"):
        barbule.fit_structure(STARLING, column=9, progress=False)
    with pytest.raises(TypeError, match="'measured' is a Measured; give its name or a file"):
        barbule.fit_structure(barbule.measured(STARLING), progress=False)


def test_one_open_size_is_a_word_and_what_flat_layers_lack_is_said():
    with pytest.raises(barbule.InputError, match="cortex_mu"):
        barbule.fit_structure(STARLING, "starling", free="cortex_mu", progress=False)
    with pytest.warns(barbule.DoubtWarning, match="has no effect here: flat layers") as said:
        barbule.fit_structure(STARLING, "film", instances=3, plane="along", progress=False)
    assert sorted(str(one.message).split("'")[1] for one in said if "no effect" in str(one.message)) == ["instances", "plane"]


def test_arrays_have_the_axes_that_are_asked_for():
    nm = np.arange(400.0, 701.0, 10.0)
    film = barbule.film("air/keratin:595/air", nm, [0.0, 40.0])
    reflectance = 0.5 * (np.asarray(film["R_s"]) + np.asarray(film["R_p"]))
    fit = lambda values, **how: barbule.fit_structure((nm, values), progress=False, **how)  # noqa: E731
    for wrong in (reflectance.T, reflectance.ravel()):
        with pytest.raises(barbule.InputError, match="give .angle, wavelength. .* of 2 by 31"):
            fit(wrong, angles_deg=[0.0, 40.0])
    with pytest.raises(barbule.InputError, match="some values are masked"):
        fit(np.ma.masked_equal(reflectance[0], reflectance[0, 3]))
    with pytest.raises(barbule.InputError, match="'column' is of files"):
        fit(reflectance[0], column=1)
    with pytest.raises(barbule.InputError, match="'angles_deg' is of arrays"):
        barbule.fit_structure(STARLING, angles_deg=40, progress=False)
