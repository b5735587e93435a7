//! Segments against closed forms, the 2.5D simulation and plain sums.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use num_complex::Complex64;

use super::*;
use crate::film::{Polarization, reflect};
use crate::material::Library;
use crate::progress::Unobserved;
use crate::scattering::far_field::{Azimuths, Illumination, Window};
use crate::solve::surface::{self, Accuracy};
use crate::structure::{Lattice, Layers, Medium, Parts, Polyline, Roughness, Section, Structure, Substance};

fn fine() -> SegmentAccuracy {
    SegmentAccuracy { cells: [0.04, 0.25], parts: 1, interpolation: 1e-6, ..SegmentAccuracy::default() }
}

/// Boundaries at these depths, all bent by `bend` µm over the half width.
fn section(width_um: f64, bend: f64, depths: &[f64], media: Vec<Medium>) -> Section {
    let x_um: Vec<f64> = (0..=800).map(|i| width_um * (f64::from(i) / 800.0 - 0.5)).collect();
    let bent = |depth: &f64| Polyline {
        z_um: x_um.iter().map(|x| -depth - bend * (2.0 * x / width_um).powi(2)).collect(),
        x_um: x_um.clone(),
    };
    let boundaries = depths.iter().map(bent).collect();
    let parts =
        Parts { name: "test".into(), width_um: Some(width_um), boundaries, media, ..Parts::default() };
    Section::new(parts, Library::builtin()).unwrap()
}

fn film(width_um: f64, bend: f64) -> Section {
    let media = ["air", "keratin", "melanin"].map(Medium::named).to_vec();
    section(width_um, bend, &[0.0, 0.35], media)
}

fn light(theta_i: f64, phi_i: f64, window_um: [f64; 2]) -> SegmentLight {
    SegmentLight { wavelength_nm: 500.0, theta_i, phi_i, window_um, turn: 0.0 }
}

fn segment(section: Section, length_um: f64, roughness: Roughness) -> Segment {
    Segment::of_section(section, length_um, roughness, 1, 0).unwrap()
}

fn lit(segment: &Segment, light: &SegmentLight, accuracy: &SegmentAccuracy) -> Hemisphere {
    far_field(segment, light, accuracy, &Unobserved).unwrap()
}

