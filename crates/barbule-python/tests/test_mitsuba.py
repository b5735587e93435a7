"""The Mitsuba plugin against the native evaluation."""

import glob
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import barbule

# Dr.Jit takes the first libLLVM that it finds, and some of those that distributions have abort; rustc's own works.
# Dr.Jit reads this when it is imported.
if "DRJIT_LIBLLVM_PATH" not in os.environ:
    found = sorted(glob.glob(os.path.expanduser("~/.rustup/toolchains/*/lib/libLLVM.so.*")))
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = found[0]

mi = pytest.importorskip("mitsuba")
dr = pytest.importorskip("drjit")

# In a process of its own, because a libLLVM that does not work ends it.
PROBE = """
import mitsuba as mi
mi.set_variant("llvm_ad_spectral")
import drjit as dr
assert dr.has_backend(dr.JitBackend.LLVM)
assert dr.allclose(dr.erf(dr.minimum(mi.Float([1, 2]), dr.maximum(mi.Float([2, 1]), 0.5))), 0.8427008, 1e-4)
"""
if subprocess.run([sys.executable, "-c", PROBE], capture_output=True).returncode != 0:
    pytest.skip("Dr.Jit finds no libLLVM that works; set DRJIT_LIBLLVM_PATH", allow_module_level=True)

mi.set_variant("llvm_ad_spectral")

import barbule.mitsuba  # noqa: E402
from barbule.mitsuba import _tables as tables_of  # noqa: E402

BIRDS = Path(__file__).parents[2] / "barbule-birds/birds"
# The last one has no halo.
MATERIALS = ["starling", "rock-dove", "mallard", str(BIRDS / "peafowl/peafowl-yellow-below.barbule")]
NM = [440.0, 510.0, 580.0, 650.0]


@pytest.fixture(autouse=True)
def variant():
    mi.set_variant("llvm_ad_spectral")


def unit(w):
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


def directions(count, seed=1):
    """Unit vectors over the hemisphere, cosine-weighted."""
    random = np.random.default_rng(seed)
    radius, turn = np.sqrt(random.random(count)), 2 * np.pi * random.random(count)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], axis=-1)


