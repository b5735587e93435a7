"""What birds see, from Python: against NumPy's own integrals and the published number."""

import numpy as np
import pytest

import barbule


def test_catches_are_integrals_of_quanta_over_those_of_white():
    eye = barbule.vision.sensitivities("starling")
    nm = np.arange(300.0, 701.0)
    reflectance = 0.3 + 0.2 * np.sin(nm / 31)
    single, double = barbule.vision.catches(nm, reflectance, "starling", "E")
    answers = np.vstack([np.asarray(eye["sensitivity"]), np.asarray(eye["double"])[None]])[:, :401] * nm
    expected = np.trapezoid(answers * reflectance, nm) / np.trapezoid(answers, nm)
    np.testing.assert_allclose([*single, double], expected, rtol=1e-9)


def test_five_percent_on_the_long_cone_is_the_published_number():
    catches = [[0.1, 0.3, 0.5, 0.4], [0.1, 0.3, 0.5, 0.42]]
    assert float(barbule.vision.jnd(catches)[0, 1]) == pytest.approx(0.36366, abs=5e-6)
    assert float(barbule.vision.jnd(catches, reference="rarest")[0, 1]) == pytest.approx(2 * 0.36366, abs=1e-5)


def test_things_are_seen_and_told_apart(tmp_path):
    nm = np.arange(300, 701, 5)
    np.savetxt(tmp_path / "a.csv", np.stack([nm, np.full(nm.shape, 0.2)], 1), delimiter=",")
    np.savetxt(tmp_path / "b.csv", np.stack([nm, np.where(nm > 600, 0.3, 0.2)], 1), delimiter=",")
    seen = barbule.see([tmp_path / "a.csv", tmp_path / "b.csv"], "blue-tit", progress=False)
    assert seen["catches"].shape == (2, 4)
    np.testing.assert_allclose(np.asarray(seen["catches"][0]), 0.2, rtol=1e-9)
    assert float(seen["r"][0]) == pytest.approx(0, abs=1e-9)
    assert float(seen["delta_s"][0, 1]) > 1 and float(seen["delta_s"][0, 0]) == 0
    np.testing.assert_allclose(
        np.asarray(seen["delta_s"]), barbule.vision.jnd(np.asarray(seen["catches"]), [1, 1.92, 2.68, 2.7])
    )


def test_nothing_is_invented_in_the_ultraviolet():
    with pytest.raises(barbule.InputError, match="nothing is invented outside"):
        barbule.vision.catches([400, 700], [0.2, 0.2], "starling")
    with pytest.raises(barbule.InputError, match="did you mean 'starling'"):
        barbule.vision.sensitivities("starlin")


def test_data_may_reach_further_than_simulations():
    single, _ = barbule.vision.catches([250, 900], [0.2, 0.2], "starling")
    np.testing.assert_allclose(single, 0.2, rtol=1e-9)
    with pytest.raises(barbule.InputError, match="'reference' is 'last'; give 'longest' or 'rarest'"):
        barbule.vision.jnd([[0.1, 0.3, 0.5, 0.4]], reference="last")


def test_arrays_of_other_shapes_are_refused():
    for call, words in (
        (lambda: barbule.vision.tetrahedral([1.0, 2.0, 3.0]), "last axis must hold 4 cones"),
        (lambda: barbule.vision.catches([300, 700], [0.2], "starling"), "last axis must hold 2 wavelengths"),
        (lambda: barbule.vision.jnd(np.ones((2, 2, 4))), r"give \[row, cone\]"),
        (lambda: barbule.colours([400, 500, 600, 700], []), "last axis must hold 4 wavelengths"),
        (lambda: barbule.see([], "starling"), "'things' is empty"),
        (lambda: barbule.see("starling", "starling", angle_deg=[0, 30]), "'angle_deg' holds 2 angles"),
    ):
        with pytest.raises(barbule.InputError, match=words):
            call()
