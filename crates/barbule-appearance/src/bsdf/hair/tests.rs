//! The fibre against energy, its own sampling and geometric optics.

mod elliptical;

use std::f64::consts::PI;

use super::*;
use crate::bsdf::{Frame, Surface};
use crate::math::rng::Stream;
use crate::spectrum::dense::WAVES;

const PATH: [f64; WAVES] = [550.0, 610.0, 470.0, 510.0, 400.0, 430.0, 650.0, 690.0];

fn clear() -> Absorption {
    Absorption::new(|_| 0.0).unwrap()
}

fn hair(m: f64, n: f64, tilt_deg: f64, absorption: Absorption) -> Hair {
    Hair::new(HairParameters {
        longitudinal_roughness: m,
        azimuthal_roughness: n,
        scale_tilt: tilt_deg.to_radians(),
        index: FibreIndex::Constant(1.55),
        absorption,
        height_over_width: 1.0,
    })
    .unwrap()
}

/// Towards the viewer at an inclination, in the frame of a point that the ray meets at an offset.
fn viewer(inclination: f64, offset: f64) -> DVec3 {
    let (sin, cos) = inclination.sin_cos();
    DVec3::new(cos * offset, sin, cos * (1.0 - offset * offset).sqrt())
}

fn direction(sin: f64, azimuth: f64) -> DVec3 {
    let cos = (1.0 - sin * sin).max(0.0).sqrt();
    DVec3::new(cos * azimuth.cos(), sin, cos * azimuth.sin())
}

/// f |cos| and the density, at each wavelength.
fn scattered(bound: &Bound<'_>, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
    let (f, pdf) = bound.eval(DVec3::ZERO, wi);
    (f.map(|f| f * wi.z.abs()), pdf)
}

/// ∫ over the sphere of f |cos| and of the density at the first wavelength: Simpson in the inclination (its derivatives
/// vanish with the solid angle at the poles), midpoints around the fibre. Both resolve a width of 0.05.
fn integrals(bound: &Bound<'_>) -> [f64; 2] {
    let (rows, columns) = (1200, 720);
    let mut sums = [0.0; 2];
    for i in 1..rows {
        let theta = PI * (f64::from(i) / f64::from(rows) - 0.5);
        let weight = (2.0 + 2.0 * f64::from(i % 2)) * theta.cos();
        for j in 0..columns {
            let azimuth = TAU * (f64::from(j) + 0.5) / f64::from(columns);
            let (f, pdf) = scattered(bound, direction(theta.sin(), azimuth));
            sums[0] += weight * f[0];
            sums[1] += weight * pdf[0];
        }
    }
    sums.map(|sum| sum * PI / f64::from(3 * rows) * TAU / f64::from(columns))
}

/// Without absorption all light leaves, at every offset, up to grazing, tilted scales or not. What is left is the
/// approximation of I₀ and the quadrature.
#[test]
fn white_fibres_stay_white_in_the_furnace() {
    let mut worst = [0.0_f64; 2];
    for (m, n, tilt) in
        [(0.1, 0.15, 0.0), (0.2, 0.3, 2.0), (0.3, 0.3, -5.0), (0.6, 0.5, 3.0), (1.0, 1.0, 0.0)]
    {
        let hair = hair(m, n, tilt, clear());
        for (inclination, offset) in
            [(0.0, 0.0), (0.4, 0.6), (-0.9, -0.95), (1.4, 0.3), (-1.55, 0.999), (0.2, 1.0)]
        {
            let bound = Bound::new(&hair, offset, DVec2::Y, viewer(inclination, offset), Lambdas::new(PATH));
            let [albedo, density] = integrals(&bound);
            worst = [worst[0].max((albedo - 1.0).abs()), worst[1].max((density - 1.0).abs())];
        }
    }
    println!("worst deviation of the albedo and of the density's integral: {worst:?}");
    assert!(worst[0] < FURNACE && worst[1] < FURNACE, "{worst:?}");
}

/// Reached: 4.4e-7, the error of the approximation of I₀.
const FURNACE: f64 = 1e-6;

