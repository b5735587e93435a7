//! Laws of cross sections, their rays and the random species.

use barbule::material::Library;
use barbule::math::rng::Stream;
use barbule::structure::{
    Columns, Medium, Polyline, Ray, Section, SpeciesFile, SpeciesModel, cast, layered_species, species_names,
};

fn model(name: &str, variant: Option<&str>) -> SpeciesModel {
    SpeciesModel::builtin(name, variant, Library::builtin()).unwrap()
}

/// Rays at the middles of the segments of the top, with the segments' normals, tilted by up to `tilt` rad at random.
fn rays(section: &Section, count: usize, tilt: f64, seed: u64) -> Vec<Ray> {
    let top = section.top();
    let mut stream = Stream::new(seed, &[]);
    (0..count)
        .map(|_| {
            let i = (stream.unit() * (top.x_um.len() - 1) as f64) as usize;
            let t = stream.uniform(0.01, 0.99);
            let (dx, dz) = (top.x_um[i + 1] - top.x_um[i], top.z_um[i + 1] - top.z_um[i]);
            let angle = libm::atan2(dx, -dz) + stream.uniform(-tilt, tilt);
            Ray {
                x_um: top.x_um[i] + t * dx,
                z_um: top.z_um[i] + t * dz,
                normal: [libm::cos(angle), libm::sin(angle)],
            }
        })
        .collect()
}

/// Every segment of everything, sorted crossings, and the medium looked up at the middle of each stretch.
fn brute_force(section: &Section, ray: &Ray) -> Vec<(Medium, f64)> {
    let (dx, dz) = (-ray.normal[0], -ray.normal[1]);
    let mut crossings = vec![0.0];
    let mut segment = |x0: f64, z0: f64, x1: f64, z1: f64, low: f64, high: f64| {
        let (ex, ez) = (x1 - x0, z1 - z0);
        let determinant = ex * dz - ez * dx;
        let t = (ez * (ray.x_um - x0) - ex * (ray.z_um - z0)) / determinant;
        let s = (dz * (ray.x_um - x0) - dx * (ray.z_um - z0)) / determinant;
        if t > 1e-9 && s >= low && s < high {
            crossings.push(t);
        }
    };
    for Polyline { x_um, z_um } in &section.boundaries {
        let last = x_um.len() - 1;
        for i in 0..last {
            let low = if i == 0 { f64::NEG_INFINITY } else { 0.0 };
            let high = if i + 1 == last { f64::INFINITY } else { 1.0 };
            segment(x_um[i], z_um[i], x_um[i + 1], z_um[i + 1], low, high);
        }
    }
    for inclusion in &section.inclusions {
        for shape in std::iter::once(&inclusion.outline).chain(&inclusion.holes) {
            let corners = shape.corners();
            let count = corners.x_um.len();
            for i in 0..count {
                let j = (i + 1) % count;
                segment(corners.x_um[i], corners.z_um[i], corners.x_um[j], corners.z_um[j], 0.0, 1.0);
            }
        }
    }
    crossings.sort_by(f64::total_cmp);
    let heights = section.boundaries.iter().flat_map(|b| &b.z_um).copied();
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
    crossings.retain(|&t| t <= 2.0 * (high - low));
    crossings.push(f64::INFINITY);
    let mut layers: Vec<(Medium, f64)> = Vec::new();
    for pair in crossings.windows(2) {
        if pair[1] - pair[0] < 2e-9 {
            continue;
        }
        let middle = if pair[1].is_finite() { 0.5 * (pair[0] + pair[1]) } else { pair[0] + 1e-7 };
        let above =
            section.boundaries.iter().filter(|b| b.height(ray.x_um + middle * dx) > ray.z_um + middle * dz);
        // Beyond the ends a ray that is above or below everything has left.
        let end = if dx > 0.0 { section.top().x_um.last() } else { section.top().x_um.first() };
        let has_left = [0, section.boundaries.len()].contains(&above.count())
            && pair[1] > (end.unwrap() - ray.x_um) / dx;
        let medium = section.medium_at(ray.x_um + middle * dx, ray.z_um + middle * dz);
        match layers.last_mut() {
            Some((before, thickness)) if before == medium => *thickness += pair[1] - pair[0],
            _ => layers.push((medium.clone(), pair[1] - pair[0])),
        }
        if has_left {
            break;
        }
    }
    if let Some(substrate) = layers.last_mut() {
        substrate.1 = f64::INFINITY;
    }
    layers
}

