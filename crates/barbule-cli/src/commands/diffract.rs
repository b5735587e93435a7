//! `barbule diffract`: what a heightfield does with light, directly and by tables.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use barbule::diffraction::{Reference, delta_e, direction};
use barbule::figures::{DIRECTIONS, Pattern, diffraction, diffraction_spectrum};
use barbule::io::measured::{Measured, read_measured};
use barbule::io::{GratingFile, check_writable, write_grating};
use barbule::plot::{Band, MeasuredBand};
use barbule::scattering::grating::{
    Basis, Coherence, Normalization, Obliquity, Place, Powers, Setup, TableGrid, Tables,
};
use barbule::solve::diffraction::{
    Amplitudes, Builder, Reach, Series, TablesNeed, check_patch, foretell_seconds, spectrum,
};
use barbule::spectrum::colour::Observer;
use barbule::spectrum::comparison::Comparison;
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::structure::Heightfield;
use barbule::{DVec3, Error, Result};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::common::{Common, LEAST_MEMORY, duration, path_json, print, print_json};
use crate::figure::FigureArgs;
use crate::heights_arg::HeightsArgs;
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::sets;

/// Bytes of a figure while it is drawn.
const DRAWING_BYTES: u64 = 24_000_000;

/// Index of surfaces: chitin and keratin, about.
const USUAL_INDEX: f64 = 1.5;

/// Work that takes longer is announced.
const SOON_SECONDS: f64 = 20.0;

/// Frequencies up to 2/λ: heights farther apart than a quarter of the shortest wavelength do not tell all directions.
const COARSE: f64 = 0.25;

/// Arguments of `barbule diffract`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  barbule diffract blazed -o blazed.png
  barbule diffract xenopeltis -o xenopeltis.grating
  barbule diffract blazed --wi 0,0 --wo 11.54,0 --json")]
