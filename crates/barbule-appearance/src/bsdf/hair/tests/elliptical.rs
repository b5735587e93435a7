//! Elliptical fibres against energy, their own sampling, and turns in space.

use super::*;
use crate::bsdf::BsdfSample;

fn fibre(height_over_width: f64, index: FibreIndex, roughness: f64, absorption: Absorption) -> Hair {
    Hair::new(HairParameters {
        longitudinal_roughness: roughness,
        azimuthal_roughness: roughness,
        scale_tilt: 0.0,
        index,
        absorption,
        height_over_width,
    })
    .unwrap()
}

fn up(azimuth: f64) -> DVec2 {
    DVec2::new(azimuth.cos(), azimuth.sin())
}

/// Heights over widths with inclinations, offsets and azimuths of the height.
const CASES: [(f64, f64, f64, f64); 7] = [
    (0.1, 0.0, 0.2, PI / 2.0),
    (0.3, 0.4, -0.9, 1.0),
    (0.6, -0.9, 0.5, -0.4),
    (0.85, 1.4, 0.3, 0.0),
    (2.0, 0.2, -0.2, PI / 2.0),
    (4.0, -0.5, 0.95, 2.2),
    (10.0, 0.7, -0.6, 1.3),
];

/// Without absorption all light leaves, at each wavelength.
#[test]
fn white_elliptical_fibres_stay_white_in_the_furnace() {
    let mut worst = [0.0_f64; 2];
    for (case, (height, inclination, offset, azimuth)) in CASES.into_iter().enumerate() {
        let index = if case % 2 == 0 { FibreIndex::Constant(1.55) } else { FibreIndex::Keratin };
        let hair = fibre(height, index, [0.15, 0.3, 0.6][case % 3], clear());
        let mut path = PATH;
        path.rotate_left(case);
        let bound = Bound::new(&hair, offset, up(azimuth), viewer(inclination, offset), Lambdas::new(path));
        let [albedo, density] = integrals(&bound);
        worst = [worst[0].max((albedo - 1.0).abs()), worst[1].max((density - 1.0).abs())];
    }
    assert!(worst[0] < 1e-6 && worst[1] < 1e-6, "{worst:?}");
}

/// With pigment. Four deviations.
#[test]
fn samples_of_elliptical_fibres_follow_their_density() {
    for (case, (height, inclination, offset, azimuth)) in CASES.into_iter().enumerate() {
        let index = if case % 2 == 0 { FibreIndex::Keratin } else { FibreIndex::Constant(1.55) };
        let absorption = Absorption::pigments(0.3, 0.2).unwrap();
        let hair = fibre(height, index, [0.2, 0.3, 0.6][case % 3], absorption);
        let bound = Bound::new(&hair, offset, up(azimuth), viewer(inclination, offset), Lambdas::new(PATH));
        let deviations = deviations(&bound, 100 + case as u64);
        assert!(deviations.abs() < 4.0, "case {case}: {deviations}");
    }
}