/// The layers of one ray of a cast, the substrate last with thickness ∞.
fn layers(columns: &Columns, ray: usize) -> Vec<f64> {
    let mut layers: Vec<f64> = (0..columns.slots - 1)
        .map(|slot| columns.thickness_um[slot * columns.rays + ray])
        .filter(|&thickness| thickness > 0.0)
        .collect();
    layers.push(f64::INFINITY);
    layers
}

fn agrees_with_brute_force(section: &Section, count: usize, tilt: f64) {
    let rays = rays(section, count, tilt, 5);
    let columns = cast(section, &rays).unwrap();
    for (index, ray) in rays.iter().enumerate() {
        let expected = brute_force(section, ray);
        let found = layers(&columns, index);
        assert_eq!(
            expected.len(),
            found.len(),
            "{} {ray:?}\n{found:?}\n{:?}",
            section.name,
            expected.iter().map(|l| l.1).collect::<Vec<_>>()
        );
        for ((_, a), b) in expected.iter().zip(&found) {
            assert!(a == b || (a - b).abs() < 4e-9, "{} {ray:?}: {a} and {b}", section.name);
        }
    }
}

#[test]
fn rays_through_every_species_agree_with_brute_force() {
    for name in layered_species() {
        for instance in 0..3 {
            let section = model(name, None).section(1, instance).unwrap();
            let few = if section.inclusions.is_empty() { 1 } else { 4 };
            agrees_with_brute_force(&section, 120 / few, 0.0);
            // Tilted rays cross notches several times and leave through the ends.
            agrees_with_brute_force(&section, 80 / few, 1.2);
        }
    }
}

#[test]
fn fifty_instances_of_every_variant_are_valid() {
    for name in species_names() {
        for variant in SpeciesFile::builtin(name).unwrap().variants() {
            let model = model(name, Some(variant));
            for instance in 0..50 {
                model.section(7, instance).unwrap();
            }
        }
    }
}

/// Mean over instances and rays of the sum of some slots' thicknesses, away from the ends.
fn mean_thickness(model: &SpeciesModel, slots: std::ops::Range<usize>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for instance in 0..8 {
        let section = model.section(11, instance).unwrap();
        let rays: Vec<Ray> = rays(&section, 600, 0.0, 3)
            .into_iter()
            .filter(|r| r.x_um.abs() < 0.3 * section.width_um)
            .collect();
        let columns = cast(&section, &rays).unwrap();
        for slot in slots.clone() {
            sum += columns.thickness_um[slot * columns.rays..][..columns.rays].iter().sum::<f64>();
        }
        count += rays.len();
    }
    sum / count as f64
}

/// A chain's upper side lies on average below its circles' tops: over a circle of radius r, arcs reach to 0.745 r from
/// the middle and notches are (2/3) r high, so the mean height is 0.8385 r, and E(r²)/E(r) = r (1 + spread²/3).
fn cortex_over_chain(cortex: f64, diameter: f64, spread: f64) -> f64 {
    cortex + 0.5 * diameter * (1.0 - 0.8385 * (1.0 + spread * spread / 3.0))
}

