//! The fast simulation against closed forms, laws and the plain evaluation.

use num_complex::{Complex, Complex64};
use std::f64::consts::PI;

use super::nodes::Nodes;
use super::points::Points;
use super::radiation::Radiator;
use super::reflector::Reflector;
use super::scalar::Scalar;
use super::*;
use crate::film::{self, reflect};
use crate::material::Library;
use crate::math::rng::Stream;
use crate::progress::Unobserved;
use crate::scattering::directions::{e1, e2, omega};
use crate::scattering::far_field::{IncidentLight, Polarization};
use crate::solve::direct;
use crate::structure::{Inclusion, Loop, Medium, Parts, Polyline, Section, SpeciesModel, Substance};

/// A perfect conductor to 2e-6: r_s = −1, r_p = +1.
fn mirror() -> Medium {
    Medium::Pure(Substance::Index(Complex64::new(0.0, 1e6)))
}

fn section(width_um: f64, boundaries: Vec<Polyline>, media: Vec<Medium>) -> Section {
    let parts =
        Parts { name: "test".into(), width_um: Some(width_um), boundaries, media, ..Parts::default() };
    Section::new(parts, Library::builtin()).unwrap()
}

fn flat(width_um: f64, depth_um: f64) -> Polyline {
    Polyline { x_um: vec![-width_um / 2.0, 0.0, width_um / 2.0], z_um: vec![-depth_um; 3] }
}

/// A smooth random height with correlation length `tau`, of amplitude `height`, sampled each 0.03 µm: these tests' own, so
/// that a change of how species draw theirs leaves what is held here alone.
fn rough(width_um: f64, tau: f64, height: f64, depth: f64, seed: u64) -> Polyline {
    let mut stream = Stream::new(seed, &[1]);
    let waves: Vec<(f64, f64, f64)> = (1..80)
        .map(|n| {
            let f = f64::from(n) / (1.5 * width_um);
            ((-(PI * f * tau).powi(2)).exp(), 2.0 * PI * f, stream.uniform(0.0, 2.0 * PI))
        })
        .collect();
    let count = (width_um / 0.03).round() as usize;
    let x_um: Vec<f64> = (0..=count).map(|i| width_um * (i as f64 / count as f64 - 0.5)).collect();
    let raw: Vec<f64> =
        x_um.iter().map(|x| waves.iter().map(|(a, k, p)| a * (k * x + p).cos()).sum()).collect();
    let top = raw.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    Polyline { x_um, z_um: raw.iter().map(|v| v / top * height - depth).collect() }
}

/// A rough keratin film over melanin with a scalloped lower boundary, like a starling's.
fn scalloped(width_um: f64, seed: u64) -> Section {
    let top = rough(width_um, 1.5, 0.3, 0.0, seed);
    let lower = |depth: f64, size: f64| Polyline {
        x_um: top.x_um.clone(),
        z_um: top
            .x_um
            .iter()
            .zip(&top.z_um)
            .map(|(x, z)| z - depth - size * (2.0 * (x / 0.25 - (x / 0.25).floor()) - 1.0).powi(2))
            .collect(),
    };
    let boundaries = vec![top.clone(), lower(0.32, 0.04), lower(0.60, -0.04)];
    let media = ["air", "keratin", "melanin", "keratin"].map(Medium::named).to_vec();
    section(width_um, boundaries, media)
}

fn fields(section: &Section, wavelength_nm: f64, theta: f64, phi: f64) -> FarField {
    far_field(section, &beam(wavelength_nm, theta, phi), 400, &Accuracy::default()).unwrap()
}

fn beam(wavelength_nm: f64, theta_i: f64, phi_i: f64) -> Illumination {
    Illumination { wavelength_nm, theta_i, phi_i, window: Window::Gaussian }
}

/// Fourier coefficients, `[phi_i][incident polarization][e₁, e₂][order]`, for unit |E|.
fn radiated<T: Scalar>(
    points: &Points,
    reflector: &Reflector<T>,
    nodes: &Nodes<T>,
    cone: &Cone,
    phi_i: &[f64],
) -> Vec<Complex<T>> {
    let mut out = Vec::new();
    let scales = vec![1.0; phi_i.len()];
    let mut radiator = Radiator::<T>::new(Width::best());
    radiator.far_fields(points, reflector, nodes, cone, phi_i, &scales, &mut out, &mut |_| Ok(())).unwrap();
    out
}

