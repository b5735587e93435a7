"""Whole scenes in Mitsuba against the program's own pictures."""

import numpy as np
import pytest

import barbule
from test_mitsuba import mi, split_mix  # finds a libLLVM, or skips all of this

import drjit as dr  # noqa: E402

import barbule.mitsuba  # noqa: E402

SIZE = (96, 96)
#: A few cells of barbules that fill the picture: a pixel is 2.3 µm wide.
CLOSE = 'preset = "starling"\n[camera]\nwidth_mm = 0.22\nlens = 0.0\n[window]\nradius_mm = 1.4\n'


@pytest.fixture(autouse=True)
def variant():
    mi.set_variant("llvm_ad_spectral")


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
    _, _, differences, ratio, agree = compare(CLOSE, 128, tmp_path)
    assert agree > 0.99
    assert len(differences) > 20
    assert np.median(differences) < 2.0, np.percentile(differences, [50, 90, 100])
    assert abs(ratio - 1.0) < 0.01, ratio


def test_arches_and_other_birds(tmp_path):
    """Arched barbules with a material of their own below."""
    peafowl = 'preset = "peafowl"\n[camera]\nwidth_mm = 0.22\nlens = 0.0\n'
    _, _, differences, ratio, agree = compare(peafowl, 64, tmp_path)
    assert agree > 0.99 and np.median(differences) < 2.0 and abs(ratio - 1.0) < 0.02, (differences, ratio)


#: A diffuse floor and a ball of keratin.
STAGE = """
scatterings = 3
%s
[camera]
azimuth = 200
elevation = 35
width_mm = 6
up = "z"
%s
[[objects]]
rectangle_mm = [4, 4]
surface = "red"
[[objects]]
name = "ball"
sphere_mm = 1.0
surface = "white"
translate_mm = [0.5, 0.2, 1.2]
[surfaces.red]
type = "diffuse"
colour = "#c04030"
[surfaces.white]
type = "keratin"
roughness = 0.3
index = 1.5
melanin = 0.3
%s
"""
SUN = "[light]\nazimuth = 150\nelevation = 40\nradius_deg = 6\nstrength = 2"


def lamp(kind, more=""):
    return f"[[lights]]\ntype = '{kind}'\nposition_mm = [2, -3, 4]\nstrength = 2\n{more}"


@pytest.mark.parametrize(
    ("sky", "camera", "light"),
    [
        ("sky = 1.0", "projection = 'orthographic'", ""),
        ("sky = 0.5\nturn_deg = 40", "", SUN),
        ("sky = 0.0", "lens = 0.1", lamp("rectangle", "target_mm = [0, 0, 0]\nsize_mm = [1, 2]")),
        ("sky = 0.0", "", lamp("point")),
        ("sky = 0.0", "", lamp("spot", "target_mm = [0, 0, 0.5]\ncone_deg = 20")),
    ],
)
def test_lamps_skies_and_cameras_are_the_programs(sky, camera, light):
    """Mean colours of the picture within 1 %, those of its bright sixteenths within 3 %."""
    opened = barbule.Scene.parse(STAGE % (sky, camera, light))
    own = opened.render((64, 64), 256, progress=False).planes()["linear_srgb"]
    other = linear(mi.load_dict(barbule.mitsuba.scene(opened, size=(64, 64), progress=False)), 256)[..., :3]
    np.testing.assert_allclose(other.mean((0, 1)), own.mean((0, 1)), rtol=0.01)
    parts = [picture.reshape(4, 16, 4, 16, 3).mean((1, 3))[..., 1] for picture in (own, other)]
    bright = parts[0] > np.median(parts[0])
    np.testing.assert_allclose(parts[1][bright], parts[0][bright], rtol=0.03)


def test_keratin_is_sampled_as_it_is_evaluated():
    """The mean weight of samples is ∫ f cosθ, and the density integrates to what is not drawn below the horizon."""
    surface = mi.load_dict(
        {"type": "barbule_keratin", "roughness": 0.3, "index": 1.56, "reflectance": {"type": "uniform", "value": 0.4}}
    )
    scene = mi.load_dict({"type": "scene", "shape": {"type": "rectangle", "bsdf": surface}})
    count, random = 1 << 18, np.random.default_rng(3)
    ray = mi.Ray3f(mi.Point3f(-1.2, 0, 1.6), mi.Vector3f(0.6, 0, -0.8), 0.0, mi.Spectrum(450, 500, 550, 600))
    si = dr.gather(mi.SurfaceInteraction3f, scene.ray_intersect(ray), dr.zeros(mi.UInt32, count))
    context = mi.BSDFContext()
    _, weight = surface.sample(context, si, mi.Float(random.random(count)), mi.Point2f(random.random((2, count))))
    z, turn = random.random(count), 2 * np.pi * random.random(count)
    across = np.sqrt(1 - z * z)
    wo = mi.Vector3f(np.stack([across * np.cos(turn), across * np.sin(turn), z]))
    values, density = surface.eval_pdf(context, si, wo)
    albedo = 2 * np.pi * np.array(values)[0].mean()
    assert abs(np.array(weight)[0].mean() / albedo - 1.0) < 0.02
    assert 0.97 < 2 * np.pi * np.array(density).mean() < 1.01
    # The whole albedo is E + (1 − E) ρ.
    boundary, _ = barbule._native.keratin_boundary(0.3, 1.56)
    at = np.interp(0.8, np.linspace(0, 1, len(boundary)), boundary)
    assert abs(albedo - (at + (1 - at) * 0.4)) < 0.01


def test_scene_files_show_the_same(tmp_path):
    """As XML and as a dictionary: the same numbers."""
    opened = barbule.Scene.parse(CLOSE)
    with pytest.warns(barbule.DoubtWarning, match="cut out"):
        barbule.export(opened, "mitsuba", tmp_path / "mine.xml", picture=(24, 24), progress=False)
    from_file = linear(mi.load_file(str(tmp_path / "mine.xml")), 8, seed=5)
    scene = mi.load_dict(barbule.mitsuba.scene(opened, tmp_path / "dict", size=(24, 24), progress=False))
    np.testing.assert_allclose(linear(scene, 8, seed=5), from_file, rtol=1e-3, atol=1e-4)


def test_what_cannot_be_shown_is_refused(tmp_path):
    with pytest.raises(barbule.InputError, match="'down' cannot be shown in Mitsuba, which has nothing for fibres of hair"):
        barbule.mitsuba.scene("rock-dove", progress=False)
    with pytest.raises(barbule.InputError, match="did you mean 'down'"):
        barbule.mitsuba.scene("rock-dove", without=["donw"], progress=False)
    dove = barbule.mitsuba.scene("rock-dove", size=(16, 16), without=["down"], progress=False)
    assert not [name for name in dove if "down" in name] and dove["sensor"]["film"]["width"] == 16
    with pytest.raises(barbule.InputError, match="over the limit of 350000"):
        barbule.mitsuba.scene("magpie-feather", progress=False)
    mi.set_variant("scalar_spectral")
    with pytest.raises(Exception, match="does not compile"):
        grey = {"type": "uniform", "value": 0.5}
        mi.load_dict({"type": "barbule_keratin", "roughness": 0.3, "index": 1.5, "reflectance": grey})