/// 𝓔 for the second incident polarization towards a direction: reflectances from [`reflect`], vectors in three dimensions, a
/// plain sum over the cells.
fn plain(segment: &Segment, light: &SegmentLight, accuracy: &SegmentAccuracy, w_o: DVec3) -> DVec3Pair {
    let grid = grid(segment, light, accuracy).unwrap();
    let sampled = segment.sampled(grid, 1).unwrap();
    let k = TAU / (light.wavelength_nm * 1e-3);
    let w_i = omega(light.theta_i, light.phi_i);
    let electric = e2(light.phi_i);
    let palette: Vec<Complex64> = sampled.columns.palette.indices(light.wavelength_nm).unwrap();
    let (mut line, mut layers) = (Line::default(), Layers::default());
    let (mut j, mut m) = ([Complex64::ZERO; 3], [Complex64::ZERO; 3]);
    for column in 0..grid.cells[0] {
        sampled.line(column, &mut line);
        sampled.layers(&line, 0, 1, &mut layers);
        for row in 0..grid.cells[1] {
            let y = grid.centre_um(1, row);
            let z = line.z_um + f64::from(line.rise_um[row]);
            let slopes = [line.slope + f64::from(line.slopes[0][row]), f64::from(line.slopes[1][row])];
            let up = DVec3::new(-slopes[0], -slopes[1], 1.0);
            let n = up.normalize();
            let area = up.length() * grid.step_um[0] * grid.step_um[1];
            let g = (-(line.x_um / light.window_um[0]).powi(2) - (y / light.window_um[1]).powi(2)).exp();
            let at = DVec3::new(line.x_um, y, z);
            let indices: Vec<Complex64> = std::iter::once(Complex64::ONE)
                .chain(layers.media.iter().map(|m| palette[usize::from(m.a)]))
                .collect();
            let thickness: Vec<f64> = (0..layers.media.len() - 1)
                .map(|layer| 1e3 * layers.thickness_um[layer * layers.stride + row])
                .collect();
            let angle = n.dot(w_i).acos();
            let r = |p| reflect(&indices, &thickness, light.wavelength_nm, angle, p).unwrap();
            let (r_s, r_p) = (r(Polarization::S), r(Polarization::P));
            // The field split along s and p; p as seen along each wave.
            let s = n.cross(w_i).normalize();
            let p_in = s.cross(-w_i);
            let away = 2.0 * n.dot(w_i) * n - w_i;
            let p_out = s.cross(away);
            // r_p is of H along s, which E = −H × k follows: E_p keeps the sign of its p vector so.
            let scale = Complex64::from_polar(g * area, -k * (w_i.dot(at) + w_o.dot(at)));
            let field = |axis: usize| {
                scale * (r_s * electric.dot(s) * s[axis] + r_p * electric.dot(p_in) * p_out[axis])
            };
            let e = [field(0), field(1), field(2)];
            let h = cross(away, e);
            let (current, magnetic) = (cross(n, h), cross(-n, e));
            for axis in 0..3 {
                j[axis] += current[axis];
                m[axis] += magnetic[axis];
            }
        }
    }
    let along = w_o.x * j[0] + w_o.y * j[1] + w_o.z * j[2];
    let turned = cross(w_o, m);
    let field: [Complex64; 3] = std::array::from_fn(|axis| {
        Complex64::new(0.0, k / (4.0 * PI)) * (j[axis] - w_o[axis] * along - turned[axis])
    });
    let (theta, phi) = (w_o.y.asin(), w_o.x.atan2(w_o.z));
    [e1(theta, phi), e2(phi)].map(|e| field[0] * e.x + field[1] * e.y + field[2] * e.z)
}

type DVec3Pair = [Complex64; 2];

fn cross(a: DVec3, b: [Complex64; 3]) -> [Complex64; 3] {
    [b[2] * a.y - b[1] * a.z, b[0] * a.z - b[2] * a.x, b[1] * a.x - b[0] * a.y]
}

#[test]
fn transforms_give_the_plain_sums_fields_on_a_bent_rough_segment() {
    let rough = Roughness { amplitude_um: 0.03, correlation_um: [0.4, 0.6] };
    let segment = segment(film(5.0, 0.6), 4.0, rough);
    let light = light(0.3, -0.4, [1.5, 1.2]);
    let accuracy =
        SegmentAccuracy { cells: [0.2, 0.2], parts: 1, interpolation: 1e-7, ..SegmentAccuracy::default() };
    let far = lit(&segment, &light, &accuracy);
    let peak = far.amplitudes[1].iter().flatten().map(|v| v.norm()).fold(0.0, f32::max);
    let mut seen = 0;
    for index in (0..far.amplitudes[1].len()).step_by(29) {
        let (x, y) = (far.omega_x(index % far.columns()), far.omega_y[index / far.columns()]);
        let up = 1.0 - x * x - y * y;
        if up <= 0.0 {
            continue;
        }
        seen += 1;
        let plain = plain(&segment, &light, &accuracy, DVec3::new(x, y, up.sqrt()));
        for (a, b) in far.amplitudes[1][index].iter().zip(plain) {
            let apart = Complex64::new(f64::from(a.re), f64::from(a.im)) - b;
            // 3e-8 is reached: roundings of single precision.
            assert!(apart.norm() < 1e-7 * f64::from(peak), "{x} {y}: {a} {b}");
        }
    }
    assert!(seen > 10, "{seen}");
}