fn widened(values: &[Complex<f32>]) -> Vec<Complex64> {
    values.iter().map(|v| Complex64::new(f64::from(v.re), f64::from(v.im))).collect()
}

fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, &b| a.max(b))
}

/// ‖a − b‖/‖b‖ over both components. (The workspace's tests of whole campaigns have one of slices; no crate is below both
/// but for its library, in which nothing else would use it.)
fn relative_l2<'a>(a: impl Iterator<Item = &'a Complex64>, b: impl Iterator<Item = &'a Complex64>) -> f64 {
    let (mut difference, mut norm) = (0.0, 0.0);
    for (a, b) in a.zip(b) {
        difference += (a - b).norm_sqr();
        norm += b.norm_sqr();
    }
    (difference / norm).sqrt()
}

#[test]
fn a_flat_mirror_returns_all_light_in_the_lobe_of_its_window() {
    let width = 25.0;
    let section = section(width, vec![flat(width, 0.0)], vec![Medium::named("air"), mirror()]);
    let far = fields(&section, 500.0, 0.0, 0.0);
    let k = 2.0 * PI / 0.5;
    // The window's transform by a fine trapezoidal rule with its end correction.
    let transform = |q: f64| {
        let n = 40_000;
        let h = width / f64::from(n);
        let g = |x: f64| (-(4.0 * x / width).powi(2)).exp();
        (0..n)
            .map(|i| {
                let x = -width / 2.0 + (f64::from(i) + 0.5) * h;
                g(x) * (q * x).cos() * h
            })
            .sum::<f64>()
    };
    let shape: Vec<f64> = far
        .azimuths
        .phi_o()
        .iter()
        .map(|phi| transform(k * phi.sin()).powi(2) * (0.5 * (1.0 + phi.cos())).powi(2))
        .collect();
    for polarization in Polarization::BOTH {
        assert!(
            (far.radiated[polarization.index()] - 1.0).abs() < 1e-5,
            "{}",
            far.radiated[polarization.index()] - 1.0
        );
        let intensity = far.intensity(polarization).unwrap();
        let scale = k / (2.0 * PI) * far.light.scale().powi(2);
        let top = peak(&intensity);
        for (i, s) in intensity.iter().zip(&shape) {
            assert!((i - s * scale).abs() < 1e-6 * top, "{} {}", i / top, s * scale / top);
        }
    }
}

#[test]
fn a_flat_stack_reflects_what_fresnel_says_in_both_polarizations() {
    let width = 25.0;
    let depth = 0.595;
    let media = ["air", "keratin", "melanin"].map(Medium::named).to_vec();
    let section = section(width, vec![flat(width, 0.0), flat(width, depth)], media);
    let indices =
        ["air", "keratin", "melanin"].map(|name| Library::builtin().get(name).unwrap().index(480.0).unwrap());
    for (theta, phi) in [(0.0f64, 0.0f64), (30.0, 20.0), (-20.0, 45.0), (45.0, -30.0), (10.0, 55.0)] {
        let (theta, phi) = (theta.to_radians(), phi.to_radians());
        let far = fields(&section, 480.0, theta, phi);
        let w = omega(theta, phi);
        let s = glam::DVec3::Z.cross(w).try_normalize().unwrap_or(glam::DVec3::Y);
        let r = [film::Polarization::S, film::Polarization::P]
            .map(|p| reflect(&indices, &[depth * 1e3], 480.0, w.z.acos(), p).unwrap().norm_sqr());
        for (polarization, e) in [e1(theta, phi), e2(phi)].into_iter().enumerate() {
            let along_s = e.dot(s).powi(2);
            let expected = along_s * r[0] + (1.0 - along_s) * r[1];
            let error = far.radiated[polarization] / expected - 1.0;
            assert!(error.abs() < 2e-3, "{theta} {phi} {polarization}: {error:e}");
        }
    }
}

