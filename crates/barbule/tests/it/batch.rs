//! Many pairs of directions together, against each by itself.

use barbule::brdf::fixtures::{example, halo};
use barbule::brdf::{FeatherBrdf, FeatherMaterial, Options, Reciprocity};
use barbule::io::decode_material;
use barbule::math::rng::Stream;
use barbule::scattering::far_field::Polarization;
use glam::DVec3;

/// Pairs and eight wavelengths of each.
struct Pairs {
    directions: Vec<[DVec3; 2]>,
    wavelengths_nm: Vec<[f32; 4]>,
}

impl Pairs {
    /// Where the lobe sends light, at random, along the normal, flat, and below the horizon; wavelengths beyond both ends of the tables too.
    fn new(brdf: &FeatherBrdf, count: usize) -> Self {
        let mut stream = Stream::new(17, &[]);
        let mut all = Self { directions: Vec::new(), wavelengths_nm: Vec::new() };
        let anywhere = |stream: &mut Stream, lowest: f64| {
            let z = stream.uniform(lowest, 1.0);
            let (sin, cos) = stream.uniform(0.0, 6.3).sin_cos();
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * cos, r * sin, z)
        };
        for k in 0..count {
            let wi = match k % 10 {
                0 => DVec3::Z,
                1 => DVec3::new(0.8, -0.6, 1e-7).normalize(),
                2 => anywhere(&mut stream, -1.0),
                _ => anywhere(&mut stream, 0.0),
            };
            let u = [stream.unit(), stream.unit()];
            let drawn = brdf.sample(500.0, wi, u).map(|(wo, _)| wo);
            let wo = drawn.filter(|_| k % 4 > 0).unwrap_or_else(|| anywhere(&mut stream, -0.5));
            all.directions.push([wi, wo]);
            for _ in 0..2 {
                all.wavelengths_nm.push([(); 4].map(|()| stream.uniform(280.0, 800.0) as f32));
            }
        }
        all
    }

    fn assert_alike(&self, brdf: &FeatherBrdf, what: &str) {
        let names: Vec<u64> = (0..self.directions.len() as u64).map(|k| k * k).collect();
        let mut values = vec![[f32::NAN; 4]; self.wavelengths_nm.len()];
        for names in [None, Some(&names[..])] {
            brdf.eval_all(&self.directions, &self.wavelengths_nm, names, &mut values);
            let mut lit = 0;
            for (k, (nm, found)) in self.wavelengths_nm.iter().zip(&values).enumerate() {
                let [wi, wo] = self.directions[k / 2];
                let expected = brdf.eval(*nm, wi, wo, names.map(|names| names[k / 2]));
                assert_eq!(*found, expected, "{what}: {wi} {wo} {nm:?}");
                lit += usize::from(found[0] > 0.0);
            }
            assert!(2 * lit > self.directions.len(), "{what}: {lit}");
        }
    }
}

fn assert_alike(material: &FeatherMaterial, polarizations: &[Option<Polarization>], what: &str) {
    for &polarization in polarizations {
        let brdf = FeatherBrdf::new(material, Options { polarization, ..Options::default() }).unwrap();
        // No multiple of those that are prepared at a time.
        let pairs = Pairs::new(&brdf, 203);
        for reciprocity in [Reciprocity::AsFitted, Reciprocity::Steeper, Reciprocity::Mean] {
            pairs.assert_alike(
                &brdf.reciprocal_by(reciprocity),
                &format!("{what}, {polarization:?}, {reciprocity:?}"),
            );
        }
    }
}

const POLARIZATIONS: [Option<Polarization>; 3] =
    [None, Some(Polarization::First), Some(Polarization::Second)];

/// Tables with halos and without, of one side and of both.
#[test]
fn pairs_of_shipped_materials_have_the_same_bits_together() {
    for (stem, bytes) in barbule_birds::materials() {
        let material = decode_material(bytes).unwrap();
        assert_alike(&material, &POLARIZATIONS[..1], stem);
    }
}

/// Of one set and of one for each polarization; one wavelength that is nowhere evenly spaced.
#[test]
fn pairs_have_the_same_bits_together_for_all_options() {
    let one = example(3);
    assert_alike(&one, &POLARIZATIONS, "one set");
    assert_alike(&FeatherMaterial { halo: Some(halo()), ..example(1) }, &POLARIZATIONS, "halo");
    let mut two = one;
    let mut second = two.sets[0].clone();
    for lobe in &mut second.mean {
        lobe.m.iter_mut().for_each(|m| *m *= 1.3);
        lobe.reflected.iter_mut().for_each(|rho| *rho *= 0.4);
    }
    two.sets.push(second);
    for set in &mut two.sets {
        (set.fraction_1, set.fraction_1_slope) = (Vec::new(), Vec::new());
    }
    assert_alike(&two, &POLARIZATIONS, "two sets");
}
