//! `barbule feather`: a feather's geometry in files of other programs, or its measures beside their sources.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::error::shortened;
use barbule::io::{
    FEW_BARBULES, FeatherFormat, MOST_WRITTEN_BARBULES, WRITTEN_IDENTITY, check_writable, foretell_written,
    write_feather,
};
use barbule::progress::Progress as _;
use barbule::scene::feather::{self, Feather, Measures, VaneDisc, VaneMeasures};
use barbule::{Error, Result};
use clap::ValueEnum;
use serde_json::{Value, json};

use crate::common::{Common, LEAST_MEMORY, path_json, print, print_json};
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::scene_arg;

/// Arguments of `barbule feather`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule feather primary\n  barbule feather hummingbird -o gorget.ply")]
pub(crate) struct Args {
    /// A type (contour, primary, secondary, tail, covert, semiplume, down), a bird's feather (osprey, turkey-vulture,
    /// rock-dove-wing), a species, or a scene or species .toml
    #[arg(value_name = "TYPE|SPECIES|SCENE")]
    feather: String,
    /// Where to: .usda, .ply, .obj, .gltf, .pbrt, or .txt (curves as Mitsuba reads them); without it the measures are printed
    #[arg(short, long, value_name = "F")]
    output: Option<PathBuf>,
    /// How fine [default: barbules if there are under 200,000, else barbs]
    #[arg(long, value_name = "LEVEL")]
    level: Option<Level>,
    #[command(flatten)]
    common: Common,
}

/// What of a feather is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Level {
    /// Shaft and barbs
    Barbs,
    /// Barbules too
    Barbules,
}