/// |𝓔_3D|² = (κ/2π)|∫g_y dy|²·|𝓔_2.5D|² on the cone, and exp(−(k w_y u)²/2) of it at u across.
///
/// With cells of λ/25 a film reaches 1e-6 of the peak; a crystal 8e-5, since the elements of 2.5D and the cells of the segment meet
/// its steep orders at other places.
fn goes_with_2_5d(section: &Section, theta: f64, phi: f64, tolerance: f64) {
    let window = [section.width_um / 4.0, 2.0];
    let far = lit(&segment(section.clone(), 16.0, Roughness::NONE), &light(theta, phi, window), &fine());
    let beam = Illumination { wavelength_nm: 500.0, theta_i: theta, phi_i: phi, window: Window::Gaussian };
    let flat = surface::far_field(section, &beam, 2000, &Accuracy::default()).unwrap();
    let k = TAU / 0.5;
    // (∫g_y dy)²/∫g_y² dy with ∫g_y dy = √π w_y and ∫g_y² dy = √(π/2) w_y.
    let ratio = k * theta.cos() / TAU * (2.0 * PI).sqrt() * window[1];
    let row = far.omega_y.iter().position(|y| (y + theta.sin()).abs() < 1e-12).unwrap();
    let phi_o = Azimuths::UpperHalf(2000).phi_o();
    let square =
        |field: &[Complex32; 2]| f64::from(field[0].norm_sqr() + field[1].norm_sqr()) / far.incident_um2;
    for q in 0..2 {
        let expected: Vec<f64> = flat.amplitudes[q][0]
            .iter()
            .zip(&flat.amplitudes[q][1])
            .map(|(a, b)| ratio * (a.norm_sqr() + b.norm_sqr()))
            .collect();
        let peak = expected.iter().copied().fold(0.0, f64::max);
        for column in 0..far.columns() {
            let sine = far.omega_x(column) / theta.cos();
            if sine.abs() >= 0.999 {
                continue;
            }
            // Cubic between azimuths that are a tenth of a speckle apart.
            let at = (sine.asin() + PI / 2.0) / PI * 2000.0 - 0.5;
            let (i, t) = (at.floor() as usize, at.fract());
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| expected[(i + k).saturating_sub(1).min(phi_o.len() - 1)]);
            let between =
                b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
            let found = square(&far.amplitudes[q][row * far.columns() + column]);
            assert!(
                (found - between).abs() < tolerance * peak,
                "{sine}: {found:e} for {between:e}, of {peak:e}"
            );
            for away in 1..4 {
                let u = away as f64 * far.step[1];
                let beside = square(&far.amplitudes[q][(row + away) * far.columns() + column]);
                // Directions off the cone have other obliquities, in the first order of u: 0.26 u is reached.
                let spread = between * (-(k * window[1] * u).powi(2) / 2.0).exp();
                assert!(
                    (beside - spread).abs() < 0.3 * u * peak,
                    "{sine} {away}: {beside:e} for {spread:e} of {peak:e}"
                );
            }
        }
    }
}

#[test]
fn an_invariant_segment_gives_the_cone_of_its_section_and_the_windows_spread_across_it() {
    goes_with_2_5d(&film(10.0, 0.4), 0.35, 0.2, 2e-6);
    goes_with_2_5d(&film(10.0, 0.4), 0.0, -0.5, 2e-6);
}

#[test]
fn so_does_one_over_a_crystal() {
    let section = Structure::builtin("mallard").unwrap().instance(1, 0).unwrap();
    goes_with_2_5d(&section, 0.2, 0.3, 1e-4);
}

#[test]
fn a_flat_stack_reflects_its_planar_reflectance() {
    // 3e-4 is reached: the window holds directions around the incident one, and ends at e⁻⁴.
    let segment = segment(film(20.0, 0.0), 20.0, Roughness::NONE);
    let indices: Vec<Complex64> = ["air", "keratin", "melanin"]
        .iter()
        .map(|name| segment.section.material(&Substance::named(name)).unwrap().index(500.0).unwrap())
        .collect();
    for (theta, phi) in [(0.0, 0.0), (0.4, 0.0), (0.0, 0.6), (0.5, -0.6)] {
        let light = light(theta, phi, [5.0, 5.0]);
        let far = lit(&segment, &light, &SegmentAccuracy::default());
        let angle = omega(theta, phi).z.acos();
        let r = |p| reflect(&indices, &[350.0], 500.0, angle, p).unwrap().norm_sqr();
        let planar = 0.5 * (r(Polarization::S) + r(Polarization::P));
        assert!((far.reflected() / planar - 1.0).abs() < 5e-4, "{theta} {phi}: {} {planar}", far.reflected());
    }
}

