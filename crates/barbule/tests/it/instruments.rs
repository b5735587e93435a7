//! What instruments read of far fields and materials: limits, a second integration by random rays, and both ways to the same number.

use std::f64::consts::{FRAC_PI_2, PI};

use barbule::campaign::spectrum::{
    Collect, Mount, ReadingRequest, SpectrumRequest, Vane, readings_and_individuals, spectra,
};
use barbule::film;
use barbule::instrument::Instrument;
use barbule::math::quadrature::gauss_legendre;
use barbule::math::rng::Stream;
use barbule::scattering::directions::omega;
use barbule::scattering::far_field::{Illumination, Polarization, Window};
use barbule::solve::surface::{Accuracy, far_field};
use barbule::spectrum::Wavelengths;
use barbule::spectrum::angle_law::AngleLaw;
use barbule::structure::SpeciesModel;
use barbule::{DVec3, Stack, Structure, Unobserved, material::Library, reading};

use crate::measure::material::shipped;

fn mount(instrument: &str, turned_deg: f64) -> Mount {
    Mount {
        instrument: Instrument::parse(instrument).unwrap(),
        turned: turned_deg.to_radians(),
        along: false,
        about_normal: 0.0,
        tilt: [0.0; 2],
        vane: None,
    }
}

fn starling() -> Structure {
    Structure::Species(Box::new(SpeciesModel::builtin("starling", None, Library::builtin()).unwrap()))
}

/// Mean readings `[mount][wavelength]` in light of these polarizations.
fn read(
    structure: &Structure,
    nm: &[f64],
    mounts: &[Mount],
    instances: usize,
    polarization: [f64; 2],
) -> Vec<Vec<f64>> {
    let request = ReadingRequest {
        wavelengths: Wavelengths::new(nm).unwrap(),
        mounts: mounts.to_vec(),
        instances,
        seed: 1,
        polarization,
    };
    readings_and_individuals(structure, &request, &Unobserved).unwrap().0.mean
}

fn hemisphere(structure: &Structure, nm: f64, directions: Vec<(f64, f64)>) -> Vec<f64> {
    let request = SpectrumRequest {
        wavelengths: Wavelengths::new([nm]).unwrap(),
        directions,
        instances: 1,
        seed: 1,
        collect: Collect::Hemisphere,
        polarization: [0.5; 2],
    };
    spectra(structure, &request, &Unobserved).unwrap().mean.concat()
}

/// A sphere collects all of one direction; a probe of 90° the Lambertian mean of that over all directions.
#[test]
fn wide_cones_read_the_reflected_fraction() {
    let structure = starling();
    let angles = [0.0_f64, 25.0, 60.0];
    let spheres: Vec<Mount> = angles.iter().map(|angle| mount("sphere", *angle)).collect();
    let all = read(&structure, &[520.0], &spheres, 1, [0.5; 2]).concat();
    let expected =
        hemisphere(&structure, 520.0, angles.iter().map(|angle| (0.0, angle.to_radians())).collect());
    for (found, expected) in all.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-6 && *found < 1.0, "{found} {expected}");
    }
    let rule = gauss_legendre(24);
    let (mut directions, mut weights) = (Vec::new(), Vec::new());
    for &(u, a) in &rule {
        for &(v, b) in &rule {
            // sinθ evenly, and φ over ±90°: ∫ cos²θ cosφ dθ dφ.
            let (theta, phi) = ((0.5 * PI * u).min(FRAC_PI_2 - 1e-9), PI * (v - 0.5));
            directions.push((theta, phi));
            weights.push(2.0 * a * b * 0.5 * PI * PI * theta.cos().powi(2) * phi.cos() / PI);
        }
    }
    let white: f64 = weights.iter().sum();
    assert!((white - 1.0).abs() < 1e-9, "{white}");
    let mean: f64 = hemisphere(&structure, 520.0, directions).iter().zip(&weights).map(|(r, w)| r * w).sum();
    let probe = read(&structure, &[520.0], &[mount("probe:90", 0.0)], 1, [0.5; 2])[0][0];
    // Reached 2e-4.
    assert!((probe / mean - 1.0).abs() < 2e-3, "{probe} {mean}");
}