/// One line of the table of measures.
struct Row {
    key: &'static str,
    what: &'static str,
    measured: f64,
    /// The parameter it was grown from, its key in files, and what its file says of its source.
    parameter: Option<(f64, &'static str, String)>,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        if let Some(path) = &self.output {
            FeatherFormat::of(path)?;
            check_writable(path)?;
        }
        let feather = self.feather()?;
        let Some(path) = &self.output else {
            if self.level.is_some() {
                self.common.idle("--level", "the measures are of the whole feather; give -o F to write it");
            }
            self.check_memory("measuring the feather", &feather, 0)?;
            let measures = feather.measures(
                self.common.seed,
                WRITTEN_IDENTITY,
                &Terminal::new(&self.common).writing_nothing(),
            )?;
            let rows = self.rows(&feather, &measures);
            return match self.common.json {
                true => print_json(out, &self.document(&measures, &rows)),
                false => self.table(out, &rows),
            };
        };
        self.write(out, &feather, path)
    }

    /// Types come first, then whatever can be rendered.
    fn feather(&self) -> Result<Feather> {
        if feather::names().any(|name| name == self.feather) {
            return Feather::of_type(&self.feather);
        }
        let scene = scene_arg::parse(&self.feather, &self.common)?;
        let none = || Error::input(format!("{}: is a scene without a feather", shortened(&self.feather)));
        scene.feather().copied().ok_or_else(none)
    }

    fn write(&self, out: &mut dyn Write, feather: &Feather, path: &Path) -> Result<()> {
        let whole = VaneDisc { along_mm: 0.0, radius_mm: None };
        let seed = self.common.seed;
        self.check_memory("laying out the feather", feather, 0)?;
        let terminal = Terminal::new(&self.common).writing_nothing();
        let barbules: usize = {
            let (_, barbs) = feather.barbs_within(whole, (seed, WRITTEN_IDENTITY), &terminal)?;
            barbs.iter().map(|barb| feather.barbule_count(barb)).sum()
        };
        let level =
            self.level.unwrap_or(if barbules <= FEW_BARBULES { Level::Barbules } else { Level::Barbs });
        if level == Level::Barbules && barbules > MOST_WRITTEN_BARBULES {
            return Err(Error::input(format!(
                "--level barbules: the feather has {barbules}, over the limit of {MOST_WRITTEN_BARBULES}; give --level barbs"
            )));
        }
        if self.level.is_none() && level == Level::Barbs {
            self.common.say(&format!(
                "barbs only: with its {barbules} barbules the file would be large (--level barbules)"
            ));
        }
        let written = if level == Level::Barbules { barbules as f64 } else { 0.0 };
        let barbs = feather.census(whole).raised;
        self.check_memory("writing the feather", feather, foretell_written(path, barbs, written)?)?;
        let grown = match level {
            Level::Barbs => feather.grow_barbs(whole, seed, WRITTEN_IDENTITY, &terminal)?,
            Level::Barbules => {
                let every = barbule::scene::feather::Level::Barbules;
                feather.grow_watched(whole, every, None, (seed, WRITTEN_IDENTITY), &terminal)?
            }
        };
        if terminal.is_cancelled() {
            return Err(Error::interrupted());
        }
        drop(terminal);
        let provenance = Provenance::new(&self.common);
        write_feather(path, &grown, &provenance.notes())?;
        let counts = grown.counts();
        let of = if level == Level::Barbules {
            format!(" and {} barbules", counts.barbules)
        } else {
            String::new()
        };
        self.common.wrote(path, &format!("a feather of {} barbs{of}, in mm", counts.barbs));
        if !self.common.json {
            return Ok(());
        }
        let level = if level == Level::Barbules { "barbules" } else { "barbs" };
        print_json(
            out,
            &json!({
                "feather": self.feather, "seed": seed, "level": level, "file": path_json(path),
                "barbs": counts.barbs, "barbules": counts.barbules,
            }),
        )
    }

    /// Refuses a feather whose barbs do not fit into memory together with `more` bytes.
    fn check_memory(&self, what: &str, feather: &Feather, more: u64) -> Result<()> {
        let barbs = feather.census(VaneDisc::WHOLE).laid_out_bytes() as u64;
        self.common.check_memory(
            what,
            LEAST_MEMORY as u64 + barbs + more,
            "a shorter feather or a greater barbs.spacing_um",
        )
    }

    fn rows(&self, feather: &Feather, measures: &Measures) -> Vec<Row> {
        let name = self.feather.split(':').next().unwrap_or_default();
        let of = |value: f64, key: &'static str| {
            let source = feather::source(name, key).unwrap_or("the file");
            Some((value, key, if source.is_empty() { "not said".to_owned() } else { source.to_owned() }))
        };
        let mut rows = vec![
            Row {
                key: "length_mm",
                what: "length of the shaft, mm",
                measured: measures.length_mm,
                parameter: of(feather.shaft.length_mm, "shaft.length_mm"),
            },
            Row {
                key: "straight_mm",
                what: "from base to tip, mm",
                measured: measures.straight_mm,
                parameter: None,
            },
            Row {
                key: "calamus_share",
                what: "quill over length",
                measured: measures.calamus_mm / measures.length_mm,
                parameter: of(feather.shaft.calamus, "shaft.calamus_share"),
            },
            Row {
                key: "calamus_width_mm",
                what: "width of the quill, mm",
                measured: measures.calamus_width_mm,
                parameter: of(2.0 * feather.shaft.radius_mm, "shaft.radius_mm"),
            },
        ];
        let shape = &feather.barbs;
        let leading = [
            of(shape.leading_half_width_mm, "barbs.leading_half_width_mm"),
            of(shape.leading_base_angle.to_degrees(), "barbs.leading_base_angle_deg"),
            of(shape.leading_tip_angle.to_degrees(), "barbs.leading_tip_angle_deg"),
            of(shape.spacing_um, "barbs.spacing_um"),
        ];
        let trailing = [
            of(shape.trailing_half_width_mm, "barbs.trailing_half_width_mm"),
            of(shape.trailing_base_angle.to_degrees(), "barbs.trailing_base_angle_deg"),
            of(shape.trailing_tip_angle.to_degrees(), "barbs.trailing_tip_angle_deg"),
            of(shape.spacing_um, "barbs.spacing_um"),
        ];
        rows.extend(vane_rows(LEADING, &measures.leading, leading));
        rows.extend(vane_rows(TRAILING, &measures.trailing, trailing));
        let count =
            |key, what, measured: usize| Row { key, what, measured: measured as f64, parameter: None };
        rows.push(count("downy_barbs", "downy barbs", measures.downy_barbs));
        rows.push(count("barbules", "barbules", measures.barbules));
        let (spacing, key) = if feather.downy.share < 1.0 {
            (feather.distal.spacing_um, "distal.spacing_um")
        } else {
            (feather.downy.spacing_um, "downy.barbule_spacing_um")
        };
        rows.push(Row {
            key: "barbules_per_mm",
            what: "barbules on a mm of barb",
            measured: measures.barbules_per_mm,
            parameter: of(2e3 / spacing, key),
        });
        if let Some(coverage) = measures.coverage {
            rows.push(Row {
                key: "coverage",
                what: "share of the vane that is closed",
                measured: coverage,
                parameter: None,
            });
        }
        rows
    }

    fn table(&self, out: &mut dyn Write, rows: &[Row]) -> Result<()> {
        let line = |what: &str, measured: &str, given: &str, source: &str| {
            format!("{what:36} {measured:>10} {given:>10}  {source}").trim_end().to_owned()
        };
        print(out, &line(&self.feather, "grown", "given", "source of what is given"))?;
        for row in rows {
            let (given, source) = match &row.parameter {
                Some((value, _, source)) => (shown(*value), source.as_str()),
                None => (String::new(), ""),
            };
            print(out, &line(row.what, &shown(row.measured), &given, source))?;
        }
        Ok(())
    }

    fn document(&self, measures: &Measures, rows: &[Row]) -> Value {
        let row = |row: &Row| {
            let mut table = json!({"key": row.key, "what": row.what, "grown": row.measured});
            if let Some((value, key, source)) = &row.parameter {
                table["given"] = (*value).into();
                table["parameter"] = format!("feather.{key}").into();
                table["source"] = source.as_str().into();
            }
            table
        };
        json!({
            "feather": self.feather,
            "seed": self.common.seed,
            "measures": measures,
            "table": rows.iter().map(row).collect::<Vec<_>>(),
        })
    }
}