/// Rods of the host's own medium: the crystal is a bare surface, which the layered solver knows. 5e-5 is reached: orders are
/// interpolated over the angles.
#[test]
fn rough_crystals_turn_with_the_surface_as_layers_do() {
    let mut lattice: Lattice = Structure::builtin("mallard").unwrap().lattice().unwrap();
    for circle in lattice.rods.iter_mut().flat_map(|rod| &mut rod.circles) {
        circle.medium = lattice.host.clone();
    }
    let host = Medium::Pure(lattice.host.clone());
    let plain = section(6.0, 0.3, &[0.0], vec![Medium::named("air"), host]);
    let crystal = crate::structure::CrystalLayer { lattice, offset_um: 0.0, regularity: None };
    let parts = Parts {
        name: "test".into(),
        width_um: Some(6.0),
        boundaries: plain.boundaries.clone(),
        media: plain.media.clone(),
        crystal: Some(crystal),
        ..Parts::default()
    };
    let crystal = Section::new(parts, Library::builtin()).unwrap();
    let rough = Roughness { amplitude_um: 0.03, correlation_um: [0.7, 0.7] };
    let light = light(0.4, 0.3, [1.5, 1.5]);
    let accuracy = SegmentAccuracy { parts: 1, ..SegmentAccuracy::default() };
    let [a, b] = [plain, crystal].map(|section| lit(&segment(section, 5.0, rough), &light, &accuracy));
    let peak = a.amplitudes.iter().flatten().flatten().map(|v| v.norm()).fold(0.0, f32::max);
    for (a, b) in a.amplitudes.iter().flatten().flatten().zip(b.amplitudes.iter().flatten().flatten()) {
        assert!((a - b).norm() < 1e-4 * peak, "{a} {b}");
    }
    assert!((a.incident_um2 / b.incident_um2 - 1.0).abs() < 1e-12);
}

#[test]
fn every_species_sends_back_no_more_than_falls_on_it() {
    for name in crate::structure::species_names() {
        let structure = Structure::builtin(name).unwrap();
        let segment = structure.segment(3, 1, 8.0, Roughness::default()).unwrap();
        let window = [segment.section.width_um / 4.0, 2.0];
        for (theta, phi) in [(0.0, 0.0), (0.5, 0.5)] {
            let light = SegmentLight { wavelength_nm: 600.0, ..light(theta, phi, window) };
            let accuracy = SegmentAccuracy { parts: 1, ..SegmentAccuracy::default() };
            let reflected = lit(&segment, &light, &accuracy).reflected();
            assert!((0.001..=1.0).contains(&reflected), "{name} {theta} {phi}: {reflected}");
        }
    }
}