/// Over the fibre's width, and with absorption less than all leaves: exactly the mean of the ways' powers.
#[test]
fn absorbing_fibres_keep_what_their_ways_keep() {
    let hair = hair(0.3, 0.4, 2.0, Absorption::pigments(0.6, 0.1).unwrap());
    let count = 16;
    let (mut albedo, mut powers) = (0.0, 0.0);
    for i in 0..count {
        let offset = 2.0 * (f64::from(i) + 0.5) / f64::from(count) - 1.0;
        let bound = Bound::new(&hair, offset, DVec2::Y, viewer(0.5, offset), Lambdas::new(PATH));
        let [own, density] = integrals(&bound);
        assert!((density - 1.0).abs() < FURNACE);
        albedo += own / f64::from(count);
        powers += bound.powers.of.iter().map(|way| way[0]).sum::<f64>() / f64::from(count);
    }
    assert!((albedo - powers).abs() < FURNACE, "{albedo} {powers}");
    assert!((0.2..0.8).contains(&albedo));
}

/// How many deviations the counts of samples over the whole sphere lie from integrals of the density: χ², with that of
/// Wilson and Hilferty, the cube root of χ² over its degrees being nearly normal.
fn deviations(bound: &Bound<'_>, seed: u64) -> f64 {
    const ROWS: usize = 24;
    const COLUMNS: usize = 16;
    const FINE: usize = 24;
    let count = 200_000;
    let mut seen = vec![0.0; ROWS * COLUMNS];
    let mut stream = Stream::new(31, &[seed]);
    for _ in 0..count {
        let u = [stream.unit(), stream.unit(), stream.unit()];
        let (wi, lobes) = bound.sample(DVec3::ZERO, u).unwrap();
        assert!((wi.length() - 1.0).abs() < 1e-12);
        assert_eq!(lobes.has(Lobes::REFLECTION), wi.z > 0.0);
        let row = ((0.5 * (wi.y + 1.0) * ROWS as f64) as usize).min(ROWS - 1);
        let column = (wi.z.atan2(wi.x).rem_euclid(TAU) / TAU * COLUMNS as f64) as usize;
        seen[row * COLUMNS + column.min(COLUMNS - 1)] += 1.0;
    }
    let mut expected = vec![0.0; ROWS * COLUMNS];
    let step = 2.0 * TAU / (ROWS * FINE * COLUMNS * FINE) as f64;
    for i in 0..ROWS * FINE {
        for j in 0..COLUMNS * FINE {
            let y = 2.0 * (i as f64 + 0.5) / (ROWS * FINE) as f64 - 1.0;
            let azimuth = TAU * (j as f64 + 0.5) / (COLUMNS * FINE) as f64;
            let pdf = scattered(bound, direction(y, azimuth)).1[0];
            expected[(i / FINE) * COLUMNS + j / FINE] += f64::from(count) * step * pdf;
        }
    }
    let (mut chi2, mut degrees) = (0.0, -1.0);
    for (seen, expected) in seen.iter().zip(&expected) {
        if *expected > 8.0 {
            chi2 += (seen - expected).powi(2) / expected;
            degrees += 1.0;
        }
    }
    let spread = 2.0 / (9.0 * degrees);
    let deviations = (f64::cbrt(chi2 / degrees) - (1.0 - spread)) / f64::sqrt(spread);
    println!("chi2 {chi2:.1} of {degrees} degrees, {deviations:.2} deviations");
    deviations
}

/// Four deviations.
#[test]
fn samples_follow_their_density_over_the_whole_sphere() {
    let absorption = Absorption::pigments(0.3, 0.2).unwrap();
    for (case, (m, n, tilt, inclination, offset)) in [
        (0.1, 0.2, 2.0, 0.3, 0.5),
        (0.25, 0.3, 0.0, -1.2, -0.8),
        (0.5, 0.6, -3.0, 0.9, 0.0),
        (1.0, 1.0, 2.0, 0.0, 0.99),
    ]
    .into_iter()
    .enumerate()
    {
        let hair = hair(m, n, tilt, absorption.clone());
        let bound = Bound::new(&hair, offset, DVec2::Y, viewer(inclination, offset), Lambdas::new(PATH));
        let deviations = deviations(&bound, case as u64);
        assert!(deviations.abs() < 4.0, "case {case}: {deviations}");
    }
}