/// Keys and words of a vane's rows: barbs, tuft, greatest width, mean width, angles, spacing, barbs' lengths.
type VaneWords = [(&'static str, &'static str); 8];

const LEADING: VaneWords = [
    ("leading_widest_mm", "leading vane: greatest width, mm"),
    ("leading_base_angle_deg", "  barbs' angle at the base, degrees"),
    ("leading_tip_angle_deg", "  at the tip"),
    ("leading_spacing_um", "  perpendicular spacing, µm"),
    ("leading_mean_width_mm", "  mean width, mm"),
    ("leading_barbs", "  barbs"),
    ("leading_tuft", "  barbs of the tuft"),
    ("leading_mean_barb_mm", "  mean length of a barb, mm"),
];
const TRAILING: VaneWords = [
    ("trailing_widest_mm", "trailing vane: greatest width, mm"),
    ("trailing_base_angle_deg", "  barbs' angle at the base, degrees"),
    ("trailing_tip_angle_deg", "  at the tip"),
    ("trailing_spacing_um", "  perpendicular spacing, µm"),
    ("trailing_mean_width_mm", "  mean width, mm"),
    ("trailing_barbs", "  barbs"),
    ("trailing_tuft", "  barbs of the tuft"),
    ("trailing_mean_barb_mm", "  mean length of a barb, mm"),
];

/// The rows of a vane; the first four have parameters.
fn vane_rows(
    words: VaneWords,
    vane: &VaneMeasures,
    parameters: [Option<(f64, &'static str, String)>; 4],
) -> impl Iterator<Item = Row> {
    let values = [
        vane.widest_mm,
        vane.base_angle_deg,
        vane.tip_angle_deg,
        vane.spacing_um,
        vane.mean_width_mm,
        vane.barbs as f64,
        vane.tuft as f64,
        vane.mean_barb_mm,
    ];
    let parameters = parameters.into_iter().chain([None, None, None, None]);
    words.into_iter().zip(values).zip(parameters).map(|(((key, what), measured), parameter)| Row {
        key,
        what,
        measured,
        parameter,
    })
}

/// A number with three digits or so.
fn shown(value: f64) -> String {
    match value.abs() {
        v if v >= 100.0 || value.fract() == 0.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        v if v >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
