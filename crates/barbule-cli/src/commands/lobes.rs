//! `barbule lobes`: pictures of a material's BRDF, its parameters, its noise and its fits.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::brdf::pictures::hemisphere;
use barbule::brdf::{FeatherBrdf, FeatherMaterial, Options, lobe_integral};
use barbule::plot::{Anchor, Axis, Drawing, HeatMap, Item, Map, Picture};
use barbule::scattering::directions::omega;
use barbule::scattering::lobe::Lobe;
use barbule::spectrum::colour::{display, luminance};
use barbule::{Error, Result};

use crate::common::Common;
use crate::provenance::{Provenance, check_outputs};
use crate::{lobe_figures, materials};

/// Incident directions of the hemispheres, θ_i and φ_i in degrees.
const INCIDENT: [(f64, f64); 7] =
    [(0.0, 0.0), (0.0, 30.0), (0.0, 60.0), (0.0, 80.0), (40.0, 0.0), (40.0, 40.0), (70.0, 0.0)];

/// Pixels across a hemisphere, and its size on the page.
const PIXELS: usize = 240;
const SIZE: f64 = 120.0;

/// Most instances in one picture.
const MOST_INSTANCES: usize = 20;

/// Arguments of `barbule lobes`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule lobes starling -o lobes.png --instances 3")]
pub(crate) struct Args {
    /// A material file, or SPECIES[:VARIANT]
    material: String,
    /// The figure: .svg or .png
    #[arg(short, long, value_name = "FIG")]
    output: PathBuf,
    /// Draw maps of m_eff, φ_eff − φ_i and F_eff over cosθ_i and cosφ_i
    #[arg(long, group = "what")]
    parameters: bool,
    /// Draw simulated and fitted U and V at 0° and 70°
    #[arg(long, group = "what")]
    fits: bool,
    /// Draw a single barbule's field over x_o for three φ_i and three wavelengths
    #[arg(long, group = "what")]
    fields: bool,
    /// Draw the noise: autocovariances, spectrum and some functions
    #[arg(long, group = "what")]
    noise: bool,
    /// Instances below the smooth lobes, and as many simulated beside synthesized ones [default: 3, synthesized only]
    #[arg(long, value_name = "N", conflicts_with = "what")]
    instances: Option<usize>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, _out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        check_outputs(Some(&self.output), None)?;
        let instances = self.instances.unwrap_or(3);
        if instances > MOST_INSTANCES {
            return Err(Error::input(format!(
                "--instances {instances}: give at most {MOST_INSTANCES}, one row of the picture each"
            )));
        }
        let (material, hash) = materials::find(&self.material, &self.common)?;
        let title = name(&material);
        let drawing = if self.parameters {
            tiled(parameters(&material)?, 3, &title)
        } else if self.noise {
            tiled(lobe_figures::noise(&material, &self.common)?, 2, &title)
        } else if self.fields {
            tiled(lobe_figures::fields(&material, &self.common)?, 2, &title)
        } else if self.fits {
            let beside = Path::new(&self.material).with_extension("zarr");
            tiled(lobe_figures::fits(&material, &beside, &self.common)?, 2, &title)
        } else {
            let above = hemispheres(&material, instances)?;
            match self.instances {
                Some(count) if count > 0 => with_simulated(above, &material, count, &self.common)?,
                _ => above,
            }
        };
        Provenance::new(&self.common)
            .with("material", &self.material)
            .with("material_hash", hash)
            .write_figure(&self.output, &drawing)
    }
}

/// The hemispheres, and below them simulated beside synthesized instances where the barbules can be made again.
fn with_simulated(
    above: Drawing,
    material: &FeatherMaterial,
    count: usize,
    common: &Common,
) -> Result<Drawing> {
    if let Err(error) = materials::structure_of(material, common) {
        common.say(&format!("synthesized instances only: {error}"));
        return Ok(above);
    }
    let below = lobe_figures::instances(material, count, common)?;
    let mut page = Drawing::new(above.width.max(below.width), above.height + below.height);
    let height = above.height;
    page.place(above, [0.0, 0.0]);
    page.place(below, [0.0, height]);
    Ok(page)
}

/// Species and variant as the material's maker recorded them.
fn name(material: &FeatherMaterial) -> String {
    let word = |key: &str| material.info.get(key).and_then(|v| v.as_str()).unwrap_or("").to_owned();
    let thinned = if material.info.get("thin").and_then(|v| v.as_u64()).is_some_and(|t| t > 1) {
        " (thinned)"
    } else {
        ""
    };
    format!("{} {}{thinned}", word("species"), word("variant")).trim().to_owned()
}