/// The smaller the cones, the nearer is the reading to what the far field says of their axes: with half angle a the strips of
/// both discs, 2√(a² − θ²) wide, give U cosθ · 16/(3π a cosφ).
#[test]
fn narrow_cones_read_the_far_field_on_their_axes() {
    let structure = starling();
    let (phi, half) = (21f64.to_radians(), 0.05f64.to_radians());
    let arms = read(&structure, &[520.0], &[mount("arms:21,21,0.05", 0.0)], 1, [1.0, 0.0])[0][0];
    let light = Illumination { wavelength_nm: 520.0, theta_i: 0.0, phi_i: phi, window: Window::Gaussian };
    let far = far_field(&structure.instance(1, 0).unwrap(), &light, 7200, &Accuracy::default()).unwrap();
    // The mirror direction lies on the edge of two azimuths.
    let at = ((FRAC_PI_2 - phi) / far.azimuths.step()).round() as usize;
    let intensity = far.intensity(Polarization::First).unwrap();
    let expected = 0.5 * (intensity[at - 1] + intensity[at]) * 16.0 / (3.0 * PI * half * phi.cos());
    assert!((arms / expected - 1.0).abs() < 0.02, "{arms} {expected}");
}

/// Random light from one aperture; of its far field, evaluated for each ray alone, what is inside the other.
#[test]
fn random_rays_give_the_reading_of_a_barbule() {
    let structure = starling();
    let section = structure.instance(1, 0).unwrap();
    let instrument = Mount { about_normal: 0.4, ..mount("arms:25,12,14", 5.0) };
    let found = read(&structure, &[500.0], &[instrument], 1, [0.5; 2])[0][0];
    let [lit, seen] = instrument.instrument.apertures(instrument.turned);
    let axis = |angle: f64| {
        let (x, z) = angle.sin_cos();
        DVec3::new(x * 0.4f64.cos(), -x * 0.4f64.sin(), z)
    };
    let (from, to) = (axis(lit.angle), axis(seen.angle));
    let mut stream = Stream::new(5, &[]);
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    while count < 250.0 {
        let (x, y) = (stream.uniform(-1.0, 1.0), stream.uniform(-1.0, 1.0));
        let Some(w) = (x * x + y * y < 1.0).then(|| DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())) else {
            continue;
        };
        if w.dot(from) < lit.half.cos() {
            continue;
        }
        count += 1.0;
        let (theta, phi_i) = (w.y.asin(), w.x.atan2(w.z));
        let light = Illumination { wavelength_nm: 500.0, theta_i: theta, phi_i, window: Window::Gaussian };
        let accuracy = Accuracy { element_um: 0.02, ..Accuracy::default() };
        let far = far_field(&section, &light, 720, &accuracy).unwrap();
        let mut part = 0.0;
        for polarization in Polarization::BOTH {
            let intensity = far.intensity(polarization).unwrap();
            for (value, phi_o) in intensity.iter().zip(far.azimuths.phi_o()) {
                if omega(-theta, phi_o).dot(to) >= seen.half.cos() {
                    part += 0.5 * value * far.azimuths.step() * theta.cos();
                }
            }
        }
        sum += part;
        squares += part * part;
    }
    // ∫ over the lamp's projected area, which cancels with the one below.
    let scale = PI / seen.projected_area();
    let (mean, spread) =
        (scale * sum / count, scale * (squares / count - (sum / count).powi(2)).sqrt() / f64::sqrt(count));
    assert!((mean - found).abs() < 3.5 * spread && spread < 0.1 * found, "{found}, drawn {mean} ± {spread}");
}

/// A stack reads what its plane waves say; as a strip of 25 µm, by far fields of both polarizations, what diffraction leaves in the
/// cone.
#[test]
fn stacks_read_what_plane_waves_say_and_strips_nearly_so() {
    let text = "air/keratin:320/melanin";
    let structure = Structure::flat(text).unwrap();
    let stack = Stack::parse(text, &Library::builtin()).unwrap();
    for (instrument, turned_deg) in [("probe:40", 0.0), ("arms:30,30,30", 0.0), ("probe:30", 15.0)] {
        let mounts = [mount(instrument, turned_deg)];
        let exact = read(&structure, &[520.0], &mounts, 1, [0.5; 2])[0][0];
        let nodes = mounts[0].instrument.planar(mounts[0].turned, 1.0);
        let unpolarized = |angle: f64| {
            let of = |polarization| film::response(&stack, 520.0, angle, polarization).unwrap().reflected;
            0.5 * (of(film::Polarization::S) + of(film::Polarization::P))
        };
        let expected: f64 = nodes.iter().map(|node| node.weight * unpolarized(node.angle)).sum();
        assert!((exact / expected - 1.0).abs() < 1e-10, "{instrument}: {exact} {expected}");
        let strip: f64 = [[1.0, 0.0], [0.0, 1.0]]
            .iter()
            .map(|p| 0.5 * read(&structure, &[520.0], &mounts, 1, *p)[0][0])
            .sum();
        // Reached 0.9, 1.5 and 0.03 %.
        assert!((strip / exact - 1.0).abs() < 0.02, "{instrument}: {strip} of {exact}");
    }
}