/// Every sample weighs the albedo, at each wavelength if that were the hero.
#[test]
fn samples_all_weigh_the_albedo() {
    let mut stream = Stream::new(41, &[]);
    for index in [FibreIndex::Constant(1.55), FibreIndex::Keratin] {
        let hair = Hair::new(HairParameters {
            longitudinal_roughness: 0.25,
            azimuthal_roughness: 0.3,
            scale_tilt: 0.03,
            index,
            absorption: Absorption::pigments(0.6, 0.1).unwrap(),
            height_over_width: 1.0,
        })
        .unwrap();
        for _ in 0..200 {
            let offset = stream.uniform(-1.0, 1.0);
            let wo = viewer(stream.uniform(-1.5, 1.5), offset);
            let bound = Bound::new(&hair, offset, DVec2::Y, wo, Lambdas::new(PATH));
            let u = [stream.unit(), stream.unit(), stream.unit()];
            let (wi, _) = bound.sample(wo, u).unwrap();
            let (f, pdf) = scattered(&bound, wi);
            for k in 0..WAVES {
                let albedo: f64 = bound.powers.of.iter().map(|way| way[k]).sum();
                assert!((f[k] / pdf[k] / albedo - 1.0).abs() < 1e-12);
            }
        }
    }
}

/// Numbers of 0 and nearly 1 give directions too.
#[test]
fn the_ends_of_uniform_numbers_give_directions() {
    let hair = hair(0.02, 0.02, 2.0, Absorption::pigments(8.0, 0.0).unwrap());
    let last = 1.0 - f64::EPSILON;
    for inclination in [0.0, 1.57, -1.5] {
        for offset in [-1.0, 0.0, 0.7] {
            let bound = Bound::new(&hair, offset, DVec2::Y, viewer(inclination, offset), Lambdas::new(PATH));
            for corner in 0..8 {
                let u = [0, 1, 2].map(|bit| if corner >> bit & 1 == 1 { last } else { 0.0 });
                let (wi, _) = bound.sample(DVec3::ZERO, u).unwrap();
                let (f, pdf) = scattered(&bound, wi);
                assert!(wi.is_finite() && f.iter().chain(&pdf).all(|v| v.is_finite() && *v >= 0.0));
            }
        }
    }
}

/// A nearly smooth fibre is brightest where geometric optics sends its light.
#[test]
fn smooth_fibres_scatter_where_rays_go() {
    let hair = hair(0.02, 0.02, 0.0, clear());
    for (inclination, offset) in [(0.3, 0.4), (-0.7, -0.2)] {
        let wo = viewer(inclination, offset);
        let bound = Bound::new(&hair, offset, DVec2::Y, wo, Lambdas::new(PATH));
        // R: the mirror direction about the normal z.
        let mirror = DVec3::new(-wo.x, -wo.y, wo.z);
        let at = |wi: DVec3| scattered(&bound, wi).0[0];
        for nudge in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y] {
            assert!(at(mirror) > at((mirror + 0.02 * nudge).normalize()));
        }
        // TT: refraction in and out turns towards the far side; the inclination stays.
        let (inside, outside) = (
            libm::asin(offset * inclination.cos() / (1.55_f64.powi(2) - wo.y * wo.y).sqrt()),
            libm::asin(offset),
        );
        let azimuth = wo.z.atan2(wo.x) + PI + 2.0 * (outside - inside);
        let through = direction(-wo.y, azimuth);
        for nudge in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y] {
            assert!(at(through) > at((through + 0.02 * nudge).normalize()));
        }
    }
}