def pairs(count, seed=1):
    """Pairs of directions: a quarter anywhere, the others about the mirror direction."""
    wi, wo = directions(count, seed), directions(count, seed + 1)
    near = wi * [-1, -1, 1] + np.random.default_rng(seed + 2).normal(size=(count, 3)) * 0.1
    near[:, 2] = np.abs(near[:, 2])
    wo[count // 4 :] = near[count // 4 :]
    return wi, unit(wo)


def local(w):
    """Directions of the barbule's frame in Mitsuba's."""
    w = np.asarray(w, dtype=float)
    return mi.Vector3f(w[..., 1].ravel(), -w[..., 0].ravel(), w[..., 2].ravel())


def hits(wi, nm, names=0):
    """Surface interactions seen from `wi` of the barbule's frame; without wavelengths those of rgb variants."""
    count = len(wi)
    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = local(wi)
    if nm is not None:
        si.wavelengths = mi.Spectrum(*(mi.Float(values) for values in np.broadcast_to(nm, (count, 4)).T.copy()))
    si.prim_index = mi.UInt32(np.broadcast_to(np.uint32(names), count).copy())
    return si


def bsdf(material="starling", **more):
    return mi.load_dict({"type": "barbule", "material": material, **more})


def eval_pdf(feather, si, wo):
    values, density = feather.eval_pdf(mi.BSDFContext(), si, local(wo))
    return np.array(values).T, np.array(density)


def check_close(found, expected, tolerance=1e-4):
    """Within a part of the peak."""
    assert np.isfinite(found).all()
    assert np.abs(found - expected).max() < tolerance * expected.max()


@pytest.mark.parametrize("name", MATERIALS)
def test_values_and_densities_are_the_programs(name):
    material = barbule.Material.load(name)
    wi, wo = pairs(3000)
    nm = np.random.default_rng(5).uniform(360.0, 760.0, (3000, 4))
    names = np.arange(3000) % 7 * 1_000_003
    for instances, instance in (("none", None), ("prim", names)):
        values, density = eval_pdf(bsdf(name, instances=instances), hits(wi, nm, names), wo)
        check_close(values, material.eval(nm, wi, wo, instance) * wo[:, 2:])
        expected = material.pdf(nm, wi, wo).mean(axis=-1)
        assert (np.abs(density - expected) < 1e-4 * expected + 1e-6 * expected.max()).all()


@pytest.mark.parametrize("options", [{"reciprocity": "steeper"}, {"reciprocity": "mean"}, {"polarization": 1}, {"polarization": 2}])
def test_values_with_reciprocity_and_polarization(options):
    material = barbule.Material.load("starling", **options)
    wi, wo = pairs(1000)
    values, density = eval_pdf(bsdf(instances="prim", **options), hits(wi, NM, 5), wo)
    check_close(values, material.eval(NM, wi, wo, 5) * wo[:, 2:])
    check_close(density, material.pdf(NM, wi, wo).mean(axis=-1))


def test_both_tables_are_asked_near_the_horizon():
    material = barbule.Material.load("rock-dove:jade", reciprocity="steeper")
    rng = np.random.default_rng(2)
    phi = np.radians(rng.uniform(75.0, 89.9, (2, 1000))) * [[1.0], [-1.0]]
    theta = np.radians(rng.uniform(-4.0, 4.0, (2, 1000)))
    wi, wo = (np.stack([np.cos(t) * np.sin(p), np.sin(t), np.cos(t) * np.cos(p)], -1) for t, p in zip(theta, phi))
    values, _ = eval_pdf(bsdf("rock-dove:jade", instances="prim", reciprocity="steeper"), hits(wi, NM, 5), wo)
    expected = material.eval(NM, wi, wo, 5) * wo[:, 2:]
    check_close(values, expected)
    np.testing.assert_allclose(material.eval(NM, wo, wi, 5), material.eval(NM, wi, wo, 5), rtol=1e-4)
    one_way = barbule.Material.load("rock-dove:jade").eval(NM, wi, wo, 5) * wo[:, 2:]
    assert np.abs(one_way - expected).max() > 0.01 * expected.max()


def test_eval_and_pdf_are_those_of_eval_pdf():
    wi, wo = pairs(500)
    feather, si, context = bsdf(instances="prim"), hits(wi, NM, 3), mi.BSDFContext()
    values, density = eval_pdf(feather, si, wo)
    np.testing.assert_allclose(np.array(feather.eval(context, si, local(wo))).T, values, rtol=1e-5)
    np.testing.assert_allclose(np.array(feather.pdf(context, si, local(wo))), density, rtol=1e-5)


def with_both_sides(header, tables):
    """The same material with nodes for either sign of φ_i: those of the left are mirror images."""
    def mirrored(nodes):
        left = nodes[:, :0:-1].copy()
        m2, across, m = left[..., 0:3], left[..., 3:6], left[..., 6:9]
        mirrored_across = 1.0 - m2 - across
        # cosψ is in A of the mean lobes.
        left[..., 9:11] *= np.sqrt(mirrored_across / np.maximum(across, 1e-30))[..., :2]
        left[..., 3:6], left[..., 6:9], left[..., 15] = mirrored_across, 1.0 / m, -left[..., 15]
        return left

    def shares(values):
        # d holds cosψ too.
        left = values[:, :0:-1].copy()
        nodes = tables["nodes"][:, :0:-1]
        left[..., :2] *= np.sqrt((1.0 - nodes[..., 0:2] - nodes[..., 3:5]) / np.maximum(nodes[..., 3:5], 1e-30))
        return left

    both = dict(tables)
    both["phi"] = np.concatenate([-tables["phi"][:0:-1], tables["phi"]])
    both["tangents"] = np.concatenate([1.0 / tables["tangents"][:0:-1], tables["tangents"]])
    both["nodes"] = np.concatenate([mirrored(tables["nodes"]), tables["nodes"]], axis=1)
    both["shares"] = np.concatenate([shares(tables["shares"]), tables["shares"]], axis=1)
    for name in ("slopes", "along"):
        both[name] = np.concatenate([tables[name][:, :0:-1], tables[name]], axis=1)
    return {**header, "sides": "both", "phis": len(both["phi"])}, both


def test_both_sides_and_two_sets():
    material = barbule.Material.load("mallard")
    header, tables = material.header(), material.tables()
    wi, wo = pairs(1000)
    at = [mi.Vector3f(w.T.copy()) for w in (wi, wo)]
    nm = [mi.Float(wavelength) for wavelength in NM]
    both = tables_of.Tables(*with_both_sides(header, tables))
    for name in (None, 11):
        found, density = both.evaluate(*at, nm, None if name is None else mi.UInt64(name))
        check_close(np.array(found).T, material.eval(NM, wi, wo, name) * wo[:, 2:])
        check_close(np.array(density), material.pdf(NM, wi, wo).mean(axis=-1))
    # Two sets alike, each of half of the light.
    twice = {name: array for name, array in tables.items() if name not in ("nodes", "shares")}
    nodes = tables["nodes"].copy()
    nodes[..., 14], nodes[..., 15] = 0.5, 0.0
    for number in ("p1.", "p2."):
        twice[number + "nodes"], twice[number + "shares"] = nodes, tables["shares"]
    found, density = tables_of.Tables({**header, "sets": 2}, twice).evaluate(*at, nm)
    check_close(np.array(found).T, material.eval(NM, wi, wo) * wo[:, 2:])
    check_close(np.array(density), material.pdf(NM, wi, wo).mean(axis=-1))


def test_uneven_axes():
    nodes = np.array([0.0, 0.001, 0.0015, 0.2, 0.5, 0.55, 1.0])
    x = np.random.default_rng(2).uniform(-0.1, 1.1, 4000)
    x[:1000] *= 0.002
    place, share = tables_of.Axis(nodes).find(mi.Float(x))
    place, share = np.array(place), np.array(share)
    low = np.clip(np.searchsorted(nodes, x, "right") - 1, 0, 5)
    np.testing.assert_allclose(place + share, low + np.clip((x - nodes[low]) / np.diff(nodes)[low], 0, 1), atol=1e-3)


@pytest.mark.parametrize("name", ["starling", "rock-dove"])
def test_samples_weigh_what_the_material_reflects(name):
    material, feather = barbule.Material.load(name), bsdf(name)
    count = 1 << 16
    random = np.random.default_rng(7)
    # Stratified: an error of 1 % is far off.
    u = (np.arange(count) + random.random(count)) / count
    for wi in unit(np.array([[0.0, 0.0, 1.0], [0.4, 0.3, 0.8], [-0.9, 0.2, 0.5]])):
        si = hits(np.broadcast_to(wi, (count, 3)), NM)
        sampled, weights = feather.sample(mi.BSDFContext(), si, mi.Float(u), mi.Point2f(random.random((2, count))))
        weights = np.array(weights)
        assert np.isfinite(weights).all()
        albedo = material.albedo(NM, wi)
        np.testing.assert_allclose(weights.mean(axis=1), albedo, rtol=0.01)
        assert (albedo < 1.0).all()
        density = np.array(sampled.pdf)
        again = np.array(feather.pdf(mi.BSDFContext(), si, sampled.wo))
        np.testing.assert_allclose(again[density > 0], density[density > 0], rtol=1e-3)


def grid(theta, phi):
    """Directions of the barbule's frame on a grid of θ_o and φ_o, radians."""
    theta, phi = np.meshgrid(theta, phi, indexing="ij")
    return np.stack([np.cos(theta) * np.sin(phi), np.sin(theta), np.cos(theta) * np.cos(phi)], axis=-1)


def middles(low, high, count):
    edges = np.linspace(low, high, count + 1)
    return 0.5 * (edges[1:] + edges[:-1])


@pytest.mark.parametrize("wi", [[0.0, 0.1, 1.0], [0.5, -0.6, 0.6]])
def test_the_density_integrates_to_1(wi):
    theta, phi = middles(-np.pi / 2, np.pi / 2, 600), middles(-np.pi / 2, np.pi / 2, 600)
    wo = grid(theta, phi).reshape(-1, 3)
    wi = np.broadcast_to(unit(np.array(wi)), wo.shape)
    density = np.array(bsdf().pdf(mi.BSDFContext(), hits(wi, NM), local(wo))).reshape(600, 600)
    total = (density * np.cos(theta)[:, None]).sum() * (np.pi / 600) ** 2
    assert abs(total - 1.0) < 2e-3


def test_samples_follow_the_density():
    """χ² in bins of a fourth of σ along θ and 3.6° along φ; whatever falls outside is one more bin."""
    wi, count, fine = unit(np.array([0.3, 0.2, 1.0])), 1 << 18, 6
    feather, random = bsdf("starling"), np.random.default_rng(9)
    si = hits(np.broadcast_to(wi, (count, 3)), NM)
    u1, u2 = mi.Float(random.random(count)), mi.Point2f(random.random((2, count)))
    sampled, _ = feather.sample(mi.BSDFContext(), si, u1, u2)
    w, density = np.array(sampled.wo), np.array(sampled.pdf)
    w = w[:, density > 0]
    theta, phi = np.arcsin(np.clip(w[0], -1, 1)), np.arctan2(-w[1], w[2])
    mirror = -np.arcsin(wi[1])
    bounds = [[mirror - 0.16, mirror + 0.16], [-np.pi / 2, np.pi / 2]]
    seen, *_ = np.histogram2d(theta, phi, bins=(32, 50), range=bounds)
    at = [middles(*bound, fine * bins) for bound, bins in zip(bounds, (32, 50))]
    wo = grid(*at).reshape(-1, 3)
    area = 0.32 / (32 * fine) * np.pi / (50 * fine)
    pdf = np.array(feather.pdf(mi.BSDFContext(), hits(np.broadcast_to(wi, wo.shape), NM), local(wo)))
    mass = pdf.reshape(32 * fine, 50 * fine) * np.cos(at[0])[:, None] * area
    expected = count * mass.reshape(32, fine, 50, fine).sum(axis=(1, 3))
    seen, expected = seen.ravel(), expected.ravel()
    kept = expected > 20
    seen = np.append(seen[kept], count - seen[kept].sum())
    expected = np.append(expected[kept], count - expected[kept].sum())
    chi2, degrees = ((seen - expected) ** 2 / expected).sum(), len(expected) - 1
    assert degrees > 500
    # Wilson & Hilferty: nearly normal.
    deviate = ((chi2 / degrees) ** (1 / 3) - (1 - 2 / (9 * degrees))) / np.sqrt(2 / (9 * degrees))
    assert deviate < 3.5, (chi2, degrees)


def test_the_barbule_lies_along_u():
    """On a rectangle u grows along the world's x and the normal is z: the barbule's x is −y of the world."""
    material = barbule.Material.load("starling")
    surface = {"type": "barbule", "material": "starling", "instances": "prim"}
    scene = mi.load_dict({"type": "scene", "shape": {"type": "rectangle", "bsdf": surface}})
    towards, away = unit(np.array([0.1, 0.35, 0.9])), unit(np.array([-0.13, -0.1, 0.95]))
    ray = mi.Ray3f(mi.Point3f((2.0 * towards).tolist()), mi.Vector3f((-towards).tolist()), 0.0, mi.Spectrum(*NM))
    si = scene.ray_intersect(ray)
    values = np.array(si.bsdf().eval(mi.BSDFContext(), si, si.to_local(mi.Vector3f(away.tolist())))).ravel()
    wi, wo = (np.array([-w[1], w[0], w[2]]) for w in (towards, away))
    expected = material.eval(NM, wi, wo, 0) * wo[2]
    np.testing.assert_allclose(values, expected, rtol=1e-3)
    mirrored = material.eval(NM, wi * [-1, 1, 1], wo * [-1, 1, 1], 0) * wo[2]
    assert np.abs(mirrored - expected).max() > 0.1 * expected.max()


def test_the_lower_side_is_turned_about_the_barbule():
    wi, wo = pairs(200)
    turn = np.array([-1, 1, -1])
    above, _ = eval_pdf(bsdf(instances="prim"), hits(wi, NM, 4), wo)
    below, density = eval_pdf(bsdf(instances="prim", two_sided=True), hits(wi * turn, NM, 4), wo * turn)
    np.testing.assert_allclose(below, above, rtol=1e-4, atol=1e-5)
    dark, density = eval_pdf(bsdf(), hits(wi * turn, NM), wo * turn)
    assert not dark.any() and not density.any()


def split_mix(state):
    mask = 2**64 - 1
    state = (state + 0x9E3779B97F4A7C15) & mask
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & mask
    return state ^ (state >> 31)


@pytest.mark.parametrize("name", ["llvm_ad_spectral", "scalar_spectral"])
def test_cells_are_named_as_in_scenes(name):
    """By 64 bits in three singles of a face, and by u; by u and v."""
    mi.set_variant(name)
    barbule_name = 0xFEDC_BA98_7654_3210
    bits = [barbule_name & 0x3FFFFF, barbule_name >> 22 & 0x3FFFFF, barbule_name >> 44]
    material = barbule.Material.load("starling")
    wi, wo = unit(np.array([0.1, 0.05, 1.0])), unit(np.array([-0.2, -0.08, 1.0]))
    face = split_mix(barbule_name ^ split_mix(5))
    cell = split_mix(split_mix(3) ^ split_mix(2**64 - 2))
    for instances, uv, expected in (("face", (5.3, 0.5), face), ("uv", (-0.13, 0.39), cell)):
        properties = mi.Properties()
        properties["mesh_bsdf"] = mi.load_dict({"type": "barbule", "material": "starling", "instances": instances, "cells": 10.0})
        mesh = mi.Mesh("ribbon", 3, 1, has_vertex_texcoords=True, props=properties)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = [-1, -1, 0, 3, -1, 0, -1, 3, 0]
        parameters["vertex_texcoords"] = [uv[0] - 0.01, uv[1] - 0.01, uv[0] + 0.03, uv[1] - 0.01, uv[0] - 0.01, uv[1] + 0.03]
        parameters["faces"] = [0, 1, 2]
        parameters.update()
        mesh.add_attribute("face_inst", 3, [float(b) for b in bits])
        scene = mi.load_dict({"type": "scene", "mesh": mesh})
        si = scene.ray_intersect(mi.Ray3f([0, 0, 2], [0, 0, -1]))
        si.wavelengths = mi.Spectrum(*NM)
        si.wi, direction = (mi.Vector3f(float(w[1]), float(-w[0]), float(w[2])) for w in (wi, wo))
        values = np.array(si.bsdf().eval(mi.BSDFContext(), si, direction)).ravel()
        np.testing.assert_allclose(values, material.eval(NM, wi, wo, np.uint64(expected)) * wo[2], rtol=2e-3)


@pytest.mark.parametrize("name", ["scalar_spectral", "scalar_spectral_polarized", "llvm_ad_spectral_polarized"])
def test_other_variants(name):
    material = barbule.Material.load("starling")
    mi.set_variant(name)
    if name not in mi.variants():
        pytest.skip(f"this Mitsuba has no {name}")
    wi, wo = unit(np.array([0.3, 0.1, 1.0])), unit(np.array([-0.25, -0.12, 1.0]))
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi, away = (mi.Vector3f(float(w[1]), float(-w[0]), float(w[2])) for w in (wi, wo))
    si.wavelengths, si.prim_index = mi.UnpolarizedSpectrum(NM), 9
    feather = bsdf(instances="prim")
    values, density = feather.eval_pdf(mi.BSDFContext(), si, away)
    if mi.is_polarized:
        values = mi.unpolarized_spectrum(values)
    np.testing.assert_allclose(np.array(values).ravel(), material.eval(NM, wi, wo, 9) * wo[2], rtol=1e-3)
    np.testing.assert_allclose(np.array(density), material.pdf(NM, wi, wo).mean(), rtol=1e-3)
    sampled, weight = feather.sample(mi.BSDFContext(), si, 0.3, mi.Point2f(0.4, 0.6))
    again, density = feather.eval_pdf(mi.BSDFContext(), si, sampled.wo)
    np.testing.assert_allclose(np.array(density), np.array(sampled.pdf), rtol=1e-3)
    np.testing.assert_allclose(np.array(weight * density), np.array(again), rtol=1e-3, atol=1e-6)


def picture(surface, samples=16):
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 3},
            "sensor": {
                "type": "perspective",
                "fov": 35,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}},
                "sampler": {"type": "independent", "sample_count": samples},
            },
            "light": {"type": "constant"},
            "shape": {"type": "sphere", "bsdf": surface},
        }
    )
    return np.array(mi.render(scene, seed=1))


