"""Whole scenes in Mitsuba against the program's own pictures."""

import numpy as np
import pytest

import barbule
from test_mitsuba import mi  # finds a libLLVM, or skips all of this

import drjit as dr  # noqa: E402

import barbule.mitsuba  # noqa: E402
from barbule.mitsuba._keratin import Keratin  # noqa: E402

SIZE = (96, 96)
#: A few cells of barbules that fill the picture: a pixel is 2.3 µm wide.
CLOSE = 'preset = "starling"\n[camera]\nwidth_mm = 0.22\nlens = 0.0\n[window]\nradius_mm = 1.4\n'


@pytest.fixture(autouse=True)
def variant():
    mi.set_variant("llvm_ad_spectral")


def split_mix(state):
    mask = 2**64 - 1
    state = (state + 0x9E3779B97F4A7C15) & mask
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & mask
    return state ^ (state >> 31)


def linear(scene, samples, seed=0):
    """Linear sRGB and alpha."""
    return np.array(mi.render(scene, spp=samples, seed=seed))


def seen_cells(scene, width, height):
    """The barbule and the cell of it at the middle of each pixel; 0 of what is no barbule."""
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    place = mi.Point2f(mi.Float(x.ravel()), mi.Float(y.ravel()))
    ray, _ = scene.sensors()[0].sample_ray(0.0, 0.5, place, mi.Point2f(0.5))
    si = scene.ray_intersect(ray)
    is_ribbon = si.is_valid() & si.shape.has_attribute("face_inst")
    bits = np.array(si.shape.eval_attribute_3("face_inst", si, is_ribbon)).astype(np.uint64)
    barbule_name = bits[0] | (bits[1] << np.uint64(22)) | (bits[2] << np.uint64(44))
    cell = np.floor(np.array(si.uv.x)).astype(np.int64)
    is_ribbon = np.array(is_ribbon)
    barbule_name[~is_ribbon], cell[~is_ribbon] = 0, 0
    return barbule_name.reshape(height, width), cell.reshape(height, width)


def inside(labels):
    """Pixels whose neighbours have the same label: a pixel's tent reaches into them."""
    middle = labels[1:-1, 1:-1]
    same = np.ones_like(middle, dtype=bool)
    for i in range(3):
        for j in range(3):
            same &= labels[i : i + middle.shape[0], j : j + middle.shape[1]] == middle
    return np.pad(same, 1)


def compare(toml, samples, tmp_path):
    """Both pictures, the ΔE00 of each cell, and the ratio of both mean luminances."""
    opened = barbule.Scene.parse(toml)
    own = opened.render(SIZE, samples, progress=False).planes()
    scene = mi.load_dict(barbule.mitsuba.scene(opened, tmp_path, size=SIZE, progress=False))
    other = linear(scene, samples)[..., :3]
    names, cells = seen_cells(scene, *SIZE)
    # Two numbers in one label; cells are fewer than a thousand.
    _, number = np.unique(names, return_inverse=True)
    labels = number.reshape(names.shape) * 1000 + cells
    kept = inside(labels) & (names != 0)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    # As the scene is exposed, so that white is white.
    pictures = [0.25 * picture @ to_xyz.T for picture in (own["linear_srgb"], other)]
    differences = []
    for label in np.unique(labels[kept]):
        here = kept & (labels == label)
        if here.sum() >= 12:
            differences.append(barbule.delta_e_2000(*(picture[here].mean(axis=0) for picture in pictures)))
    wanted = np.array([max(split_mix(int(name)) & 0xFFFFFFFF, 1) for name in names[kept]], dtype=np.uint32)
    agree = (wanted == own["id"][kept]).mean()
    ratio = pictures[1][..., 1].mean() / pictures[0][..., 1].mean()
    return own["linear_srgb"], other, np.array(differences), ratio, agree


def test_a_close_up_is_the_programs_cell_by_cell(tmp_path):
    _, _, differences, ratio, agree = compare(CLOSE, 256, tmp_path)
    assert agree > 0.99
    assert len(differences) > 20
    assert np.median(differences) < 2.0, np.percentile(differences, [50, 90, 100])
    assert abs(ratio - 1.0) < 0.01, ratio