pub(crate) struct Args {
    #[command(flatten)]
    heights: HeightsArgs,
    /// Where light comes from: polar angle from the normal and azimuth from +x towards +y, degrees
    #[arg(long, value_name = "POLAR,AZIMUTH", value_parser = over_surface, allow_hyphen_values = true)]
    wi: Option<Direction>,
    /// Where it goes to, likewise
    #[arg(long, value_name = "POLAR,AZIMUTH", value_parser = over_surface, requires = "wi", allow_hyphen_values = true)]
    wo: Option<Direction>,
    /// Wavelengths in nm that colours are summed over: where orders are high, steps of 5 nm leave bands
    #[arg(long, visible_alias = "wavelength", value_name = "SET", default_value = "380:780:5",
        value_parser = sets::wavelength_set)]
    wavelengths: Wavelengths,
    /// Taylor's series of this order in place of Chebyshev's: 2N + 1 tables
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=63))]
    orders: Option<u16>,
    /// What f is: a BRDF, or relative to a mirror's peak at each wavelength
    #[arg(long, value_enum, default_value_t = Normalized::Energy)]
    normalization: Normalized,
    /// Standard deviation of the window of coherence in µm (65 µm are four of the usual), or 'sun'
    #[arg(long, value_name = "UM|sun", default_value = "16.25", value_parser = coherence)]
    coherence: Coherence,
    /// Where the window stands on the patch in µm, or 'anywhere' for the mean over all places
    #[arg(long, value_name = "X,Y|anywhere", default_value = "0,0", value_parser = place, allow_hyphen_values = true)]
    place: Place,
    /// How directions are weighed
    #[arg(long, value_enum, default_value_t = Weighed::Kirchhoff)]
    obliquity: Weighed,
    /// Refractive index of the surface [default: 1.5]
    #[arg(long, value_name = "N")]
    index: Option<f64>,
    /// Side of the tables, odd
    #[arg(long, value_name = "N", default_value_t = TableGrid::USUAL.size)]
    size: usize,
    /// Exponent e of the tables' steps u = 2 t^e
    #[arg(long, value_name = "E", default_value_t = TableGrid::USUAL.exponent)]
    exponent: f64,
    /// A measured reflectance to compare with at --wi and --wo, as for spectra
    #[arg(long, value_name = "FILE", requires = "wo")]
    measured: Option<PathBuf>,
    /// The column of --measured to use, by name or by number from 1 [default: all samples and their mean]
    #[arg(long, value_name = "NAME|N", requires = "measured")]
    column: Option<String>,
    /// Half angle of what the detector of --measured sees, degrees
    #[arg(long, value_name = "DEG", default_value_t = 2.0, requires = "measured")]
    aperture: f64,
    #[command(flatten)]
    figure: FigureArgs,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Normalized {
    /// ∫ f cosθ_o dω_o of a flat surface is its reflectance
    Energy,
    /// 1 at the mirror direction of a flat surface at normal incidence, at every wavelength
    Relative,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Weighed {
    /// Kirchhoff's integral, reciprocal
    Kirchhoff,
    /// Generalized Harvey–Shack, made reciprocal
    Reciprocal,
    /// Generalized Harvey–Shack
    HarveyShack,
    /// No weight
    Radiance,
}

/// Polar angle and azimuth in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Direction([f64; 2]);

impl Direction {
    fn vector(self) -> DVec3 {
        direction(self.0[0], self.0[1])
    }
}

fn two(text: &str) -> Option<[f64; 2]> {
    let (first, second) = text.split_once(',')?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    Some([number(first)?, number(second)?])
}

fn over_surface(text: &str) -> std::result::Result<Direction, String> {
    two(text)
        .filter(|[polar, azimuth]| (-89.9..=89.9).contains(polar) && azimuth.abs() <= 360.0)
        .map(Direction)
        .ok_or_else(|| {
            "write POLAR,AZIMUTH in degrees, as in 30,180: at most 89.9 from the normal, 360 around it".into()
        })
}

fn coherence(text: &str) -> std::result::Result<Coherence, String> {
    if text.eq_ignore_ascii_case("sun") {
        return Ok(Coherence::SUN);
    }
    let number = text.parse::<f64>().ok().filter(|value| value.is_finite());
    number.map(Coherence::Fixed).ok_or_else(|| "write µm, as in 16.25, or 'sun'".into())
}

fn place(text: &str) -> std::result::Result<Place, String> {
    if text.eq_ignore_ascii_case("anywhere") {
        return Ok(Place::Anywhere);
    }
    two(text).map(Place::At).ok_or_else(|| "write X,Y in µm, as in 10,25, or 'anywhere'".into())
}

/// Colours of one pair of directions.
struct Found {
    values: Vec<f64>,
    reference: [f64; 3],
    tables: [f64; 3],
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let stored = self.figure.path().filter(|path| is_grating(path));
        match stored {
            Some(path) => check_writable(path)?,
            None => self.figure.check_rigid(&self.common)?,
        }
        if self.wi.is_some() && self.wo.is_none() && (stored.is_some() || self.figure.output.is_none()) {
            return Err(Error::input("--wi alone lights the pictures of -o FIG; give --wo too, or -o FIG"));
        }
        if self.figure.output.is_none() && self.wo.is_none() {
            return Err(self.nothing_to_do());
        }
        if !(0.0..=30.0).contains(&self.aperture) {
            return Err(Error::input(format!("--aperture {}: give 0 to 30 degrees", self.aperture)));
        }
        let setup = self.setup()?;
        self.grid().check()?;
        let (field, name) = self.heights.read(&self.common)?;
        let at = self.wavelengths.clone();
        self.say_if_coarse(&field, &at);
        check_patch(field.size_um(), &setup, &at)?;
        self.check_memory(&field, &setup, &at)?;
        let tables = stored.map(|path| self.store(path, &field, &name, &setup, &at)).transpose()?;
        if let (Some(wi), Some(wo)) = (self.wi, self.wo) {
            return self.values(&field, &name, &setup, &at, [wi, wo], out);
        }
        let document = match (tables, self.figure.path()) {
            (Some(tables), _) => tables,
            (None, Some(path)) => self.draw(path, &field, &name, &setup, &at)?,
            (None, None) => return Err(self.nothing_to_do()),
        };
        if self.common.json { print_json(out, &document) } else { Ok(()) }
    }

    /// What is to be given, and at once what the file of heights lacks.
    fn nothing_to_do(&self) -> Error {
        const GIVE: &str =
            "give -o FIG for pictures, -o NAME.grating for tables, or --wi and --wo for values";
        match self.heights.open(self.common.seed) {
            Err(lack) if lack.is_input() => lack.followed_by(&format!("; and {GIVE}")),
            _ => Error::input(format!("nothing to do: {GIVE}")),
        }
    }

    fn setup(&self) -> Result<Setup> {
        let setup = Setup {
            obliquity: match self.obliquity {
                Weighed::Kirchhoff => Obliquity::Kirchhoff,
                Weighed::Reciprocal => Obliquity::Reciprocal,
                Weighed::HarveyShack => Obliquity::HarveyShack,
                Weighed::Radiance => Obliquity::Radiance,
            },
            coherence: self.coherence,
            place: self.place,
            normalization: match self.normalization {
                Normalized::Energy => Normalization::Energy,
                Normalized::Relative => Normalization::Relative,
            },
            index: self.index.unwrap_or(USUAL_INDEX),
        };
        setup.check()?;
        if self.index.is_some() && setup.normalization == Normalization::Relative {
            self.common.idle("--index", "values are relative to a mirror of the same index");
        }
        Ok(setup)
    }

    fn grid(&self) -> TableGrid {
        TableGrid { size: self.size, exponent: self.exponent }
    }

    fn series(&self) -> Series {
        self.orders.map_or(Series::Chebyshev, |orders| Series::Taylor(usize::from(orders)))
    }

    fn builder(&self, field: &Heightfield, setup: &Setup, at: &Wavelengths) -> Result<Builder> {
        let progress = Terminal::new(&self.common);
        Builder::new(field, setup, self.grid(), self.series(), &Observer::default(), at, &progress)
    }

    /// Refuses, before any work, what does not fit into memory.
    fn check_memory(&self, field: &Heightfield, setup: &Setup, at: &Wavelengths) -> Result<()> {
        let TablesNeed { making, kept, tables, powers, seconds } =
            Builder::need(field, setup, self.grid(), self.series(), at);
        // The reference has a series of its own.
        let reference = Amplitudes::bytes(field, Reach::of(setup, at), Series::Chebyshev);
        let values = making.max(kept + if self.measured.is_some() { reference } else { 0 });
        let made = making.max(kept + 2 * tables).max(tables + reference);
        // A file is encoded part by part, then as a whole.
        let stored = made.max(tables + reference.max(2 * powers)).max(3 * (tables + powers));
        let path = self.figure.path();
        let work = [
            self.wo.map(|_| values),
            path.filter(|path| !is_grating(path) && self.wo.is_none()).map(|_| made + DRAWING_BYTES),
            path.filter(|path| is_grating(path)).map(|_| stored),
        ];
        let work = work.into_iter().flatten().max().unwrap_or_default();
        let what = format!("diffraction by {} × {} heights", field.cells()[0], field.cells()[1]);
        let heights = size_of_val(field.height_um()) as u64;
        let sums = if self.wo.is_some() { foretell_seconds(field, setup, at) } else { 0.0 };
        let seconds = (seconds + sums) / rayon::current_num_threads() as f64;
        self.common.check_memory(&what, LEAST_MEMORY as u64 + heights + work, "a smaller patch or --size")?;
        if seconds > SOON_SECONDS {
            self.common.say(&format!("{what}: about {}", duration(seconds)));
        }
        Ok(())
    }

    /// Says that heights are too far apart for all directions at the shortest wavelength.
    fn say_if_coarse(&self, field: &Heightfield, at: &Wavelengths) {
        let shortest_um = at.range_nm().0 * 1e-3;
        let pitch = field.cells().into_iter().zip(field.pitch_um()).filter(|(count, _)| *count > 1);
        let widest = pitch.map(|(_, pitch)| pitch).fold(0.0, f64::max);
        if widest > COARSE * shortest_um {
            self.common.say(&format!(
                "heights every {widest:.3} µm tell nothing of directions whose sines differ from the mirror's by more than {:.2} at {} nm; there f is 0",
                shortest_um / (2.0 * widest),
                at.range_nm().0
            ));
        }
    }

    /// Writes tables and powers; gives what is told of them to machines.
    fn store(
        &self,
        path: &Path,
        field: &Heightfield,
        name: &str,
        setup: &Setup,
        at: &Wavelengths,
    ) -> Result<Value> {
        let tables = self.builder(field, setup, at)?.tables(&Terminal::new(&self.common))?;
        let powers = self.powers(field, setup, at)?;
        let provenance = Provenance::new(&self.common).json();
        let shown = words(&tables, &powers);
        let document = json!({
            "heights": name,
            "file": path_json(path),
            "tables": tables.basis().count(),
            "orders": powers.orders().counts(),
        });
        write_grating(path, &GratingFile { name: name.into(), tables, powers, provenance })?;
        self.common.wrote(path, &format!("{name}, {shown}"));
        Ok(document)
    }

    fn powers(&self, field: &Heightfield, setup: &Setup, at: &Wavelengths) -> Result<Powers> {
        let progress = Terminal::new(&self.common);
        let anywhere = Setup { place: Place::Anywhere, ..*setup };
        Amplitudes::new(field, &anywhere, Reach::of(setup, at), Series::Chebyshev, &progress)?.powers()
    }

    /// Draws the pictures; gives what is told of them to machines.
    fn draw(
        &self,
        path: &Path,
        field: &Heightfield,
        name: &str,
        setup: &Setup,
        at: &Wavelengths,
    ) -> Result<Value> {
        let page = self.figure.page()?;
        let progress = Terminal::new(&self.common);
        let tables = self.builder(field, setup, at)?.tables(&progress)?;
        let reference = Reference::new(field, setup, &Observer::default(), at, &progress)?;
        let w_i = self.wi.map_or(DVec3::Z, Direction::vector);
        if let Some(time) = time_of_pattern(|w_o| reference.xyz(w_i, w_o)) {
            self.common.say(&format!("the pattern of {DIRECTIONS} directions takes about {time}"));
        }
        let title = self.figure.title(format!("{name}: diffraction under D65"));
        let pattern = Pattern { field, reference: &reference, tables: &tables, w_i };
        let (drawing, errors) = diffraction(&title, &pattern, &page, &progress);
        Provenance::new(&self.common).write_figure(path, &drawing)?;
        self.common.wrote(
            path,
            &format!(
                "heights, pattern, colours; {} tables within {:.1e} of the peak, ΔE00 {:.2} in the mean",
                tables.basis().count(),
                errors.largest_of_peak,
                errors.mean_delta_e
            ),
        );
        Ok(json!({
            "heights": name,
            "file": path_json(path),
            "tables": tables.basis().count(),
            "largest_of_peak": errors.largest_of_peak,
            "mean_delta_e": errors.mean_delta_e,
        }))
    }

    /// Values between two directions.
    fn values(
        &self,
        field: &Heightfield,
        name: &str,
        setup: &Setup,
        at: &Wavelengths,
        [wi, wo]: [Direction; 2],
        out: &mut dyn Write,
    ) -> Result<()> {
        let (w_i, w_o) = (wi.vector(), wo.vector());
        let measured = self
            .measured
            .as_ref()
            .map(|path| read_measured(path, self.column.as_deref(), None))
            .transpose()?;
        if let Some(measured) = &measured {
            self.common.say(&measured.reading);
        }
        let values = spectrum(field, setup, at, w_i, w_o, &Terminal::new(&self.common))?;
        let reference = Observer::default().weights(at).xyz(&values);
        let builder = self.builder(field, setup, at)?;
        let found = Found { tables: builder.xyz(w_i, w_o), values, reference };
        let factor = measured
            .as_ref()
            .map(|_| {
                let progress = Terminal::new(&self.common);
                let reference = Reference::new(field, setup, &Observer::default(), at, &progress)?;
                let factor = reference.reflectance_factor(w_i, w_o, self.aperture.to_radians());
                Spectrum::new(at.clone(), factor)
            })
            .transpose()?;
        let comparison = factor
            .as_ref()
            .zip(measured.as_ref())
            .map(|(factor, measured)| Comparison::of(factor, &measured.mean, None))
            .transpose()?;
        if let Some(path) = self.figure.path().filter(|path| !is_grating(path)) {
            self.draw_spectrum(path, name, &found, factor.as_ref(), measured.as_ref(), [wi, wo], at)?;
        }
        if self.common.json {
            let mut document = json!({
                "heights": name,
                "wi_deg": wi.0,
                "wo_deg": wo.0,
                "wavelength_nm": at.nm(),
                "spectrum": found.values,
                "xyz": {"tables": found.tables, "reference": found.reference},
                "delta_e": delta_e(found.reference, found.tables),
                "tables": builder.basis().count(),
            });
            if let (Some(factor), Some(comparison)) = (&factor, &comparison) {
                document["reflectance_factor"] = json!(factor.values());
                document["comparison"] = json!(comparison);
            }
            return print_json(out, &document);
        }
        let xyz = |xyz: [f64; 3]| format!("{:.6} {:.6} {:.6}", xyz[0], xyz[1], xyz[2]);
        let mut lines = vec![
            format!("{name}: from polar {}°, azimuth {}° to {}°, {}°", wi.0[0], wi.0[1], wo.0[0], wo.0[1]),
            format!("XYZ of f under D65, reference: {}", xyz(found.reference)),
            format!("                       tables: {}", xyz(found.tables)),
            format!("ΔE00: {:.3}", delta_e(found.reference, found.tables)),
        ];
        if let Some(comparison) = &comparison {
            lines.push(format!(
                "measured: RMSE {:.4}, {} with the scale that fits best",
                comparison.rmse,
                comparison.rmse_scaled.map_or_else(|| "none".into(), |rmse| format!("{rmse:.4}"))
            ));
        }
        print(out, &lines.join("\n"))
    }

    fn draw_spectrum(
        &self,
        path: &Path,
        name: &str,
        found: &Found,
        factor: Option<&Spectrum>,
        measured: Option<&Measured>,
        [wi, wo]: [Direction; 2],
        at: &Wavelengths,
    ) -> Result<()> {
        let title = self
            .figure
            .title(format!("{name}: from {}°, azimuth {}° to {}°, {}°", wi.0[0], wi.0[1], wo.0[0], wo.0[1]));
        let plain = Spectrum::new(at.clone(), found.values.clone())?;
        let (shown, quantity) = match (factor, self.normalization) {
            (Some(factor), _) => (factor, "reflectance of a perfect diffuser's"),
            (None, Normalized::Energy) => (&plain, "f (1/sr)"),
            (None, Normalized::Relative) => (&plain, "f of a mirror's peak"),
        };
        let band = measured.map(|measured| MeasuredBand {
            band: Band {
                name: "measured".into(),
                mean: measured.mean.clone(),
                std: measured.std.clone(),
                peak: None,
            },
            samples: Vec::new(),
            beside: None,
        });
        let drawing = diffraction_spectrum(&title, shown, quantity, band.as_ref(), &self.figure.page()?);
        Provenance::new(&self.common).write_figure(path, &drawing)?;
        self.common.wrote(path, "the spectrum between the two directions");
        Ok(())
    }
}