/// By Parseval's theorem light that a mirror's heights h scatter has ⟨u²⟩ = ⟨(2 ∂h/∂y)²⟩ around the mirror's ω_y at normal
/// incidence, besides the window's (k w_y)⁻².
#[test]
fn roughness_spreads_light_along_y_by_twice_its_slopes() {
    let rough = Roughness { amplitude_um: 0.02, correlation_um: [0.8, 0.8] };
    let metal = Medium::Pure(Substance::Index(Complex64::new(0.0, 1e6)));
    let mirror = section(24.0, 0.0, &[0.0], vec![Medium::named("air"), metal]);
    let window = [6.0, 6.0];
    let light = light(0.0, 0.0, window);
    let accuracy = SegmentAccuracy { parts: 1, ..SegmentAccuracy::default() };
    for seed in 0..3 {
        let segment = Segment::of_section(mirror.clone(), 24.0, rough, seed, 0).unwrap();
        let grid = grid(&segment, &light, &accuracy).unwrap();
        let sampled = segment.sampled(grid, 1).unwrap();
        let (mut line, mut slopes, mut weights) = (Line::default(), 0.0, 0.0);
        for column in 0..grid.cells[0] {
            sampled.line(column, &mut line);
            for (row, slope) in line.slopes[1].iter().enumerate() {
                let y = grid.centre_um(1, row);
                let g2 = (-2.0 * ((line.x_um / window[0]).powi(2) + (y / window[1]).powi(2))).exp();
                slopes += g2 * f64::from(*slope).powi(2);
                weights += g2;
            }
        }
        let far = lit(&segment, &light, &accuracy);
        // 4e-5 is reached.
        assert!((far.reflected() - 1.0).abs() < 1e-4, "{}", far.reflected());
        let (mut second, mut whole) = (0.0, 0.0);
        for (index, (value, angle)) in far.intensity().iter().zip(far.solid_angles()).enumerate() {
            let u = far.omega_y[index / far.columns()];
            second += u * u * value * angle;
            whole += value * angle;
        }
        let expected = 4.0 * slopes / weights + (TAU / 0.5 * window[1]).powi(-2);
        assert!((second / whole / expected - 1.0).abs() < 0.01, "{:e} for {expected:e}", second / whole);
    }
}

#[test]
fn turning_light_and_view_shifts_what_is_seen() {
    // A flat mirror turned by δ sends normal light to −2δ: at φ_i + δ in its own frame, −φ_i − 2δ outside.
    let metal = Medium::Pure(Substance::Index(Complex64::new(0.0, 1e6)));
    let mirror = section(16.0, 0.0, &[0.0], vec![Medium::named("air"), metal]);
    let light = SegmentLight { turn: 0.1, ..light(0.0, 0.2, [4.0, 2.0]) };
    let far = lit(&segment(mirror, 8.0, Roughness::NONE), &light, &SegmentAccuracy::default());
    let intensity = far.intensity();
    let brightest = (0..intensity.len()).max_by(|&a, &b| intensity[a].total_cmp(&intensity[b])).unwrap();
    assert!((far.omega_x(brightest % far.columns()) - (-0.4_f64).sin()).abs() <= far.step[0]);
    assert!((far.reflected() - 1.0).abs() < 3e-3, "{}", far.reflected());
}

#[test]
fn threads_and_passes_change_no_bit() {
    let structure = Structure::builtin("starling").unwrap();
    let segment = structure.segment(1, 0, 4.0, Roughness::default()).unwrap();
    let light = light(0.2, 0.3, [6.0, 1.0]);
    let accuracy = SegmentAccuracy { cells: [0.3, 0.3], ..SegmentAccuracy::default() };
    let on = |threads: usize, accuracy: &SegmentAccuracy| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| lit(&segment, &light, accuracy))
    };
    let once = on(1, &accuracy);
    // A few rows of directions in each pass.
    let little = SegmentAccuracy { held_bytes: 1 << 18, ..accuracy };
    for other in [on(3, &accuracy), on(2, &little)] {
        assert_eq!(once.amplitudes, other.amplitudes);
        assert_eq!(once.incident_um2.to_bits(), other.incident_um2.to_bits());
    }
}

#[test]
fn lights_and_cells_that_make_no_sense_are_refused() {
    let segment = segment(film(5.0, 0.0), 4.0, Roughness::NONE);
    let usual = light(0.0, 0.0, [1.0, 1.0]);
    for (light, cells, words) in [
        (SegmentLight { wavelength_nm: -1.0, ..usual }, [0.2; 2], "positive"),
        (SegmentLight { window_um: [1.0, 0.0], ..usual }, [0.2; 2], "positive"),
        (SegmentLight { phi_i: 2.0, ..usual }, [0.2; 2], "above"),
        (usual, [0.2, 0.7], "along y are too long"),
    ] {
        let accuracy = SegmentAccuracy { cells, ..SegmentAccuracy::default() };
        let error = far_field(&segment, &light, &accuracy, &Unobserved).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
