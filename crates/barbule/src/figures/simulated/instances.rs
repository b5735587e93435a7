//! Simulated beside synthesized barbules on their specular cones.

use serde::Serialize;

use super::{PER_RADIAN, nearest};
use crate::Result;
use crate::brdf::{FeatherMaterial, Synthesis};
use crate::campaign::Keep;
use crate::campaign::single::intensities;
use crate::characterize::Barbules;
use crate::plot::{Anchor, Axis, Curve, Drawing, Figure, Item, Picture};
use crate::progress::Progress;
use crate::scattering::directions::azimuths;
use crate::scattering::statistics::{AZIMUTHS, Axes};
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::{Observer, Weights, display, luminance};

/// Most wavelengths that the colours of instances are made of.
const COLOUR_SAMPLES: usize = 25;

/// Height of a strip of the specular cone, and its least distance to the next.
const STRIP: [f64; 2] = [20.0, 4.0];

/// Instances 0, 1 … of a material beside barbules 0, 1 … that it was simulated from, for two incident directions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InstancePatterns {
    /// The wavelengths, nm.
    pub wavelength_nm: Vec<f64>,
    /// φ_o of all patterns, degrees.
    pub phi_out_deg: Vec<f64>,
    /// One for each incident direction.
    pub directions: Vec<Column>,
}

/// One incident direction: intensities of unpolarized light, 1/rad.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Column {
    /// θ_i, degrees.
    pub theta_in_deg: f64,
    /// φ_i, degrees.
    pub phi_in_deg: f64,
    /// Of simulated barbules, `[wavelength][instance][phi_out]`.
    pub simulated: Vec<Vec<Vec<f64>>>,
    /// Of synthesized ones, likewise.
    pub synthesized: Vec<Vec<Vec<f64>>>,
    /// The fitted mean, `[wavelength][phi_out]`.
    pub mean: Vec<Vec<f64>>,
}

impl InstancePatterns {
    /// `count` of each, at θ_i nearest to 0 and φ_i nearest to 0° and 45°.
    ///
    /// # Errors
    /// As [`Barbules::campaign`].
    pub fn new(
        material: &FeatherMaterial,
        count: usize,
        barbules: &Barbules,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let from = &material.axes;
        let theta = from.cos_theta().len() - 1;
        let mut phis =
            vec![nearest(from.cos_phi(), 45.0_f64.to_radians().cos()), nearest(from.cos_phi(), 1.0)];
        phis.dedup();
        let every = from.wavelengths_nm().len().div_ceil(COLOUR_SAMPLES);
        let waves: Vec<usize> = (0..from.wavelengths_nm().len()).step_by(every).collect();
        let nm: Vec<f64> = waves.iter().map(|k| from.wavelengths_nm()[*k]).collect();
        let cos_phi = phis.iter().map(|k| from.cos_phi()[*k]).collect();
        let axes = Axes::new(&Wavelengths::new(nm.clone())?, vec![from.cos_theta()[theta]], cos_phi)?;
        let campaign = barbules.campaign(axes, Some(count), true, progress)?;
        let count = campaign.parameters().realizations();
        let kept = (0..waves.len())
            .map(|w| Ok(campaign.unit(&campaign.tables(w, progress)?, 0, Keep::Fields, progress)?.fields))
            .collect::<Result<Vec<_>>>()?;
        let noise = material.noise();
        let column = |place: usize| {
            let node = |wave: usize| from.index(wave, theta, phis[place]);
            let synthesis: Vec<Synthesis> =
                waves.iter().map(|w| Synthesis::new(material, node(*w))).collect();
            let drawn = |s: &Synthesis| (0..count).map(|n| s.intensity(&noise, n as u64)).collect();
            let mean = |s: &Synthesis| {
                let [a, b] = s.mean();
                a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect()
            };
            Column {
                theta_in_deg: from.theta_i(theta).to_degrees(),
                phi_in_deg: from.phi_i(phis[place]).to_degrees(),
                simulated: kept.iter().map(|fields| intensities(fields, place, count)).collect(),
                synthesized: synthesis.iter().map(drawn).collect(),
                mean: synthesis.iter().map(mean).collect(),
            }
        };
        Ok(Self {
            directions: (0..phis.len()).rev().map(column).collect(),
            phi_out_deg: azimuths(AZIMUTHS).map(f64::to_degrees).collect(),
            wavelength_nm: nm,
        })
    }

