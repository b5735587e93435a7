//! The noise process, and the autocovariances that it was made of.

use serde::Serialize;

use super::ghost;
use crate::Result;
use crate::brdf::{At, FeatherMaterial};
use crate::characterize::Barbules;
use crate::plot::{Axis, Curve, Drawing, Figure, Ink, Stroke};
use crate::progress::Progress;
use crate::scattering::far_field::Polarization;
use crate::scattering::statistics::{Axes, LAGS, NOISE_POINTS};
use crate::spectrum::Wavelengths;

/// Instances whose noise is shown, and barbules whose autocovariance is.
const SHOWN: usize = 3;

/// Autocovariances, power and some draws of a material's noise. Autocovariances are 1 at lag 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseCurves {
    /// Lags Δx of all autocovariances.
    pub lag: Vec<f64>,
    /// C₀ of the noise.
    pub c0: Vec<f64>,
    /// Of the barbules that the material was simulated from, where they can be made again.
    pub simulated: Option<Covariances>,
    /// P₁ … of the process (S.34).
    pub power: Vec<f64>,
    /// Places of `q_r`.
    pub x: Vec<f64>,
    /// q_r of instances 0, 1, 2, `[instance][x]`.
    pub q_r: Vec<Vec<f64>>,
}

/// Autocovariances of simulated fields at normal incidence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Covariances {
    /// The shortest and the longest wavelength, nm.
    pub wavelength_nm: [f64; 2],
    /// Of barbules 0, 1, 2 in polarization 1 at the shortest wavelength.
    pub barbules: Vec<Vec<f64>>,
    /// Means of all barbules and both polarizations at both wavelengths.
    pub mean: [Vec<f64>; 2],
    /// l at the longest wavelength.
    pub length: f64,
}

impl NoiseCurves {
    /// Of a material, and of its barbules where they are at hand.
    ///
    /// # Errors
    /// As [`Barbules::campaign`].
    pub fn new(
        material: &FeatherMaterial,
        barbules: Option<&Barbules>,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let noise = material.noise();
        let x: Vec<f64> = (0..=800).map(|k| f64::from(k) / 400.0 - 1.0).collect();
        let q_r = (0..SHOWN as u64).map(|instance| {
            let draw = noise.draw(instance);
            // As at one wavelength, where nothing but x changes.
            let at = |x: &f64| At { x: *x, achromatic_x: *x, height_phase_per_um: 0.0 };
            x.iter().map(|x| noise.at_both(&draw, &at(x), 1.0)[0][0]).collect()
        });
        Ok(Self {
            lag: (0..LAGS).map(|k| 2.0 * k as f64 / NOISE_POINTS as f64).collect(),
            c0: normalized(&noise.autocovariance()[..LAGS]),
            simulated: barbules.map(|barbules| Covariances::new(material, barbules, progress)).transpose()?,
            power: material.noise_power.clone(),
            q_r: q_r.collect(),
            x,
        })
    }

    /// Autocovariances above, power and functions below.
    #[must_use]
    pub fn draw(&self) -> Vec<Drawing> {
        let mut charts = match &self.simulated {
            Some(simulated) => self.covariances(simulated).into(),
            None => {
                let mut figure = covariance_figure("autocovariance C₀");
                figure.curves.push(self.lags("C₀", &self.c0, 1.0));
                vec![figure.draw()]
            }
        };
        let last = self.power.iter().rposition(|p| *p > 1e-3 * 0.5 / LAGS as f64).unwrap_or(LAGS) + 2;
        let end = (last as f64 * 1.2).min(LAGS as f64);
        let mut power = Figure::new(
            "power spectrum of the noise",
            Axis::with_range("term l (periods in x = −1 … 1)", 0.0, end),
            Axis::new("P"),
        );
        let terms = self.power.iter().enumerate();
        power.curves.push(Curve::line("P", terms.map(|(l, p)| [(l + 1) as f64, *p]).collect()));
        power.size = [420.0, 260.0];
        let mut functions =
            Figure::new("q_r of three instances", Axis::with_range("x", -1.0, 1.0), Axis::new("q"));
        functions.size = [420.0, 260.0];
        for (instance, q) in self.q_r.iter().enumerate() {
            let points = self.x.iter().zip(q).map(|(x, q)| [*x, *q]);
            functions.curves.push(Curve::line(format!("instance {instance}"), points.collect()));
        }
        charts.extend([power.draw(), functions.draw()]);
        charts
    }