def test_pictures():
    surface = {"type": "barbule", "material": "starling", "instances": "uv", "cells": 30.0, "two_sided": True}
    compiled = picture(surface)
    mi.set_variant("scalar_spectral")
    plain = picture(surface, 2)
    for image in (compiled, plain):
        assert image.shape == (32, 32, 3) and np.isfinite(image).all() and image.max() > 0.0
    middle = (slice(12, 20), slice(12, 20))
    assert compiled[middle].mean() < 1.05
    np.testing.assert_allclose(plain.mean(axis=(0, 1)), compiled.mean(axis=(0, 1)), rtol=0.05)


@pytest.mark.parametrize("name", ["llvm_ad_spectral", "scalar_spectral"])
def test_films_reflect_exactly(name):
    mi.set_variant(name)
    mirror = mi.load_dict({"type": "barbule_film", "stack": "air/keratin:595/air"})
    expected = barbule.film("air/keratin:595/air", NM, [33.0])
    angle = np.radians(33.0)
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi, si.wavelengths = mi.Vector3f(float(np.sin(angle)), 0.0, float(np.cos(angle))), mi.UnpolarizedSpectrum(NM)
    sampled, weight = mirror.sample(mi.BSDFContext(), si, 0.5, mi.Point2f(0.5, 0.5))
    mean = 0.5 * (np.asarray(expected["R_s"]) + np.asarray(expected["R_p"]))[0]
    np.testing.assert_allclose(np.array(weight).ravel(), mean, atol=1e-4)
    np.testing.assert_allclose(np.array(sampled.wo).ravel(), [-np.sin(angle), 0.0, np.cos(angle)], atol=1e-6)
    assert mi.has_flag(mirror.flags(), mi.BSDFFlags.DeltaReflection)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"material": "starlng"}, "did you mean 'starling'"),
        ({"instances": "cell"}, "none, uv, face, prim"),
        ({"cells": 0.0}, "number over 0"),
        ({"reciprocity": "some"}, "none, steeper, mean"),
        ({"polarization": 3}, "give 1 or 2"),
    ],
)
def test_bad_parameters_are_refused(options, words):
    with pytest.raises(Exception, match=words):
        bsdf(**options)


