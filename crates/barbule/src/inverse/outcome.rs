//! What a fit answers, in words and as a document: the same on the command line and from Python.

use serde_json::{Map, Value, json};

use super::{Estimate, Fit, Parameter, Reading, Solution};

/// What was found.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The solutions.
    pub fit: Fit,
    /// The text of a file of the best one, which simulates as any other of its kind.
    pub toml: String,
    /// Of species and lattices: how far the tables are off, and how many spectra were simulated.
    pub tables: Option<(f64, usize)>,
}

/// The best solution as comments of a file.
pub(super) fn comments(fit: &Fit) -> String {
    let best = &fit.solutions[0];
    let lines = fit.parameters.iter().zip(&best.sizes).map(|(p, size)| format!("# {}\n", in_words(p, size)));
    let fitted = "# Fitted to a measurement; 95 % intervals:\n".to_owned();
    std::iter::once(fitted).chain(lines).collect()
}

/// A size with its interval, as `thickness_nm 643.2 nm, 95 %: 641.0 to 645.4`.
#[must_use]
pub fn in_words(p: &Parameter, size: &Estimate) -> String {
    let digits = size.digits();
    let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
    let Estimate { value, low, high, open } = *size;
    let bound = |open: bool| if open { " (end of the range)" } else { "" };
    format!(
        "{} {value:.digits$}{unit}, 95 %: {low:.digits$}{} to {high:.digits$}{}",
        p.name,
        bound(open[0]),
        bound(open[1])
    )
}

impl Estimate {
    /// Digits behind the point that show its interval to two figures, at most six.
    #[must_use]
    pub fn digits(&self) -> usize {
        let width = 0.5 * (self.high - self.low);
        if width <= 0.0 {
            return 6;
        }
        (1.0 - width.log10().floor()).clamp(0.0, 6.0) as usize
    }
}

impl Outcome {
    /// Everything as one document; `readings` are those that were fitted. Wavelengths in nm; `level` and `offset` are what the model is
    /// multiplied by and what is added to it, one of each for every reading.
    #[must_use]
    pub fn document(&self, readings: &[Reading]) -> Value {
        let Fit { parameters, solutions, noise, doubts } = &self.fit;
        let solutions: Vec<Value> = solutions.iter().map(|one| solution(parameters, one)).collect();
        let readings: Vec<Value> = readings
            .iter()
            .zip(noise)
            .map(|(reading, noise)| {
                json!({
                    "name": reading.name,
                    "wavelength_nm": reading.mean.wavelengths().nm(),
                    "measured": reading.mean.values(),
                    "samples": reading.samples.len().max(1),
                    "noise": {
                        "sigma": noise.sigma, "correlation_nm": noise.correlation_nm, "white_part": noise.white,
                    },
                })
            })
            .collect();
        let mut document = json!({ "solutions": solutions, "readings": readings, "doubts": doubts });
        if let Some((error, simulated)) = self.tables {
            document["table_error"] = error.into();
            document["simulated"] = simulated.into();
        }
        document
    }
}

fn solution(parameters: &[Parameter], one: &Solution) -> Value {
    let size = |(k, (p, size)): (usize, (&Parameter, &Estimate))| {
        let std = one.between_samples.as_ref().map(|all| all[k]);
        let value = json!({
            "value": size.value, "low": size.low, "high": size.high, "unit": p.unit, "open": size.open,
            "between_samples_std": std,
        });
        (p.name.clone(), value)
    };
    let sizes: Map<String, Value> = parameters.iter().zip(&one.sizes).enumerate().map(size).collect();
    let fitted: Vec<&[f64]> = one.fitted.iter().map(|curve| curve.values()).collect();
    // Infinite variances are null.
    json!({
        "parameters": sizes,
        "rmse": one.rmse,
        "explained": one.explained,
        "worse_by": one.worse_by,
        "as_good": one.as_good,
        "level": one.levels.iter().map(|[level, _]| level).collect::<Vec<_>>(),
        "offset": one.levels.iter().map(|[_, offset]| offset).collect::<Vec<_>>(),
        "covariance": one.covariance,
        "fitted": fitted,
    })
}