    /// Side by side the incident directions, each with colours over φ_o and the intensity at the middle wavelength.
    ///
    /// # Errors
    /// None: the wavelengths rise.
    pub fn draw(&self) -> Result<Drawing> {
        let weights = Observer::default().weights(&Wavelengths::new(self.wavelength_nm.clone())?);
        let columns: Vec<Drawing> =
            self.directions.iter().map(|column| self.column(column, &weights)).collect();
        let mut page = Drawing::new(
            columns.iter().map(|c| c.width).sum(),
            columns.iter().map(|c| c.height).fold(0.0, f64::max),
        );
        let mut x = 0.0;
        for column in columns {
            let width = column.width;
            page.place(column, [x, 0.0]);
            x += width;
        }
        Ok(page)
    }

    fn column(&self, column: &Column, weights: &Weights) -> Drawing {
        let (left, width) = (64.0, 360.0);
        let nm = &self.wavelength_nm;
        let colour = |of: &dyn Fn(usize) -> f64| {
            let samples: Vec<f64> = (0..nm.len()).map(of).collect();
            weights.linear_rgb(&samples)
        };
        let brightest =
            (0..AZIMUTHS).map(|k| luminance(colour(&|w| column.mean[w][k]))).fold(1e-30, f64::max);
        // Single barbules are a few times as bright as their mean.
        let exposure = 0.4 / brightest;
        let middle = nm.len() / 2;
        let sides = [("simulated", &column.simulated), ("synthesized", &column.synthesized)];
        let all = sides.iter().flat_map(|(_, side)| side[middle].iter().flatten());
        let highest = all.fold(1e-30, |a: f64, b| a.max(*b));
        let mut page = Drawing::new(left + width + 120.0, 0.0);
        let direction = format!("θ_i = {:.0}°, φ_i = {:.0}°", column.theta_in_deg, column.phi_in_deg);
        page.text([left + width / 2.0, 22.0], 14.0, Anchor::Middle, direction);
        let mut y = 40.0;
        for (name, side) in sides {
            page.text([left, y + 4.0], 12.0, Anchor::Start, format!("{name} barbules: colour over φ_o"));
            y += 12.0;
            let strip = |instance: usize| {
                let rgba = (0..AZIMUTHS).map(|k| {
                    let rgb = colour(&|w| side[w][instance][k]);
                    let [r, g, b] = display(rgb.map(|v| v * exposure));
                    [r, g, b, 255]
                });
                Picture { width: AZIMUTHS, height: 1, rgba: rgba.collect() }
            };
            for picture in (0..side[0].len()).map(strip) {
                page.items.push(Item::Picture { area: [left, y, width, STRIP[0]], picture });
                y += STRIP[0] + STRIP[1];
            }
            let mut figure = Figure::new(
                format!("{name}, {:.0} nm", nm[middle]),
                Axis::with_range("φ_o (°)", -90.0, 90.0),
                Axis::with_range(PER_RADIAN, 0.0, 1.05 * highest),
            );
            figure.size = [width, 150.0];
            for (instance, values) in side[middle].iter().enumerate() {
                let points = self.phi_out_deg.iter().zip(values).map(|(x, y)| [*x, *y]);
                figure.curves.push(Curve::line(format!("instance {instance}"), points.collect()));
            }
            let chart = figure.draw();
            let height = chart.height;
            page.place(chart, [0.0, y + 4.0]);
            y += height + 24.0;
        }
        page.height = y;
        page
    }
}
