//! Values of two shipped materials by which every back end is held: shared by the tests and the program that writes them.

use barbule::brdf::{BrdfTables, FeatherBrdf, Options, TABLES_VERSION};
use barbule::io::hash_bytes;
use barbule::scattering::directions::omega;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// One of layers of granules, and one of a crystal.
const MATERIALS: [&str; 2] = ["hummingbird-anna", "peafowl-yellow"];

/// A barbule.
const INSTANCE: u64 = 7;

/// Below the tables, between two of their wavelengths, and on one of them, nm.
const WAVELENGTHS_NM: [f64; 4] = [390.0, 457.25, 571.5, 682.0];

/// θ_i and φ_i, degrees: the normal, both sides, grazing across, along and in both.
const INCIDENT: [[f64; 2]; 6] =
    [[0.0, 0.0], [20.0, 35.0], [-50.0, -15.0], [5.0, -86.0], [80.0, 10.0], [-75.0, 70.0]];

/// Degrees from the mirror direction: θ_o, φ_o.
const AWAY: [[f64; 2]; 7] =
    [[0.0, 0.0], [1.0, -2.0], [-2.0, 5.0], [3.0, -10.0], [0.0, 25.0], [4.0, -60.0], [12.0, 3.0]];

/// Numbers that directions are drawn with.
const RANDOM: [[f64; 2]; 4] = [[0.0625, 0.5], [0.375, 0.9375], [0.71875, 0.046875], [0.984375, 0.25]];

/// The file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Golden {
    pub(crate) origin: String,
    pub(crate) version: u32,
    pub(crate) wavelengths_nm: Vec<f64>,
    pub(crate) instance: u64,
    pub(crate) u: Vec<[f64; 2]>,
    pub(crate) materials: Vec<Material>,
}

/// One material.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Material {
    pub(crate) name: String,
    /// BLAKE3 of its file.
    pub(crate) hash: String,
    pub(crate) light: Vec<Light>,
}

/// One incident direction.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Light {
    pub(crate) wi: [f64; 3],
    pub(crate) wo: Vec<[f64; 3]>,
    /// f of the smooth mean, of the instance, and the density, `[wavelength][wo]`, 1/sr.
    pub(crate) mean: Vec<Vec<f64>>,
    pub(crate) drawn: Vec<Vec<f64>>,
    pub(crate) pdf: Vec<Vec<f64>>,
    /// Directions drawn with each u, `[wavelength][u]`.
    pub(crate) sampled: Vec<Vec<Option<[f64; 3]>>>,
}

/// The tables of a material of the file.
pub(crate) fn tables(name: &str) -> BrdfTables {
    let material = barbule::io::decode_material(barbule_birds::material(name).unwrap()).unwrap();
    BrdfTables::new(&material, Options::default()).unwrap()
}

impl Golden {
    /// What the exact formulas say.
    pub(crate) fn made() -> Self {
        Self {
            origin: format!(
                "cargo run --release -p barbule --example brdf_golden (barbule {}): docs/formats/brdf-tables.md in double precision",
                env!("CARGO_PKG_VERSION")
            ),
            version: TABLES_VERSION,
            wavelengths_nm: WAVELENGTHS_NM.to_vec(),
            instance: INSTANCE,
            u: RANDOM.to_vec(),
            materials: MATERIALS.iter().map(|name| Material::made(name)).collect(),
        }
    }
}

impl Material {
    fn made(name: &str) -> Self {
        let brdf = FeatherBrdf::from_tables(tables(name));
        let light = INCIDENT.iter().map(|angles| Light::made(&brdf, *angles)).collect();
        let bytes = barbule_birds::material(name).unwrap();
        Self { name: name.to_owned(), hash: hash_bytes(bytes), light }
    }
}

impl Light {
    fn made(brdf: &FeatherBrdf, [theta, phi]: [f64; 2]) -> Self {
        let direction = |theta: f64, phi: f64| {
            let within = |angle: f64| angle.clamp(-89.0, 89.0).to_radians();
            omega(within(theta), within(phi))
        };
        let wi = direction(theta, phi);
        let wo: Vec<DVec3> = AWAY.iter().map(|[t, p]| direction(t - theta, p - phi)).collect();
        let rows = |of: &dyn Fn(f64, DVec3) -> f64| -> Vec<Vec<f64>> {
            let row = |nm: &f64| wo.iter().map(|wo| of(*nm, *wo)).collect();
            WAVELENGTHS_NM.iter().map(row).collect()
        };
        let sampled = |nm: &f64| {
            let drawn = |u: &[f64; 2]| Some(brdf.sample(*nm as f32, wi, *u)?.0.to_array());
            RANDOM.iter().map(drawn).collect()
        };
        Self {
            wi: wi.to_array(),
            mean: rows(&|nm, wo| brdf.exact(nm, wi).values(wo, None).f),
            drawn: rows(&|nm, wo| brdf.exact(nm, wi).values(wo, Some(INSTANCE)).f),
            pdf: rows(&|nm, wo| brdf.exact(nm, wi).values(wo, None).pdf),
            sampled: WAVELENGTHS_NM.iter().map(sampled).collect(),
            wo: wo.iter().map(DVec3::to_array).collect(),
        }
    }
}