/// Facets tilted far more widely than the instrument's cones, as mirrors under random rays: what of them faces the instrument is found
/// however rare it is.
#[test]
fn widely_tilted_mirrors_read_what_random_facets_do() {
    let text = "air/keratin:600/air";
    let (structure, stack) =
        (Structure::flat(text).unwrap(), Stack::parse(text, &Library::builtin()).unwrap());
    // Between them R is linear enough.
    let steps = 90;
    let table: Vec<f64> = (0..=steps)
        .map(|k| {
            let angle = FRAC_PI_2 * f64::from(k) / f64::from(steps + 1);
            let of = |polarization| film::response(&stack, 550.0, angle, polarization).unwrap().reflected;
            0.5 * (of(film::Polarization::S) + of(film::Polarization::P))
        })
        .collect();
    let reflectance = |cosine: f64| {
        let place = cosine.clamp(-1.0, 1.0).acos() / FRAC_PI_2 * f64::from(steps + 1);
        let at = (place as usize).min(table.len() - 2);
        table[at] + (place - at as f64) * (table[at + 1] - table[at])
    };
    // Strips 25 µm wide diffract, where turns are few out of their reach.
    for (k, (instrument, turned_deg, tilt_deg, diffracted)) in [
        ("probe:1", 0.0, [10.0, 10.0], 0.02),
        ("probe:3", 8.0, [8.0, 8.0], 0.02),
        ("arms:30,30,1", 0.0, [8.0, 2.0], 0.05),
        ("arms:20,36,2", 0.0, [8.0, 8.0], 0.02),
        ("probe:25", 0.0, [6.0, 12.0], 0.02),
    ]
    .into_iter()
    .enumerate()
    {
        let deviations = tilt_deg.map(f64::to_radians);
        let tilted = Mount { tilt: deviations, ..mount(instrument, turned_deg) };
        let found = read(&structure, &[550.0], &[tilted], 1, [0.5; 2])[0][0];
        let apertures = tilted.instrument.apertures(tilted.turned);
        let [lit, seen] = apertures.map(|one| (DVec3::new(one.angle.sin(), 0.0, one.angle.cos()), one.half));
        let (across, along) = (lit.0.cross(DVec3::Y), DVec3::Y);
        let mut stream = Stream::new(11, &[k as u64]);
        let (mut sum, mut squares) = (0.0, 0.0);
        let count = 1_500_000;
        for _ in 0..count {
            let [slope, turn] = deviations.map(|deviation| {
                loop {
                    let drawn = stream.normal();
                    if drawn.abs() < 3.0 {
                        return drawn * deviation;
                    }
                }
            });
            let facet = DVec3::new(turn.sin(), -slope.sin() * turn.cos(), slope.cos() * turn.cos());
            let (cosine, phi) = (stream.uniform(lit.1.cos(), 1.0), stream.uniform(0.0, 2.0 * PI));
            let sine = (1.0 - cosine * cosine).sqrt();
            let wi = cosine * lit.0 + sine * (phi.cos() * across + phi.sin() * along);
            let incidence = wi.dot(facet);
            let wo = 2.0 * incidence * facet - wi;
            if incidence > 0.0 && wo.dot(seen.0) > seen.1.cos() {
                let part = incidence * reflectance(incidence) / (slope.cos() * turn.cos());
                sum += part;
                squares += part * part;
            }
        }
        let solid = 2.0 * PI * (1.0 - lit.1.cos());
        let scale = PI * solid / (apertures[0].projected_area() * apertures[1].projected_area());
        let count = f64::from(count);
        let mean = scale * sum / count;
        let error = scale * squares.sqrt() / count;
        let allowed = diffracted * mean + 3.0 * error;
        assert!(
            (found - mean).abs() < allowed && error < 0.03 * mean,
            "{instrument}: {found}, drawn {mean} ± {error}"
        );
    }
}