    /// Single barbules with their mean at the shortest wavelength, and the mean at the longest one with C₀ stretched to it.
    fn covariances(&self, simulated: &Covariances) -> [Drawing; 2] {
        let Covariances { wavelength_nm: [shortest, longest], barbules, mean, length } = simulated;
        let mut single = covariance_figure(&format!("single barbules and their mean, {shortest:.0} nm"));
        for (number, own) in barbules.iter().enumerate() {
            single.curves.push(self.lags(&format!("barbule {number}"), own, 1.0));
        }
        let heavy = Some(Stroke::solid(Ink::BLACK, 2.6));
        single.curves.push(Curve { stroke: heavy, ..self.lags("mean of all", &mean[0], 1.0) });
        let mut scaled = covariance_figure(&format!("C at {longest:.0} nm and C₀ scaled by l = {length:.3}"));
        let faint = self.lags(&format!("simulated, {longest:.0} nm"), &mean[1], 1.0);
        scaled.curves.push(Curve { stroke: ghost(), ..faint });
        scaled.curves.push(self.lags("C₀ of the noise", &self.c0, 1.0));
        scaled.curves.push(self.lags(&format!("C₀(Δx/{length:.3})"), &self.c0, *length));
        [single.draw(), scaled.draw()]
    }

    /// An autocovariance over Δx, stretched by `scale`.
    fn lags(&self, name: &str, values: &[f64], scale: f64) -> Curve {
        Curve::line(name, self.lag.iter().zip(values).map(|(lag, c)| [lag * scale, *c]).collect())
    }
}

impl Covariances {
    fn new(material: &FeatherMaterial, barbules: &Barbules, progress: &dyn Progress) -> Result<Self> {
        let from = &material.axes;
        let all = from.wavelengths_nm();
        let last = all.len() - 1;
        let waves = [all[0], all[last]];
        let (theta, phi) = (from.cos_theta().len() - 1, from.cos_phi().len() - 1);
        // A single wavelength is the shortest and the longest.
        let simulated = Wavelengths::new(&waves[..if last == 0 { 1 } else { 2 }])?;
        let axes = Axes::new(&simulated, vec![from.cos_theta()[theta]], vec![from.cos_phi()[phi]])?;
        let campaign = barbules.campaign(axes, None, true, progress)?;
        let mut single = Vec::new();
        let mut means = [vec![0.0; LAGS], vec![0.0; LAGS]];
        for (number, mean) in means.iter_mut().enumerate() {
            let tables = campaign.tables(number.min(last), progress)?;
            for polarization in Polarization::BOTH {
                let patterns = campaign.patterns(&tables, 0, 0, polarization, progress)?;
                for instance in 0..patterns.fields.len() {
                    let own = patterns.autocovariance(instance);
                    for (sum, value) in mean.iter_mut().zip(&own) {
                        *sum += value;
                    }
                    if number == 0 && polarization == Polarization::First && instance < SHOWN {
                        single.push(normalized(&own));
                    }
                }
            }
        }
        Ok(Self {
            wavelength_nm: waves,
            barbules: single,
            mean: means.map(|mean| normalized(&mean)),
            length: f64::from(material.sets[0].length[from.index(last, theta, phi)]),
        })
    }
}

fn covariance_figure(title: &str) -> Figure {
    let mut figure = Figure::new(title, Axis::with_range("Δx", 0.0, 0.25), Axis::new("autocovariance"));
    figure.size = [420.0, 260.0];
    figure
}

/// With value 1 at lag 0.
fn normalized(values: &[f64]) -> Vec<f64> {
    let first = values.first().copied().filter(|v| *v > 0.0).unwrap_or(1.0);
    values.iter().map(|v| v / first).collect()
}