/// The smooth lobe and instances (rows) for incident directions (columns), with one exposure per column.
fn hemispheres(material: &FeatherMaterial, instances: usize) -> Result<Drawing> {
    let brdf = FeatherBrdf::new(material, Options::default())?;
    let (left, top) = (86.0, 52.0);
    let rows = instances + 1;
    let width = left + INCIDENT.len() as f64 * (SIZE + 8.0) + 8.0;
    let mut drawing = Drawing::new(width, top + rows as f64 * (SIZE + 8.0) + 8.0);
    let title = format!("{}: f over outgoing directions, x right, y up", name(material));
    drawing.text([8.0, 18.0], 14.0, Anchor::Start, title.trim_start_matches(": ").to_owned());
    for (column, (theta, phi)) in INCIDENT.into_iter().enumerate() {
        let x = left + column as f64 * (SIZE + 8.0);
        let wi = omega(theta.to_radians(), phi.to_radians());
        drawing.text([x + SIZE / 2.0, top - 8.0], 11.0, Anchor::Middle, format!("θ {theta}°, φ {phi}°"));
        let smooth = hemisphere(&brdf, wi, None, PIXELS)?;
        let brightest = smooth.iter().flatten().map(|rgb| luminance(*rgb)).fold(0.0, f64::max);
        let exposure = if brightest > 0.0 { 0.8 / brightest } else { 0.0 };
        for row in 0..rows {
            let y = top + row as f64 * (SIZE + 8.0);
            let values =
                if row == 0 { smooth.clone() } else { hemisphere(&brdf, wi, Some(row as u64), PIXELS)? };
            let rgba = values.iter().map(|value| pixel(*value, exposure)).collect();
            let picture = Picture { width: PIXELS, height: PIXELS, rgba };
            drawing.items.push(Item::Picture { area: [x, y, SIZE, SIZE], picture });
        }
    }
    for row in 0..rows {
        let y = top + row as f64 * (SIZE + 8.0) + SIZE / 2.0;
        let text = if row == 0 { "mean".to_owned() } else { format!("instance {row}") };
        drawing.text([left - 8.0, y], 11.0, Anchor::End, text);
    }
    Ok(drawing)
}

/// sRGB and opacity; outside the hemisphere nothing.
fn pixel(value: Option<[f64; 3]>, exposure: f64) -> [u8; 4] {
    value.map_or([0; 4], |rgb| {
        let [r, g, b] = display(rgb.map(|v| v * exposure));
        [r, g, b, 255]
    })
}

/// Maps of the parameters at the shortest, the middle and the longest wavelength.
fn parameters(material: &FeatherMaterial) -> Result<Vec<Drawing>> {
    let axes = &material.axes;
    let count = axes.wavelengths_nm.len();
    let mut waves = vec![0, count / 2, count - 1];
    waves.dedup();
    let columns = axes.cos_phi.len();
    let per_wave = axes.cos_theta.len() * columns;
    let mut maps = Vec::new();
    for &wave in &waves {
        let lobe = &material.sets[0].mean;
        let nm = axes.wavelengths_nm[wave];
        let node = |at: usize| {
            let (theta, phi_i) = (axes.cos_theta[at / columns].acos(), axes.cos_phi[at % columns].acos());
            let shape = Lobe {
                m: f64::from(lobe.m[wave * per_wave + at]),
                phi: f64::from(lobe.phi[wave * per_wave + at]),
            };
            (theta, phi_i, shape, f64::from(lobe.reflected[wave * per_wave + at]))
        };
        let m = (0..per_wave).map(|at| node(at).2.m).collect();
        let phi = (0..per_wave)
            .map(|at| {
                let (_, phi_i, shape, _) = node(at);
                (shape.phi - phi_i).to_degrees()
            })
            .collect();
        let f = (0..per_wave)
            .map(|at| {
                let (theta, _, shape, reflected) = node(at);
                Ok((reflected / lobe_integral(shape, theta, material.sigma)?).max(1e-6).log10())
            })
            .collect::<Result<Vec<f64>>>()?;
        for (label, values) in [("m_eff", m), ("φ_eff − φ_i (°)", phi), ("log₁₀ F_eff", f)] {
            let signed = values.iter().any(|v| *v < 0.0) && label.contains('°');
            let largest = values.iter().fold(0.1, |a: f64, v| a.max(v.abs()));
            let mut map = HeatMap::new(
                format!("{label}, {nm:.0} nm"),
                Axis::with_range("cosφ_i", axes.cos_phi[0], axes.cos_phi[columns - 1]),
                Axis::with_range("cosθ_i", axes.cos_theta[0], axes.cos_theta[axes.cos_theta.len() - 1]),
                columns,
                values,
            );
            map.size = [240.0, 240.0];
            if signed {
                // White where the lobe's azimuth is the mirror direction's.
                (map.map, map.range) = (Map::Diverging, Some([-largest, largest]));
            }
            maps.push(map.draw());
        }
    }
    Ok(maps)
}

/// Drawings in rows of `columns`, under a title.
fn tiled(drawings: Vec<Drawing>, columns: usize, title: &str) -> Drawing {
    let width = drawings.iter().map(|d| d.width).fold(0.0, f64::max);
    let height = drawings.iter().map(|d| d.height).fold(0.0, f64::max);
    let rows = drawings.len().div_ceil(columns);
    let mut page = Drawing::new(width * columns as f64, 28.0 + height * rows as f64);
    page.text([8.0, 18.0], 14.0, Anchor::Start, title);
    for (k, drawing) in drawings.into_iter().enumerate() {
        page.place(drawing, [(k % columns) as f64 * width, 28.0 + (k / columns) as f64 * height]);
    }
    page
}
