//! `barbule lobes`: pictures of a material's BRDF, its parameters, its noise and its fits.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::brdf::fit::fitted_values;
use barbule::brdf::pictures::hemisphere;
use barbule::brdf::{FeatherBrdf, LobeSet, Material, Noise, Options, lobe_integral};
use barbule::io::read_material;
use barbule::io::store::Store;
use barbule::plot::{Anchor, Axis, Curve, Drawing, Figure, HeatMap, Item, Picture};
use barbule::scattering::directions::{azimuths, omega};
use barbule::scattering::lobe::Lobe;
use barbule::scattering::statistics::{AZIMUTHS, NOISE_POINTS, Statistics};
use barbule::spectrum::colour::{display, luminance};
use barbule::{Error, Result};

use crate::common::Common;
use crate::provenance::{Provenance, check_outputs};

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
#[command(after_help = "Example:\n  barbule lobes starling.barbule -o lobes.png --instances 3")]
pub(crate) struct Args {
    /// A material file
    material: PathBuf,
    /// The figure: .svg or .png
    #[arg(short, long, value_name = "FIG")]
    output: PathBuf,
    /// Draw maps of m_eff, φ_eff − φ_i and F_eff over cosθ_i and cosφ_i
    #[arg(long, group = "what")]
    parameters: bool,
    /// Draw simulated and fitted U and V at 0° and 70°; reads the campaign store of the same name ending in .zarr
    #[arg(long, group = "what")]
    fits: bool,
    /// Draw the noise: autocovariance, spectrum and some functions
    #[arg(long, group = "what")]
    noise: bool,
    /// How many synthesized instances to draw below the smooth lobes [default: 3]
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
        let material = read_material(&self.material)?;
        let drawing = if self.parameters {
            parameters(&material)?
        } else if self.noise {
            noise(&material)
        } else if self.fits {
            fits(&material, &statistics(&self.material, &material)?)
        } else {
            hemispheres(&material, instances)?
        };
        Provenance::new(&self.common)
            .with("material", self.material.display().to_string())
            .write_figure(&self.output, &drawing)
    }
}

/// Species and variant as the material's maker recorded them.
fn name(material: &Material) -> String {
    let word = |key: &str| material.info.get(key).and_then(|v| v.as_str()).unwrap_or("").to_owned();
    let thinned = if material.info.get("thin").and_then(|v| v.as_u64()).is_some_and(|t| t > 1) {
        " (thinned)"
    } else {
        ""
    };
    format!("{} {}{thinned}", word("species"), word("variant")).trim().to_owned()
}

/// The smooth lobe and instances (rows) for incident directions (columns), with one exposure per column.
fn hemispheres(material: &Material, instances: usize) -> Result<Drawing> {
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
fn parameters(material: &Material) -> Result<Drawing> {
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
            let mut map = HeatMap::new(
                format!("{label}, {nm:.0} nm"),
                Axis::with_range("cosφ_i", axes.cos_phi[0], axes.cos_phi[columns - 1]),
                Axis::with_range("cosθ_i", axes.cos_theta[0], axes.cos_theta[axes.cos_theta.len() - 1]),
                columns,
                values,
            );
            map.size = [230.0, 210.0];
            maps.push(map.draw());
        }
    }
    Ok(tiled(maps, 3, &name(material)))
}

/// Autocovariance and spectrum of the noise, and three functions of it.
fn noise(material: &Material) -> Drawing {
    let noise = Noise::new(&material.noise_power, material.seed);
    let spacing = 2.0 / NOISE_POINTS as f64;
    let lags = noise.autocovariance().iter().enumerate().take(NOISE_POINTS / 8);
    let mut covariance = Figure::new("autocovariance C₀", Axis::new("Δx"), Axis::new("C₀"));
    covariance.curves.push(Curve::line("C₀", lags.map(|(k, c)| [k as f64 * spacing, *c]).collect()));
    let mut power = Figure::new("power spectrum P", Axis::new("term l"), Axis::new("P"));
    let terms = material.noise_power.iter().enumerate();
    power.curves.push(Curve::line("P", terms.map(|(l, p)| [(l + 1) as f64, *p]).collect()));
    let mut functions = Figure::new("q_r of three instances", Axis::new("x"), Axis::new("q"));
    for instance in 0..3 {
        let draw = noise.draw(instance);
        let points = (0..800).map(|k| {
            let x = f64::from(k) / 400.0 - 1.0;
            [x, f64::from(noise.at(&draw, x as f32)[0])]
        });
        functions.curves.push(Curve::line(format!("instance {instance}"), points.collect()));
    }
    tiled(vec![covariance.draw(), power.draw(), functions.draw()], 1, &name(material))
}