/// Light and detector change places: the simulation is that of single reflections, which is reciprocal to some percent alone.
#[test]
fn arms_of_barbules_are_nearly_reciprocal_and_turned_feathers_have_their_symmetry() {
    let structure = starling();
    let mounts = [
        mount("arms:10,30,12", 0.0),
        mount("arms:30,10,12", 0.0),
        Mount { about_normal: PI, ..mount("arms:10,30,12", 0.0) },
        Mount { about_normal: 1.1, ..mount("probe:20", 0.0) },
        mount("probe:20", 0.0),
    ];
    let found = read(&structure, &[500.0, 600.0], &mounts, 8, [0.5; 2]);
    for w in [0, 1] {
        let [there, back, about, turned, probe] = [0, 1, 2, 3, 4].map(|k| found[k][w]);
        assert!((there / back - 1.0).abs() < 0.05, "{there} {back}");
        // Turned by half a turn, what was left is right: other individuals, the same mean.
        assert!((about / there - 1.0).abs() < 0.25, "{about} {there}");
        // An upright probe has no plane of incidence.
        assert!((turned / probe - 1.0).abs() < 1e-6, "{turned} {probe}");
    }
}

/// Slats that lie flat and side by side, or overlap flat, hide nothing; turned ones lose light to their neighbours, so that a sphere
/// collects less, and never more.
#[test]
fn masked_vanes_lose_what_goes_to_neighbours() {
    let structure = starling();
    let vane =
        |pitch_um: f64, turn_deg: f64| Some(Vane { pitch_um, width_um: 25.0, turn: turn_deg.to_radians() });
    let with = |vane| Mount { vane, ..mount("sphere", 0.0) };
    let mounts = [with(None), with(vane(25.0, 0.0)), with(vane(14.0, 0.0)), with(vane(14.0, -25.0))];
    let found = read(&structure, &[520.0], &mounts, 2, [0.5; 2]).concat();
    for flat in &found[1..3] {
        assert!((flat / found[0] - 1.0).abs() < 1e-6, "{found:?}");
    }
    assert!(found[3] < 0.9 * found[0] && found[3] > 0.2 * found[0], "{found:?}");
}

/// The material of a species and its far fields, with the spread that the material has: along the barbule σ/√2 of the half
/// vector, about it ±2° evenly.
#[test]
fn materials_and_far_fields_read_alike() {
    let material = shipped("starling-green");
    let nm = [532.0, 620.0];
    for instrument in ["probe:25", "arms:20,20,20", "sphere"] {
        let plain = mount(instrument, 0.0);
        let tilted = Mount { tilt: [0.04 / 2f64.sqrt(), 2f64.to_radians() / 3f64.sqrt()], ..plain };
        let fields = read(&starling(), &nm, &[tilted], 24, [0.5; 2]).concat();
        let found =
            reading::of_material(&material, &Wavelengths::new(nm).unwrap(), &[plain], None, &Unobserved)
                .unwrap()
                .concat();
        for (field, found) in fields.iter().zip(&found) {
            // 24 of the 50 individuals, whose mean is good to 5 %; reached 6, 4 and 4 %.
            assert!((field / found - 1.0).abs() < 0.08, "{instrument}: {fields:?}, material {found:?}");
        }
    }
}

/// A film's own peaks, free of dispersion: λ(θ) = 2 n d cosθ'/m, so n and 2nd come back.
#[test]
fn the_law_of_a_films_peaks_is_its_index_and_thickness() {
    let stack = Stack::parse("air/1.56:410/air", &Library::builtin()).unwrap();
    let nm: Vec<f64> = (0..2700).map(|k| 400.0 + 0.05 * f64::from(k)).collect();
    let at = Wavelengths::new(nm.clone()).unwrap();
    let degrees = [0.0_f64, 10.0, 20.0, 30.0, 40.0, 50.0];
    let angles: Vec<f64> = degrees.iter().map(|deg| deg.to_radians()).collect();
    let rows = film::sweep(&stack, &at, &angles, &Unobserved).unwrap().unpolarized();
    let peaks: Vec<(f64, f64)> = angles
        .iter()
        .zip(rows.chunks(nm.len()))
        .map(|(angle, row)| {
            let top = (0..row.len()).max_by(|a, b| row[*a].total_cmp(&row[*b])).unwrap();
            (*angle, nm[top])
        })
        .collect();
    let law = AngleLaw::fit(&peaks).unwrap();
    // Maxima at 4nd/(2m + 1): of 2nd = 1279.2 nm the third order, 511.7 nm.
    let (index, double) = (law.index.unwrap(), 2.5 * law.normal_nm.value);
    assert!(index.low < 1.56 && index.high.unwrap() > 1.56, "{}", law.words());
    assert!((index.value - 1.56).abs() < 2e-3 && (double - 1279.2).abs() < 0.5, "{}", law.words());
}