/// A curve's hit and a section given by itself are the same fibre, wherever it stands in space. Rounding.
#[test]
fn a_section_is_the_fibre_that_a_curve_shows() {
    let mut stream = Stream::new(43, &[]);
    let hair = fibre(0.4, FibreIndex::Keratin, 0.3, Absorption::pigments(0.6, 0.1).unwrap());
    let surface = Surface::Hair(hair.clone());
    let mut random = || DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize();
    for _ in 0..200 {
        let (axis, wo, wi) = (random(), random(), random());
        let vane_normal = random();
        let up = (vane_normal - axis * axis.dot(vane_normal)).normalize();
        let side = wo.cross(axis).normalize();
        // A round curve's normal where the ray is this far off its axis.
        let offset = 0.9 * random().x;
        let front = (wo - axis * axis.dot(wo)).normalize();
        let normal = side * offset + front * (1.0 - offset * offset).sqrt();
        let hit = Hit { normal, vane_normal, frame: Frame::new(normal, axis), ..Hit::default() };
        let on_curve = surface.bind(&hit, wo, Lambdas::new(PATH)).eval(wi);
        let section = FibreSection { axis, up, offset, pigment: 1.0 };
        let alone = hair.bind_section(&section, wo, Lambdas::new(PATH)).eval(wi);
        let across = offset * side.dot(axis.cross(up)).signum();
        let crossed = FibreSection::crossed(axis, up, across, wo);
        assert_eq!(crossed.offset, offset);
        for k in 0..WAVES {
            let (a, b) = (on_curve.f[k] * on_curve.cosine, alone.f[k] * alone.cosine);
            assert!((a - b).abs() < 1e-9 * (1.0 + a), "{a} {b}");
            assert!((on_curve.pdf[k] - alone.pdf[k]).abs() < 1e-9 * (1.0 + alone.pdf[k]));
        }
    }
}

/// Nothing is cut away by a side: every sample of a clear section arrives and weighs 1.
#[test]
fn a_section_scatters_into_the_whole_sphere() {
    let hair = fibre(3.0, FibreIndex::Constant(1.55), 0.4, clear());
    let mut stream = Stream::new(44, &[]);
    for _ in 0..2000 {
        let axis = DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize();
        let wo = DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize();
        let up = axis.any_orthonormal_vector();
        let section = FibreSection { axis, up, offset: stream.uniform(-1.0, 1.0), pigment: 1.0 };
        let bsdf = hair.bind_section(&section, wo, Lambdas::new(PATH));
        let sample = bsdf.sample([stream.unit(), stream.unit(), stream.unit()]);
        let BsdfSample { evaluation: e, .. } = sample.unwrap();
        assert!((e.f[0] * e.cosine / e.pdf[0] - 1.0).abs() < 1e-9);
    }
}

/// A nearly smooth flat fibre shows its mirror reflection where its flat side, not the curve's surface, sends it.
#[test]
fn flat_fibres_mirror_at_their_flat_side() {
    let hair = fibre(0.1, FibreIndex::Constant(1.55), 0.05, Absorption::new(|_| 50.0).unwrap());
    let wo = DVec3::new(0.5, 0.1, 0.8).normalize();
    // The viewer's ray meets the middle of the flat top.
    let offset = 0.1 * wo.x / (wo.z * wo.z + 0.01 * wo.x * wo.x).sqrt();
    let section = FibreSection { axis: DVec3::Y, up: DVec3::Z, offset, pigment: 1.0 };
    let bsdf = hair.bind_section(&section, wo, Lambdas::new(PATH));
    let at = |wi: DVec3| {
        let evaluation = bsdf.eval(wi.normalize());
        evaluation.f[0] * evaluation.cosine
    };
    let mirror = DVec3::new(-wo.x, -wo.y, wo.z);
    for nudge in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y] {
        assert!(at(mirror) > at(mirror + 0.03 * nudge));
    }
}

/// With keratin's dispersion each wavelength has the values that it has alone.
#[test]
fn dispersive_wavelengths_of_an_ellipse_do_not_know_each_other() {
    let hair = fibre(1.8, FibreIndex::Keratin, 0.1, Absorption::pigments(0.3, 0.1).unwrap());
    let (wo, wi) = (viewer(0.2, 0.7), direction(-0.25, -1.1));
    let together = scattered(&Bound::new(&hair, 0.7, up(0.3), wo, Lambdas::new(PATH)), wi);
    assert!(together.0[0] != together.0[1]);
    for (k, wavelength) in PATH.into_iter().enumerate() {
        let alone = scattered(&Bound::new(&hair, 0.7, up(0.3), wo, Lambdas::splat(wavelength)), wi);
        assert_eq!((together.0[k], together.1[k]), (alone.0[0], alone.1[0]));
    }
}
