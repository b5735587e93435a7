//! How sure the numbers of a spectrum's colour are.

use barbule::Result;
use barbule::campaign::spectrum::Individuals;
use barbule::confidence::{Intervals, Known, Simulated, Uncertain, intervals};
use barbule::error::counted;
use barbule::progress::Progress;
use barbule::structure::Structure;

use super::{Args, Asked, Found};

/// What is asked of the numbers.
#[derive(Debug, clap::Args)]
pub(super) struct IntervalArgs {
    /// 95 % intervals of peak, width, level and colour, and how many individuals would be enough
    #[arg(long)]
    intervals: bool,
    /// What is not known exactly, with its standard deviation (repeatable; with --intervals): a medium's index, as keratin=0.005,
    /// a size by its key, as cortex_um=2%, or a layer of a stack, as layer1=5 (nm)
    #[arg(long, value_name = "NAME=STD[%]", requires = "intervals", value_parser = Uncertain::parse)]
    uncertain: Vec<Uncertain>,
}

impl IntervalArgs {
    pub(super) fn is_asked(&self) -> bool {
        self.intervals
    }
}

impl Args {
    /// The intervals of each angle, if they are asked for.
    pub(super) fn intervals(
        &self,
        typed: &str,
        found: &Found,
        individuals: &Individuals,
        asked: Asked,
        progress: &dyn Progress,
    ) -> Result<Option<Vec<Intervals>>> {
        if !self.sure.is_asked() {
            return Ok(None);
        }
        let of = |a: usize| (0..individuals.count()).map(|i| individuals.of(i, a).to_vec()).collect();
        let curves: Vec<Vec<Vec<f64>>> = (0..asked.rows.len()).map(of).collect();
        let (at, means, looks) = (&self.wavelengths, &found.spectra.mean[..], &found.looks[..]);
        let simulated = Simulated { at, means, curves: &curves, looks };
        let simulate = |moved: Structure, progress: &dyn Progress| {
            let moved = self.side.of(moved)?;
            Ok(self.spectra(typed, &moved, found.instances, asked.rows, progress)?.0.mean)
        };
        let (opening, uncertain) = (self.common.opening()?, &self.sure.uncertain);
        intervals(typed, &opening, &simulate, self.common.seed, simulated, uncertain, progress).map(Some)
    }
}

/// The intervals of an angle in words.
pub(super) fn words(found: &Intervals) -> String {
    let of = |name: &str| found.numbers.iter().find(|known| known.name == name);
    let percent = |value: f64| format!("{:.1} %", 100.0 * value);
    let nm = |value: f64| format!("{value:.0} nm");
    let part = |name: &str, word: &str, text: &dyn Fn(f64) -> String| {
        let known = of(name)?;
        let shown = contributions(known, name == "peak_nm");
        Some(format!("{word} {} to {}{shown}", text(known.low), text(known.high)))
    };
    let shown = [
        part("peak_nm", "peak", &nm),
        part("half_width_nm", "half width", &nm),
        part("peak_reflectance", "its reflectance", &percent),
        part("mean_reflectance", "mean", &percent),
    ];
    let mut parts: Vec<String> = shown.into_iter().flatten().collect();
    parts.extend(of("delta_e_2000").map(|known| format!("colour within ΔE00 {:.1}", known.high)));
    let enough: Vec<String> = [("peak_nm", "the peak to ± 2 nm"), ("delta_e_2000", "the colour to ΔE00 1")]
        .iter()
        .filter_map(|(name, what)| Some(format!("{what}: {}", of(name)?.individuals_enough?)))
        .collect();
    let mut text =
        format!("95 % (of the mean of {}): {}", counted(found.individuals, "individual"), parts.join(", "));
    if !enough.is_empty() {
        text += &format!("; individuals that fix {}", enough.join(", "));
    }
    text
}

/// What makes a number uncertain, by standard deviations.
fn contributions(known: &Known, shown: bool) -> String {
    if !shown || known.parts.is_empty() {
        return String::new();
    }
    let individuals = known.of_individuals.map(|std| format!("individuals {std:.1}"));
    let parts = known.parts.iter().map(|part| match part.std {
        Some(std) => format!("{} {std:.1}", part.name),
        None => format!("{} lost", part.name),
    });
    let all: Vec<String> = individuals.into_iter().chain(parts).collect();
    format!(" (std in nm: {})", all.join(", "))
}