/// Scales open towards the tip: the mirror lobe leans to the root by 2α, light through the fibre to the tip.
#[test]
fn scales_turn_the_lobes_the_right_way() {
    let tilt = 3_f64.to_radians();
    let hair = hair(0.05, 0.3, 3.0, Absorption::new(|_| 0.5).unwrap());
    let bound = Bound::new(&hair, 0.0, DVec2::Y, viewer(0.2, 0.0), Lambdas::new(PATH));
    let brightest = |azimuth: f64| {
        let at = |theta: f64| scattered(&bound, direction(f64::sin(theta), azimuth)).0[0];
        let thetas = (-800..800).map(|i| 1e-3 * f64::from(i));
        thetas.max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap()
    };
    assert!((brightest(-PI / 2.0) - (-0.2 + tilt)).abs() < 0.01, "TT {}", brightest(-PI / 2.0));
    // R and TRT leave on the same side; without a way through only R is left.
    let black = self::hair(0.05, 0.3, 3.0, Absorption::new(|_| 50.0).unwrap());
    let bound = Bound::new(&black, 0.0, DVec2::Y, viewer(0.2, 0.0), Lambdas::new(PATH));
    let at = |theta: f64| scattered(&bound, direction(theta.sin(), PI / 2.0)).0[0];
    assert!(at(-0.2 - 2.0 * tilt) > 2.0 * at(-0.2 + 2.0 * tilt));
}

/// Averaged over the width, directions of equal inclination may be exchanged when scales lie flat; others may not, since the
/// powers are those of the viewer's inclination. Midpoints over the width: 1e-3.
#[test]
fn the_mean_over_the_width_is_reciprocal_between_equal_inclinations() {
    let hair = hair(0.3, 0.3, 0.0, Absorption::pigments(0.6, 0.1).unwrap());
    let mean = |theta_o: f64, theta_i: f64, azimuth: f64| {
        let count = 400;
        (0..count)
            .map(|i| {
                let offset = 2.0 * (f64::from(i) + 0.5) / f64::from(count) - 1.0;
                let wo = DVec3::new(0.0, theta_o.sin(), theta_o.cos());
                let bound = Bound::new(&hair, offset, DVec2::Y, wo, Lambdas::new(PATH));
                scattered(&bound, direction(theta_i.sin(), PI / 2.0 + azimuth)).0[0] / f64::from(count)
            })
            .sum::<f64>()
    };
    for azimuth in [0.3, 1.5, 2.8] {
        let (there, back) = (mean(0.6, 0.6, azimuth), mean(0.6, 0.6, -azimuth));
        assert!((there / back - 1.0).abs() < 1e-9, "{there} {back}");
        let (there, back) = (mean(0.6, -0.6, azimuth), mean(-0.6, 0.6, -azimuth));
        assert!((there / back - 1.0).abs() < 1e-9, "{there} {back}");
        let (there, back) = (mean(0.5, -0.8, azimuth), mean(-0.8, 0.5, -azimuth));
        println!("exchange of 0.5 and -0.8 rad at azimuth {azimuth}: {:.3}", there / back);
        assert!((0.5..2.0).contains(&(there / back)));
    }
}

/// Mean albedo over a fibre's width, seen across it.
fn albedo(absorption: &Absorption, wavelength_nm: f64) -> f64 {
    let hair = hair(0.3, 0.3, 2.0, absorption.clone());
    let count = 200;
    let path = Lambdas::splat(wavelength_nm);
    (0..count)
        .map(|i| {
            let offset = 2.0 * (f64::from(i) + 0.5) / f64::from(count) - 1.0;
            let bound = Bound::new(&hair, offset, DVec2::Y, viewer(0.0, offset), path);
            1.0 / bound.powers.inverse_albedo[0] / f64::from(count)
        })
        .sum()
}

/// More pigment is darker at every wavelength; pigments take blue first; pheomelanin reddens. A black hair keeps only
/// the surface's reflection: the mean of Fresnel's over the width, 8 % for 1.55.
#[test]
fn pigments_darken_and_redden() {
    let of = |eumelanin, pheomelanin| {
        let absorption = Absorption::pigments(eumelanin, pheomelanin).unwrap();
        [450.0, 550.0, 650.0].map(|w| albedo(&absorption, w))
    };
    let (blond, brown, black, red) = (of(0.3, 0.0), of(1.3, 0.0), of(8.0, 0.0), of(0.3, 0.7));
    println!(
        "albedo at 450, 550, 650 nm: blond {blond:.3?} brown {brown:.3?} black {black:.3?} red {red:.3?}"
    );
    for k in 0..3 {
        assert!(blond[k] > brown[k] && brown[k] > black[k]);
    }
    for colour in [blond, brown, red] {
        assert!(colour[2] > colour[1] && colour[1] > colour[0]);
    }
    assert!(red[2] / red[0] > 1.3 * blond[2] / blond[0]);
    let surface = albedo(&Absorption::new(|_| 1e6).unwrap(), 550.0);
    assert!((black[0] - surface) < 1e-3 && (0.06..0.11).contains(&surface), "{surface}");
}

