"""What birds see, from Python: against NumPy's own integrals and the published number."""

import warnings

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
        (lambda: barbule.vision.jnd(np.ones((2, 4)), weber=0), "'weber' is 0; give a number over 0"),
        (lambda: barbule.see([], "starling"), "'things' is empty"),
        (lambda: barbule.see("starling", "starling", angle_deg=[0, 30]), "'angle_deg' holds 2 angles"),
    ):
        with pytest.raises(barbule.InputError, match=words):
            call()


def test_weber_fractions_are_the_callers():
    things = ["air/keratin:320/melanin", "air/keratin:340/melanin"]
    usual = barbule.see(things, "peafowl", instances=1, progress=False)
    other = barbule.see(things, "peafowl", instances=1, weber=0.05, weber_double=0.2, progress=False)
    np.testing.assert_allclose(other["delta_s"], usual["delta_s"] * usual.attrs["weber"] / 0.05)
    np.testing.assert_allclose(other["delta_l"], usual["delta_l"] * usual.attrs["weber_double"] / 0.2)
    for bad in ({"weber": 0}, {"weber": 50}, {"weber_double": -1.0}):
        with pytest.raises(barbule.InputError, match=f"'{next(iter(bad))}' is .*; give a number over 0 and up to 10"):
            barbule.see(things, "peafowl", instances=1, progress=False, **bad)


def test_what_changes_nothing_is_said(tmp_path):
    file, stack = tmp_path / "a.csv", "air/keratin:320/melanin"
    file.write_text("".join(f"{nm},0.2\n" for nm in range(300, 701, 10)))
    idle = lambda said: sorted(str(one.message).split("'")[1] for one in said)  # noqa: E731
    with pytest.warns(barbule.DoubtWarning, match="has no effect here") as said:
        barbule.see([file, file], "starling", angle_deg=10, instances=2, wavelengths_nm=range(300, 701, 10))
    assert idle(said) == ["angle_deg", "instances", "wavelengths_nm"]
    with pytest.warns(barbule.DoubtWarning, match="has no effect here") as said:
        barbule.see(stack, "starling", weber=0.1, weber_double=0.1, ratio=(1, 2, 2, 4), samples=True, progress=False)
    assert idle(said) == ["ratio", "samples", "weber", "weber_double"]
    with warnings.catch_warnings():
        warnings.simplefilter("error", barbule.DoubtWarning)
        barbule.see([file, stack], "starling", weber=0.1, angle_deg=10, instances=2, samples=True, progress=False)