#[test]
fn layers_have_their_nominal_thickness_on_average() {
    for (variant, cortex) in [("aqua", 0.300), ("green", 0.320), ("teal", 0.440)] {
        let model = model("starling", Some(variant));
        let expected = cortex_over_chain(cortex, 0.25, 0.2);
        // Notches are those of the smaller of two neighbours, and arcs are chords: up to 4 nm more.
        let found = mean_thickness(&model, 0..1) - expected;
        assert!((0.0..0.004).contains(&found), "{variant}: {found}");
    }
    for (variant, cortex) in [("forest", 0.595), ("purple", 0.530)] {
        // The offset of a curve is exact up to its curvature.
        assert!((mean_thickness(&model("rock-dove", Some(variant)), 0..1) - cortex).abs() < 5e-4);
    }
    // Five melanin layers and five gaps under the first are five periods.
    assert!((mean_thickness(&model("bronzewing", Some("pink")), 1..11) - 5.0 * 0.199).abs() < 0.004);
}

#[test]
fn a_hummingbird_is_as_thick_as_its_layers_together() {
    let air = [0.030, 0.2 * 0.030 + 0.8 * 0.100].into_iter().chain([0.100; 10]).sum::<f64>();
    let gaps = 0.060 * (0.90 + 0.95 + 9.0);
    let expected = 2.0 * 0.010 + 12.0 * 2.0 * 0.030 + air + gaps;
    let model = model("hummingbird", None);
    let mut sum = 0.0;
    for instance in 0..20 {
        let section = model.section(2, instance).unwrap();
        let thickness = |x: f64| section.boundaries[0].height(x) - section.boundaries[1].height(x);
        sum += (0..100).map(|i| thickness(-15.0 + 0.3 * f64::from(i))).sum::<f64>() / 100.0;
    }
    // R(2.0; ±0.05) of the bottom has a mean that differs from 0 by up to about 0.01 for one individual.
    assert!((sum / 20.0 - expected).abs() < 0.008, "{} {expected}", sum / 20.0);
}

#[test]
fn the_bottom_of_a_starling_is_the_mirror_image_of_its_top() {
    let section = model("starling", None).section(4, 0).unwrap();
    let [top, upper, .., lower, bottom] = &section.boundaries[..] else { panic!("six boundaries") };
    let middle = |a: &Polyline, b: &Polyline| {
        let gap = |i: i32| a.height(-8.0 + 0.02 * f64::from(i)) - b.height(-8.0 + 0.02 * f64::from(i));
        (0..800).map(gap).sum::<f64>() / 800.0
    };
    assert!((middle(top, upper) - middle(lower, bottom)).abs() < 0.01);
    let mean = |curve: &Polyline| curve.z_um.iter().sum::<f64>() / curve.z_um.len() as f64;
    assert!(mean(top).abs() < 1e-12 && (mean(bottom) + 4.0).abs() < 1e-12);
}

/// Starts of the hashes of the written sections: a change of any bit of any coordinate shows here.
const BITS: [(&str, &str); 7] = [
    ("rock-dove", "e16da1755ebc900e"),
    ("starling", "44ed2dde86071eb1"),
    ("bronzewing", "7a7e13dca87feb3a"),
    ("hummingbird", "818b0ad01ddf3496"),
    ("mallard", "ded1cbafc364c7dd"),
    ("magpie", "a80a52edef5a0374"),
    ("peafowl", "e3802e7df76843a5"),
];

#[test]
fn the_same_parameters_seed_and_index_give_the_same_bits() {
    let found = BITS.map(|(name, _)| {
        let model = model(name, None);
        let section = model.section(1, 5).unwrap();
        assert_eq!(section, model.section(1, 5).unwrap());
        assert_ne!(section.boundaries, model.section(1, 6).unwrap().boundaries);
        assert_ne!(section.boundaries, model.section(2, 5).unwrap().boundaries);
        let hash = blake3::hash(barbule::io::section_json(&section).to_string().as_bytes()).to_hex();
        (name, hash[..16].to_owned())
    });
    assert_eq!(found, BITS.map(|(name, hash)| (name, hash.to_owned())));
}