/// The statistics that a material was fitted to: the store beside it.
fn statistics(path: &Path, material: &Material) -> Result<Statistics> {
    let beside = path.with_extension("zarr");
    if !beside.is_dir() {
        return Err(Error::input(format!(
            "{}: --fits compares with the campaign's store, which is not there; keep it beside the material under this name",
            beside.display()
        )));
    }
    let statistics = Store::open(&beside)?.statistics()?;
    if statistics.axes != material.axes {
        return Err(Error::input(format!(
            "{}: has other wavelengths or directions than {}; fit the material from this store",
            beside.display(),
            path.display()
        )));
    }
    Ok(statistics)
}

/// Simulated and fitted U and V over φ_o, at θ_i nearest to 0 and φ_i nearest to 0° and 70°, at three wavelengths.
fn fits(material: &Material, statistics: &Statistics) -> Drawing {
    let axes = &material.axes;
    let theta = axes.cos_theta.len() - 1;
    let nearest = |cosine: f64| {
        let apart = |k: &usize| (axes.cos_phi[*k] - cosine).abs();
        (0..axes.cos_phi.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0)
    };
    let count = axes.wavelengths_nm.len();
    let mut waves = vec![0, count / 2, count - 1];
    waves.dedup();
    let mut charts = Vec::new();
    for &wave in &waves {
        for phi in [nearest(1.0), nearest(70.0_f64.to_radians().cos())] {
            let node = axes.index(wave, theta, phi);
            let title = format!(
                "{:.0} nm, φ_i = {:.0}°",
                axes.wavelengths_nm[wave],
                axes.cos_phi[phi].acos().to_degrees()
            );
            let mut figure = Figure::new(title, Axis::new("φ_o (°)"), Axis::new("per radian"));
            for (label, array, part) in [("U", &statistics.u, 0), ("V", &statistics.v, 1)] {
                let simulated = mean_over_polarizations(array, node);
                let fitted = fitted_mean(material, node, axes.cos_theta[theta].acos(), part);
                let degrees = |values: Vec<f64>| {
                    azimuths(AZIMUTHS).map(f64::to_degrees).zip(values).map(|(x, y)| [x, y]).collect()
                };
                figure.curves.push(Curve::line(format!("{label} simulated"), degrees(simulated)));
                figure.curves.push(Curve::line(format!("{label} fitted"), degrees(fitted)));
            }
            charts.push(figure.draw());
        }
    }
    tiled(charts, 2, &name(material))
}

fn mean_over_polarizations(array: &[f32], node: usize) -> Vec<f64> {
    let part = |p: usize| &array[(node * 2 + p) * AZIMUTHS..][..AZIMUTHS];
    part(0).iter().zip(part(1)).map(|(a, b)| 0.5 * f64::from(a + b)).collect()
}

/// U' (`part` 0) or V' (1) of the material, mean over its sets.
fn fitted_mean(material: &Material, node: usize, theta: f64, part: usize) -> Vec<f64> {
    let mut sum = vec![0.0; AZIMUTHS];
    for set in &material.sets {
        let lobe: &LobeSet = if part == 0 { &set.mean } else { &set.stationary };
        let shape = Lobe { m: f64::from(lobe.m[node]), phi: f64::from(lobe.phi[node]) };
        let values = fitted_values(material.kind, shape, theta, f64::from(lobe.reflected[node]));
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += value / material.sets.len() as f64;
        }
    }
    sum
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