/// How long a pattern takes, where that is long: by the time of a few directions that lie all over the hemisphere.
fn time_of_pattern(colour: impl Fn(DVec3) -> [f64; 3] + Sync) -> Option<String> {
    /// Enough for every thread.
    const FEW: usize = 256;
    const LONG_S: f64 = 5.0;
    let begun = Instant::now();
    let some = (0..FEW).into_par_iter().map(|i| {
        let share = (i as f64 + 0.5) / FEW as f64;
        colour(direction(share.sqrt().asin().to_degrees(), 137.5 * i as f64))
    });
    let all: Vec<[f64; 3]> = some.collect();
    let seconds = begun.elapsed().as_secs_f64() * DIRECTIONS as f64 / all.len() as f64;
    (seconds > LONG_S).then(|| duration(seconds))
}

/// Tables and powers in words.
fn words(tables: &Tables, powers: &Powers) -> String {
    let kind = match tables.basis() {
        Basis::Taylor { orders } => format!("of Taylor's order {orders}"),
        Basis::Chebyshev { .. } => "of Chebyshev polynomials".into(),
    };
    let [columns, rows] = powers.orders().counts();
    format!(
        "{} tables {kind} of {size} × {size} places, {columns} × {rows} orders",
        tables.basis().count(),
        size = tables.grid().size
    )
}

fn is_grating(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("grating"))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn only_patterns_that_take_long_are_foretold() {
        assert_eq!(time_of_pattern(|_| [0.0; 3]), None);
        let slow = time_of_pattern(|w_o| {
            assert!((w_o.length() - 1.0).abs() < 1e-12 && w_o.z > 0.0);
            std::thread::sleep(Duration::from_millis(4));
            [0.0; 3]
        });
        // On one thread 188 s; on many as much less.
        assert!(slow.is_some_and(|time| time.ends_with(" s") || time.ends_with(" min")));
    }
}