def test_variants_without_colours_are_refused():
    mi.set_variant("llvm_ad_mono")
    with pytest.raises(Exception, match="'llvm_ad_mono' has no colours"):
        bsdf()


@pytest.mark.parametrize("variant_name", ["llvm_ad_rgb", "scalar_rgb"])
def test_colours_of_rgb_variants_are_those_in_daylight(variant_name):
    """Linear sRGB in D65, within sRGB: ΔE00 against 61 wavelengths of the native evaluation."""
    fine, material = np.arange(400.0, 701.0, 5.0), barbule.Material.load("starling")
    wi, wo = pairs(400)
    expected = barbule.colours(fine, material.eval(fine, wi, wo, np.arange(400)) * wo[:, 2:])["linear_srgb"].values
    kept = np.flatnonzero((expected > 0.0).all(axis=1) & (expected.max(axis=1) > 0.02))
    kept = kept[:20] if variant_name == "scalar_rgb" else kept
    wi, wo, expected = wi[kept], wo[kept], expected[kept]
    mi.set_variant(variant_name)
    feather = bsdf(instances="prim")
    if variant_name == "llvm_ad_rgb":
        si = hits(wi, None, kept)
        found = np.array(feather.eval(mi.BSDFContext(), si, local(wo))).T
    else:
        rows = []
        for i, k in enumerate(kept):
            si = mi.SurfaceInteraction3f()
            si.wi, si.prim_index = mi.Vector3f(wi[i, 1], -wi[i, 0], wi[i, 2]), int(k)
            rows.append(np.array(feather.eval(mi.BSDFContext(), si, mi.Vector3f(wo[i, 1], -wo[i, 0], wo[i, 2]))))
        found = np.array(rows)
    # As bright as white at most, as screens show them.
    scale = 1.0 / np.maximum(expected.max(axis=1, keepdims=True), 1.0)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    pairs_of_xyz = zip((found * scale) @ to_xyz.T, (expected * scale) @ to_xyz.T)
    difference = np.array([barbule.delta_e_2000(*pair) for pair in pairs_of_xyz])
    assert np.median(difference) < 0.5 and np.percentile(difference, 95) < 2.0, np.percentile(difference, [50, 95, 100])


def test_barbules_may_lie_along_v():
    """As on curves of B-splines: what Mitsuba calls t is the barbule's y."""
    material = barbule.Material.load("starling")
    wi, wo = pairs(200)
    si = hits(wi, NM, 2)
    si.wi = mi.Vector3f(wi.T.copy())
    values = np.array(bsdf(instances="prim", along="v").eval(mi.BSDFContext(), si, mi.Vector3f(wo.T.copy()))).T
    check_close(values, material.eval(NM, wi, wo, 2) * wo[:, 2:])


def test_a_variant_must_be_set_first():
    found = subprocess.run([sys.executable, "-c", "import barbule.mitsuba"], capture_output=True, text=True)
    assert found.returncode == 1 and "set a variant before barbule.mitsuba is imported" in found.stderr