#[test]
fn a_turned_flat_top_is_an_unturned_one_seen_from_a_turned_place() {
    let (width, delta, phi) = (25.0, 0.1f64, 0.35);
    let media = || vec![Medium::named("air"), Medium::named("keratin")];
    let straight = section(width, vec![flat(width, 0.0)], media());
    let half = width / 2.0;
    let turned_top = Polyline {
        x_um: vec![-half * delta.cos(), 0.0, half * delta.cos()],
        z_um: vec![-half * delta.sin(), 0.0, half * delta.sin()],
    };
    let turned = section(width * delta.cos(), vec![turned_top], media());
    let at = |section: &Section, phi_i: f64, view: f64| {
        let barbule = Barbule::new(section, FINE_ELEMENT_UM, Window::Gaussian).unwrap();
        let cone = Cone::around(std::slice::from_ref(&barbule), 500.0, 0.2);
        let light = IncidentLight::Beam { power_um: barbule.incident_power_um(0.2, phi_i) };
        let batch = Batch { cone: &cone, phi_i: &[phi_i], lights: &[light] };
        let mut buffers = Buffers::<f64>::new(Width::best());
        let reflector = barbule.exactly(500.0, 0.2, &[phi_i], &Unobserved).unwrap();
        buffers.radiate(&barbule.points, &reflector, &batch, &mut |_| Ok(())).unwrap();
        let mut all = Vec::new();
        buffers.synthesize(&cone, Grid { azimuths: 400, margin: 0, shift: view }, &mut all);
        all
    };
    // The top turned by δ from x towards z: its normal leans to −x, so light and view turn by −δ.
    let (a, b) = (at(&straight, phi, 0.0), at(&turned, phi - delta, -delta));
    let error = relative_l2(a.iter(), b.iter());
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn halving_the_elements_changes_nothing_that_matters() {
    let section = scalloped(25.0, 3);
    let at = |element_um: f64| {
        let accuracy = Accuracy { element_um, ..Accuracy::default() };
        far_field(&section, &beam(430.0, 0.3, 0.6), 400, &accuracy).unwrap()
    };
    let (coarse, fine) = (at(FINE_ELEMENT_UM), at(FINE_ELEMENT_UM / 2.0));
    for polarization in Polarization::BOTH {
        let (a, b) = (coarse.intensity(polarization).unwrap(), fine.intensity(polarization).unwrap());
        let top = peak(&b);
        let worst = a.iter().zip(&b).fold(0f64, |w, (a, b)| w.max((a - b).abs())) / top;
        assert!(worst < 1e-4, "{worst:e}");
    }
}

#[test]
fn fast_equals_direct() {
    for (seed, wavelength, theta, phi) in
        [(1, 400.0, 0.0f64, 0.0f64), (2, 550.0, 40.0, 30.0), (3, 694.0, -60.0, -20.0), (4, 450.0, 10.0, 80.0)]
    {
        let section = scalloped(10.0, seed);
        let (theta, phi) = (theta.to_radians(), phi.to_radians());
        let fast = fields(&section, wavelength, theta, phi);
        let plain = direct::far_field(&section, &beam(wavelength, theta, phi), 400, FINE_ELEMENT_UM).unwrap();
        assert!((plain.light.scale() / fast.light.scale() - 1.0).abs() < 1e-12);
        for polarization in Polarization::BOTH {
            let error = relative_l2(
                fast.amplitudes[polarization.index()].iter().flatten(),
                plain.amplitudes[polarization.index()].iter().flatten(),
            );
            assert!(error < 1e-10, "{seed} {polarization:?}: {error:e}");
            assert!(
                (fast.radiated[polarization.index()] / plain.radiated[polarization.index()] - 1.0).abs()
                    < 1e-10
            );
        }
    }
}

/// The campaign's way: single precision, nodes, coarser elements, all φ_i at once.
#[test]
fn the_campaigns_way_comes_near_converged_fields() {
    let mut worst = (0f64, 0f64);
    for (seed, wavelength, theta) in
        [(1, 400.0, 0.0f64), (2, 550.0, 40.0), (3, 694.0, 60.0), (4, 430.0, 80.0)]
    {
        let section = scalloped(25.0, seed);
        let theta = theta.to_radians();
        let barbule = Barbule::for_campaign(&section, 2).unwrap();
        let cone = Cone::around(std::slice::from_ref(&barbule), wavelength, theta);
        assert!(Nodes::<f32>::equidistant(&barbule.points, cone.kappa).taps.is_some());
        let phis = [0.0, 0.5, 1.2, 1.5];
        let lights = phis.map(|phi| IncidentLight::Beam { power_um: barbule.incident_power_um(theta, phi) });
        let batch = Batch { cone: &cone, phi_i: &phis, lights: &lights };
        let table = barbule.table(wavelength, Width::best(), &Unobserved).unwrap();
        let grid = Grid { azimuths: 400, margin: 0, shift: 0.0 };
        let mut workspace = Workspace::new(Width::best());
        let fields = workspace.scatter(&barbule, &table, &batch, grid, &Unobserved).unwrap();
        for (i, phi) in phis.into_iter().enumerate() {
            let light = beam(wavelength, theta, phi);
            let accuracy = Accuracy { element_um: FINE_ELEMENT_UM / 2.0, ..Accuracy::default() };
            let exact = far_field(&section, &light, 400, &accuracy).unwrap();
            for polarization in 0..2 {
                let fast = widened(&fields[(i * 2 + polarization) * 800..][..800]);
                let exact = &exact.amplitudes[polarization];
                let error = relative_l2(fast.iter(), exact.iter().flatten());
                let power = |v: &mut dyn Iterator<Item = &Complex64>| v.map(Complex64::norm_sqr).sum::<f64>();
                let ratio = power(&mut fast.iter()) / power(&mut exact.iter().flatten());
                worst = (worst.0.max(error), worst.1.max((ratio - 1.0).abs()));
            }
        }
    }
    // Reached: 3.7e-4 and 1.1e-4.
    assert!(worst.0 < 4e-4 && worst.1 < 1.2e-4, "{worst:?}");
}

#[test]
fn mirror_images_scatter_mirrored() {
    let section_a = scalloped(15.0, 5);
    let flip = |line: &Polyline| Polyline {
        x_um: line.x_um.iter().rev().map(|x| -x).collect(),
        z_um: line.z_um.iter().rev().copied().collect(),
    };
    let section_b = section(15.0, section_a.boundaries.iter().map(flip).collect(), section_a.media.clone());
    let (a, b) = (fields(&section_a, 500.0, 0.4, 0.3), fields(&section_b, 500.0, 0.4, -0.3));
    let opposite = fields(&section_a, 500.0, -0.4, 0.3);
    for polarization in Polarization::BOTH {
        let (a, b) = (a.intensity(polarization).unwrap(), b.intensity(polarization).unwrap());
        let c = opposite.intensity(polarization).unwrap();
        let top = peak(&a);
        for n in 0..400 {
            assert!((a[n] - b[399 - n]).abs() < 1e-10 * top);
            assert!((a[n] - c[n]).abs() < 1e-10 * top);
        }
    }
}

#[test]
fn every_simd_width_gives_the_same_field() {
    let section = scalloped(10.0, 6);
    let at = |width| {
        far_field(&section, &beam(450.0, 0.3, 0.4), 400, &Accuracy { element_um: 0.02, width }).unwrap()
    };
    let reference = at(Width::scalar());
    for width in Width::available() {
        for polarization in Polarization::BOTH {
            let error = relative_l2(
                at(width).amplitudes[polarization.index()].iter().flatten(),
                reference.amplitudes[polarization.index()].iter().flatten(),
            );
            assert!(error < 1e-12, "{}: {error:e}", width.name());
        }
    }
}

/// A roof: its corner must not be interpolated across.
#[test]
fn corners_are_exact_too() {
    let top = Polyline { x_um: vec![-10.0, -2.0, 4.0, 10.0], z_um: vec![0.0, 1.5, 1.0, -0.5] };
    let section = section(20.0, vec![top], vec![Medium::named("air"), Medium::named("melanin")]);
    let points = Points::new(&section, CAMPAIGN_ELEMENT_UM, Window::Gaussian).unwrap();
    let stacks = Reflector::<f32>::Stacks(points.optics(450.0).unwrap());
    let cone = Cone::new(450.0, 0.0, points.radius_um);
    let run = |nodes: &Nodes<f32>| widened(&radiated(&points, &stacks, nodes, &cone, &[0.2]));
    let error = relative_l2(
        run(&Nodes::equidistant(&points, cone.kappa)).iter(),
        run(&Nodes::at_points(&points)).iter(),
    );
    assert!(error < 2e-4, "{error:e}");
}

/// Steep ends are lit at grazing angles, where every air-filled layer carries a vanishing q.
#[test]
fn single_precision_survives_grazing_light_on_many_voids() {
    let model = SpeciesModel::builtin("hummingbird", None, Library::builtin()).unwrap();
    for instance in 0..3 {
        let section = model.section(1, instance).unwrap();
        let points = Points::new(&section, CAMPAIGN_ELEMENT_UM, Window::Gaussian).unwrap();
        let single = Reflector::<f32>::Stacks(points.optics(484.0).unwrap());
        let double = Reflector::<f64>::Stacks(points.optics(484.0).unwrap());
        let cone = Cone::new(484.0, 0.3, points.radius_um);
        let phis = [0.7, 1.45];
        let nodes = Nodes::equidistant(&points, cone.kappa);
        let fast = widened(&radiated(&points, &single, &nodes, &cone, &phis));
        let exact = radiated(&points, &double, &Nodes::at_points(&points), &cone, &phis);
        let error = relative_l2(fast.iter(), exact.iter());
        assert!(error < 1e-3, "{instance}: {error:e}");
    }
}

/// A translation changes no power: sections are drawn from x = 0 on as often as about it.
#[test]
fn a_section_drawn_elsewhere_reflects_the_same() {
    let centred = scalloped(8.0, 3);
    let moved = |xs: &[f64]| xs.iter().map(|x| x + 40.0).collect();
    let boundaries = centred.boundaries.iter();
    let elsewhere = section(
        8.0,
        boundaries.map(|one| Polyline { x_um: moved(&one.x_um), z_um: one.z_um.clone() }).collect(),
        centred.media.clone(),
    );
    let powers = |section| fields(section, 500.0, 0.2, 0.4).radiated;
    for (a, b) in powers(&centred).iter().zip(powers(&elsewhere)) {
        assert!((a - b).abs() < 1e-9 * a, "{a} {b}");
    }
}

/// A wide bar of gold in keratin is a stack, however deep it lies under a flat top that has no other boundary; what lies above the top
/// is refused.
#[test]
fn inclusions_count_wherever_they_lie() {
    let bar = |from: f64, to: f64| {
        let gold = Medium::Pure(Substance::Index(Complex64::new(0.97, 1.87)));
        let outline = Loop::polygon(vec![-11.9, 11.9, 11.9, -11.9], vec![from, from, to, to]);
        let parts = Parts {
            width_um: Some(24.0),
            boundaries: vec![flat(24.0, 0.0)],
            media: ["air", "keratin"].map(Medium::named).to_vec(),
            inclusions: vec![Inclusion { outline, medium: gold, holes: Vec::new() }],
            ..Parts::default()
        };
        Section::new(parts, Library::builtin()).unwrap()
    };
    for depth in [0.3, 0.7, 3.0] {
        let section = bar(-depth, -depth - 0.3);
        let keratin = Library::builtin().get("keratin").unwrap().index(500.0).unwrap();
        let (air, gold) = (Complex64::new(1.0, 0.0), Complex64::new(0.97, 1.87));
        let r =
            reflect(&[air, keratin, gold, keratin], &[1e3 * depth, 300.0], 500.0, 0.0, film::Polarization::S);
        let expected = r.unwrap().norm_sqr();
        let found = fields(&section, 500.0, 0.0, 0.0).radiated[0];
        assert!((found / expected - 1.0).abs() < 0.02, "{depth}: {found} {expected}");
    }
    for refused in [
        far_field(&bar(0.9, 0.6), &beam(500.0, 0.0, 0.0), 90, &Accuracy::default()).unwrap_err(),
        direct::far_field(&bar(0.9, 0.6), &beam(500.0, 0.0, 0.0), 90, 0.05).unwrap_err(),
    ] {
        assert!(refused.to_string().contains("inclusions[0] lies above the top"), "{refused}");
    }
}