/// The frame may be turned in space.
#[test]
fn a_bound_fibre_is_the_same_in_every_frame() {
    let fibre = hair(0.3, 0.3, 2.0, Absorption::pigments(0.6, 0.1).unwrap());
    let offset = 0.6;
    let wo = viewer(0.3, offset);
    let own = Bound::new(&fibre, offset, DVec2::Y, wo, Lambdas::new(PATH));
    let surface = Surface::Hair(fibre.clone());
    let z = DVec3::new(0.2, -0.3, 0.9).normalize();
    let frame = Frame::new(z, DVec3::new(0.5, 1.0, 0.1));
    let hit = Hit { normal: z, frame, ..Hit::default() };
    let bsdf = surface.bind(&hit, frame.to_world(wo), Lambdas::new(PATH));
    for (sin, azimuth) in [(0.3, 0.7), (-0.4, 2.0), (-0.2, -1.5)] {
        let wi = direction(sin, azimuth);
        let evaluation = bsdf.eval(frame.to_world(wi));
        let (expected, pdf) = scattered(&own, wi);
        for k in 0..WAVES {
            assert!((evaluation.f[k] * evaluation.cosine / expected[k] - 1.0).abs() < 1e-9);
            assert!((evaluation.pdf[k] / pdf[k] - 1.0).abs() < 1e-9);
        }
    }
}

/// With keratin's dispersion each wavelength has the values that it has alone.
#[test]
fn dispersive_wavelengths_do_not_know_each_other() {
    let hair = Hair::new(HairParameters {
        longitudinal_roughness: 0.1,
        azimuthal_roughness: 0.1,
        scale_tilt: 0.0,
        index: FibreIndex::Keratin,
        absorption: Absorption::pigments(0.3, 0.1).unwrap(),
        height_over_width: 1.0,
    })
    .unwrap();
    let wo = viewer(0.2, 0.7);
    let wi = direction(-0.25, -1.1);
    let together = scattered(&Bound::new(&hair, 0.7, DVec2::Y, wo, Lambdas::new(PATH)), wi);
    for (k, wavelength) in PATH.into_iter().enumerate() {
        let alone = scattered(&Bound::new(&hair, 0.7, DVec2::Y, wo, Lambdas::splat(wavelength)), wi);
        assert_eq!((together.0[k], together.1[k]), (alone.0[0], alone.1[0]));
    }
}

#[test]
fn impossible_fibres_are_refused() {
    let parameters = || HairParameters {
        longitudinal_roughness: 0.3,
        azimuthal_roughness: 0.3,
        scale_tilt: 0.0,
        index: FibreIndex::Constant(1.55),
        absorption: clear(),
        height_over_width: 1.0,
    };
    let message = |parameters| Hair::new(parameters).unwrap_err().to_string();
    assert!(Hair::new(parameters()).is_ok());
    let rough = HairParameters { azimuthal_roughness: 0.0, ..parameters() };
    assert_eq!(message(rough), "hair of roughness 0.3 along and 0 around the fibre: give 0.02 to 1 for both");
    let tilted = HairParameters { scale_tilt: 1.0, ..parameters() };
    assert!(message(tilted).contains("give -20 to 20"));
    for degrees in [-20.0_f64, 20.0] {
        assert!(Hair::new(HairParameters { scale_tilt: degrees.to_radians(), ..parameters() }).is_ok());
    }
    let thin = HairParameters { index: FibreIndex::Constant(1.0), ..parameters() };
    assert!(message(thin).contains("hair of index 1: give 1.01 to 3.9"));
    for height_over_width in [0.05, 11.0, f64::NAN] {
        let flat = HairParameters { height_over_width, ..parameters() };
        assert!(message(flat).contains("give 0.1 to 10"));
    }
}
