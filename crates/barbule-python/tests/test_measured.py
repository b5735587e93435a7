"""Measurements beside simulations, and how sure these are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import barbule

NM = np.arange(400.0, 701.0, 5.0)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two films 2 and 4 % thicker than 260 nm, at two angles."""
    for bird, nm in (("a", 265.2), ("b", 270.4)):
        for angle in (0, 30):
            found = barbule.spectrum(f"air/keratin:{nm}/air", NM, angle, progress=False)
            lines = (f"{x},{y}\n" for x, y in zip(NM, np.ravel(found["reflectance"])))
            (tmp_path / f"{bird}_{angle}deg.csv").write_text("wl,R\n" + "".join(lines))
    return tmp_path


def test_individuals_and_angles_are_read_and_compared(folder: Path) -> None:
    known = barbule.measured(folder)
    assert [one.angle_deg for one in known] == [0.0, 30.0]
    assert known[0].names == ["a_0deg", "b_0deg"] and known[0].samples.shape == (2, len(NM))
    np.testing.assert_allclose(known[0].samples.mean(axis=0), known[0].mean, atol=1e-15)
    simulated = barbule.spectrum("air/keratin:260/air", NM, [0, 30, 60], progress=False)
    first, second, third = barbule.compare(simulated, known)
    assert third is None and first is not None and second is not None
    assert first["cause"] == "shift" and abs(first["cause_shift"] - 0.03) < 0.006
    assert first["measured_individuals"] == 2
    assert barbule.compare(simulated, folder)[1] == second
    with pytest.raises(barbule.InputError, match="'peak_range_nm' is .700, 500."):
        barbule.compare(simulated, known, peak_range_nm=(700, 500))
    with pytest.raises(barbule.InputError, match="no angle behind @"):
        barbule.measured(f"{folder / 'a_0deg.csv'}@x")


def test_measurements_of_the_same_angle_are_pooled_and_go_before_those_of_none(folder: Path) -> None:
    simulated = barbule.spectrum("air/keratin:260/air", NM, [0, 30], progress=False)
    known = barbule.measured(folder)
    single = [replace(known[0], names=[name], samples=known[0].samples[k : k + 1]) for k, name in enumerate(known[0].names)]
    assert barbule.compare(simulated, single)[0] == barbule.compare(simulated, known)[0]
    anywhere = replace(known[1], angle_deg=None)
    assert barbule.compare(simulated, [anywhere, known[0]]) == barbule.compare(simulated, known)
    shorter = replace(single[1], wavelength_nm=NM[1:], samples=single[1].samples[:, 1:], mean=single[1].mean[1:])
    with pytest.raises(barbule.InputError, match="two measurements at 0° with different wavelengths, 'a_0deg' and 'b_0deg'; give one file"):
        barbule.compare(simulated, [single[0], shorter])
    with pytest.raises(TypeError, match=r"a Measured and 'x.csv' in one list; read files first: barbule.measured"):
        barbule.compare(simulated, [known[0], "x.csv"])


def test_intervals_follow_what_is_uncertain() -> None:
    def peak(uncertain: dict[str, float | str]) -> dict[str, float]:
        found = barbule.intervals("air/keratin:260/air", NM, uncertain=uncertain, progress=False)
        return found[0]["numbers"]["peak_nm"]

    one, two = peak({"layer1": "1%"}), peak({"layer1": "2%"})
    assert (two["high"] - two["low"]) / (one["high"] - one["low"]) == pytest.approx(2.0, rel=0.03)
    assert peak({"keratin": 0.01})["std_of_uncertain"]["keratin"] > 1.0
    with pytest.raises(barbule.InputError, match="its layers are layer1"):
        peak({"layer3": 1.0})
    with pytest.raises(barbule.InputError, match="instances is 1, but intervals are of how individuals of starling:green differ"):
        barbule.intervals("starling", instances=1)
