"""Atlases from Python, and as xarray sees them."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import barbule

PLAN = """barbule = 1
name = "films"
structure = "air/keratin:300/melanin:600/air"
wavelengths_nm = "300:700:20"
angles_deg = [0, 30]
individuals = 1
birds = ["starling"]
unit_cells = 4

[[vary]]
key = "layer1"
values = "200:400:50"

[[vary]]
key = "layer2"
values = [300, 500, 600]
"""


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    path = tmp_path / "plan.toml"
    path.write_text(PLAN)
    return path


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_parts_are_the_bytes_of_the_whole(plan: Path, tmp_path: Path) -> None:
    whole, parts = tmp_path / "whole.zarr", tmp_path / "parts.zarr"
    outcome = barbule.atlas(plan, whole, progress=False)
    assert outcome.computed == len(outcome.unit_seconds) > 1 and outcome.found == 0
    for part in (2, 0, 1):
        barbule.atlas(plan, parts, shard=(part, 3), threads=1, progress=False)
    assert bytes_of(parts) == bytes_of(whole)
    assert barbule.atlas(plan, whole, progress=False).computed == 0


def test_xarray_opens_a_store_without_a_warning(plan: Path, tmp_path: Path) -> None:
    import xarray

    store = tmp_path / "s.zarr"
    barbule.atlas(plan, store, progress=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xarray.open_zarr(store).load()
    assert data["mean"].dims == ("layer1", "layer2", "angle", "wavelength")
    assert data.layer1.attrs["units"] == "nm" and "layer 1" in data.layer1.attrs["long_name"]
    one = data["mean"].sel(layer1=250, layer2=500, angle=30)
    same = barbule.spectrum("air/keratin:250/melanin:500/air", angles_deg=[30], wavelengths_nm=data.wavelength.values)
    np.testing.assert_allclose(one.values, np.asarray(same["reflectance"]).squeeze(), rtol=1e-12)
    assert data.catches_starling.sizes["cone_starling"] == 4
    assert data.srgb.dtype == np.uint8 and bool((data.xyz >= 0).all())


def test_a_forecast_counts_the_files(plan: Path, tmp_path: Path) -> None:
    forecast = barbule.foretell(plan, progress=False)
    barbule.atlas(plan, tmp_path / "s.zarr", progress=False)
    assert (forecast.cells, forecast.files) == (15, len(bytes_of(tmp_path / "s.zarr")))
    assert forecast.seconds > 0


def test_a_page_and_a_picture_stand_where_they_were_asked_for(plan: Path, tmp_path: Path) -> None:
    page, picture = tmp_path / "page", tmp_path / "map.png"
    barbule.atlas(plan, tmp_path / "s.zarr", page=page, picture=picture, progress=False)
    assert picture.read_bytes().startswith(b"\x89PNG") and len(list((page / "structures").glob("*.toml"))) == 15
    assert "15 of 15 structures" in (page / "index.html").read_text(encoding="utf-8")
    with pytest.raises(barbule.InputError, match=r"figures are written as"):
        barbule.atlas(plan, tmp_path / "t.zarr", picture=tmp_path / "map.txt", progress=False)
    assert not (tmp_path / "t.zarr").exists()


def test_refusals_name_the_key(plan: Path, tmp_path: Path) -> None:
    plan.write_text(PLAN.replace('"layer1"', '"layer9"'))
    with pytest.raises(barbule.InputError, match=r"vary\[0\].key: .* has no size 'layer9'"):
        barbule.atlas(plan, tmp_path / "s.zarr", progress=False)
    with pytest.raises(barbule.InputError, match="'shard': part 2 of 2"):
        barbule.atlas(plan, tmp_path / "s.zarr", shard=(2, 2), progress=False)
