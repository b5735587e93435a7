//! `barbule spectrum --instrument`: what measuring instruments read beside a white standard, and the law that peaks follow.

use std::path::PathBuf;

use barbule::brdf::FeatherMaterial;
use barbule::campaign::spectrum::{Mount, ReadingRequest, Vane};
use barbule::error::shortened;
use barbule::instrument::Instrument;
use barbule::open;
use barbule::plot::{Drawing, Format};
use barbule::progress::Progress;
use barbule::scattering::far_field::Polarization;
use barbule::scene::description::SceneDescription;
use barbule::spectrum::angle_law::{AngleLaw, FEWEST_ANGLES};
use barbule::spectrum::look::Look;
use barbule::spectrum::peaks::Origin;
use barbule::structure::{FLAT_WIDTH_UM, Structure};
use barbule::{Error, Result, figures, reading};
use serde_json::{Value, json};

use super::{Args, Asked};
use crate::measured_args::Plane;
use crate::provenance::csv_cell;
use crate::sets;

/// Largest standard deviation of tilts, degrees: beyond, barbules hide each other.
const MOST_TILT_DEG: f64 = 30.0;

/// The flags of instruments.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct InstrumentArgs {
    /// Read by a measuring instrument, beside a perfect white standard in its place (repeatable): a bifurcated probe, two arms IN
    /// and OUT degrees from the normal on opposite sides, an integrating sphere, or a microscope; CONE is the half angle of light and
    /// detector in degrees. --angle then turns the feather away from the instrument's axis, and a material .barbule will do for
    /// STRUCTURE
    #[arg(long, value_name = "probe:CONE|arms:IN,OUT,CONE|sphere|microscope:NA", conflicts_with = "collect",
        value_parser = |text: &str| Instrument::parse(text).map_err(|error| error.at("--instrument")))]
    instrument: Vec<Instrument>,
    /// Turn the feather about its own normal under the instrument, degrees [default: 0]
    #[arg(long, value_name = "SET", allow_hyphen_values = true, requires = "instrument", value_parser = turns)]
    turn: Option<Turns>,
    /// Standard deviations of barbules in degrees, as in 5, or 8,2: of the slope of their axes out of the vane and of their turn about
    /// them [default: 0]
    #[arg(long, value_name = "DEG|SLOPE,TURN", requires = "instrument", value_parser = tilt)]
    tilt: Option<Tilt>,
    /// Barbules hide each other like the slats of a blind: PITCH from one to the next in µm and their TURN about their axes in degrees
    /// [default of a species: those of its feather]
    #[arg(long, value_name = "PITCH,TURN", num_args = 0..=1, default_missing_value = "feather", require_equals = true,
        requires = "instrument", value_parser = masked)]
    masked: Option<Masked>,
    /// Draw the followed peak against the angle with the laws that fit it, from three angles on: .svg, .pdf or .png
    #[arg(long, value_name = "FIG")]
    pub(super) law: Option<PathBuf>,
}

/// Turns about the normal, degrees.
#[derive(Debug, Clone)]
struct Turns(Vec<f64>);

/// Standard deviations of tilts, degrees.
#[derive(Debug, Clone, Copy)]
struct Tilt([f64; 2]);

/// How barbules lie in the vane.
#[derive(Debug, Clone, Copy)]
enum Masked {
    /// As in the species' feather.
    Feather,
    /// Pitch, µm, and turn, degrees.
    Slats([f64; 2]),
}

/// One curve of each structure: an instrument, and how the feather lies in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    pub(super) angle_deg: f64,
    instrument: Option<Instrument>,
    turn_deg: f64,
}

/// What is read: a structure, or with an instrument a material.
pub(super) enum Subject {
    Structure(Structure),
    Material(Box<FeatherMaterial>),
}

impl Subject {
    pub(super) fn structure(&self) -> Option<&Structure> {
        match self {
            Self::Structure(structure) => Some(structure),
            Self::Material(_) => None,
        }
    }
}

impl Args {
    /// Every curve of a structure at these angles of incidence, which are innermost.
    pub(super) fn rows(&self, angles_deg: &[f64]) -> Vec<Row> {
        let instruments: Vec<Option<Instrument>> = match &self.instrument.instrument[..] {
            [] => vec![None],
            many => many.iter().copied().map(Some).collect(),
        };
        let turns = self.instrument.turn.as_ref().map_or(&[0.0][..], |Turns(turns)| turns);
        let mut rows = Vec::new();
        for &instrument in &instruments {
            for &turn_deg in turns {
                rows.extend(angles_deg.iter().map(|&angle_deg| Row { angle_deg, instrument, turn_deg }));
            }
        }
        rows
    }

    /// Feathers under instruments, one for each row; none without instruments.
    ///
    /// # Errors
    /// `--masked` of what has no feather.
    pub(super) fn mounts(&self, subject: &str, rows: &[Row]) -> Result<Vec<Mount>> {
        let vane = self.instrument.masked.map(|masked| masked.vane(subject)).transpose()?;
        Ok(self.laid(rows, vane))
    }

    /// The same in this vane.
    pub(super) fn laid(&self, rows: &[Row], vane: Option<Vane>) -> Vec<Mount> {
        let tilt = self.instrument.tilt.map_or([0.0; 2], |Tilt(tilt)| tilt.map(f64::to_radians));
        let mount = |row: &Row| {
            Some(Mount {
                instrument: row.instrument?,
                turned: row.angle_deg.to_radians(),
                along: self.plane == Plane::Along,
                about_normal: row.turn_deg.to_radians(),
                tilt,
                vane,
            })
        };
        rows.iter().filter_map(mount).collect()
    }

    pub(super) fn reading_request(&self, mounts: Vec<Mount>, instances: usize) -> ReadingRequest {
        ReadingRequest {
            wavelengths: self.wavelengths.clone(),
            mounts,
            instances,
            seed: self.common.seed,
            polarization: self.polarization,
        }
    }

    /// A structure as it is lit or, for instruments, a material's file.
    pub(super) fn subject(&self, text: &str) -> Result<Subject> {
        if !self.instrument.instrument.is_empty()
            && let Some(found) = open::material_file(text)?
        {
            self.side.of_material(&self.common)?;
            if self.instances.is_some() {
                self.common.idle("--instances", "a material is of the individuals that it was made of");
            }
            return Ok(Subject::Material(Box::new(found.material)));
        }
        self.side.open(text, &self.common).map(Subject::Structure)
    }

    /// What instruments read of a material, `[row][wavelength]`.
    pub(super) fn of_material(
        &self,
        typed: &str,
        material: &FeatherMaterial,
        rows: &[Row],
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<f64>>> {
        let polarization = match self.polarization {
            [1.0, _] => Some(Polarization::First),
            [_, 1.0] => Some(Polarization::Second),
            _ => None,
        };
        reading::of_material(material, &self.wavelengths, &self.mounts(typed, rows)?, polarization, progress)
    }

    /// What a row is called.
    pub(super) fn row_name(&self, row: &Row) -> String {
        let angle = format!("{} = {}°", if self.plane == Plane::Across { "φ" } else { "θ" }, row.angle_deg);
        let turned = match row.turn_deg {
            0.0 => String::new(),
            turn => format!(", turned by {turn}°"),
        };
        row.instrument.map_or(angle.clone(), |instrument| format!("{instrument}, {angle}{turned}"))
    }

    /// Refuses, before any work, instruments that do not face the feather, and a law of too few rows.
    pub(super) fn check_instruments(&self, rows: &[Row]) -> Result<()> {
        self.laid(rows, None).iter().try_for_each(Mount::check)?;
        self.structures.iter().try_for_each(|text| self.mounts(text, rows).map(drop))?;
        let Some(path) = &self.instrument.law else { return Ok(()) };
        let angles = rows.len();
        if angles < FEWEST_ANGLES {
            return Err(Error::input(format!(
                "--law {}: a law needs {FEWEST_ANGLES} angles and here are {angles}; give --angle 0:60:15, or several arms",
                path.display()
            )));
        }
        one_kind(rows).map_err(|error| error.at("--law"))?;
        Format::of(path)?;
        barbule::io::check_writable(path)
    }

    /// The angles of the law that rows are at, degrees.
    pub(super) fn law_angles_deg(&self, rows: &[Row]) -> Vec<f64> {
        match &self.laid(rows, None)[..] {
            [] => rows.iter().map(|row| row.angle_deg).collect(),
            mounts => mounts.iter().map(|mount| mount.law_angle().to_degrees()).collect(),
        }
    }

    /// The law that the followed peaks of a structure obey; why there is none.
    pub(super) fn law(&self, looks: &[Look], rows: &[Row]) -> Result<AngleLaw> {
        one_kind(rows)?;
        AngleLaw::fit(&self.followed(looks, rows))
    }

    /// The law that measured peaks obey, of one order through all rows at whose angle was measured.
    pub(super) fn measured_law(&self, asked: Asked) -> Option<AngleLaw> {
        let all = self.law_angles_deg(asked.rows);
        let known = all.iter().enumerate().filter_map(|(a, angle)| Some((*angle, asked.measured_at(a)?)));
        let (angles, means): (Vec<f64>, Vec<_>) = known.map(|(angle, m)| (angle, m.mean.clone())).unzip();
        if asked.measured?.angles.len() < FEWEST_ANGLES {
            return None;
        }
        let looks =
            Look::series(&angles, &means, Origin::Measured, self.peak.within(&self.wavelengths).ok()?);
        let peaks = angles.iter().zip(&looks);
        let peaks: Vec<_> =
            peaks.filter_map(|(angle, look)| Some((angle.to_radians(), look.peak?.nm))).collect();
        AngleLaw::fit(&peaks).ok()
    }

    /// The followed peaks: the law's angle, rad, and nm.
    fn followed(&self, looks: &[Look], rows: &[Row]) -> Vec<(f64, f64)> {
        let angles = self.law_angles_deg(rows).into_iter();
        let peak = |(angle, look): (f64, &Look)| Some((angle.to_radians(), look.peak?.nm));
        angles.zip(looks).filter_map(peak).collect()
    }

    /// The figure of `--law` of structures by their names.
    pub(super) fn law_figure(&self, all: &[(String, &[Look])], rows: &[Row]) -> Result<Drawing> {
        let laws = all.iter().map(|(name, looks)| {
            let peaks = self.followed(looks, rows);
            let law = AngleLaw::fit(&peaks).map_err(|error| error.at("--law"))?;
            Ok(figures::FollowedPeaks { name: name.clone(), peaks, law })
        });
        let laws: Vec<_> = laws.collect::<Result<_>>()?;
        Ok(figures::angle_law(&figures::heading("peaks against angle"), &laws, &self.figure.page()?))
    }

    /// What JSON says of instruments, beside the curves of a structure.
    pub(super) fn describe(&self, document: &mut Value, looks: &[Look], rows: &[Row]) {
        if let Ok(law) = self.law(looks, rows) {
            document["law"] = json!(law);
            document["law_angle_deg"] = json!(self.law_angles_deg(rows));
        }
        let instruments: Vec<String> =
            rows.iter().filter_map(|row| row.instrument).map(|one| one.to_string()).collect();
        let Some(first) = instruments.first() else { return };
        let alike = instruments.iter().all(|one| one == first);
        document["instrument"] = if alike { json!(first) } else { json!(instruments) };
        document["reference"] = json!("white");
        if self.instrument.turn.is_some() {
            document["turn_deg"] = json!(rows.iter().map(|row| row.turn_deg).collect::<Vec<_>>());
        }
        if let Some(Tilt(tilt)) = self.instrument.tilt {
            document["tilt_deg"] = json!(tilt);
        }
        let typed = document["structure"].as_str().unwrap_or_default();
        let vane = self.mounts(typed, rows).ok().and_then(|mounts| mounts.first()?.vane);
        if let Some(Vane { pitch_um, width_um, turn }) = vane {
            let turn_deg = turn.to_degrees();
            document["masked"] = json!({ "pitch_um": pitch_um, "width_um": width_um, "turn_deg": turn_deg });
        }
    }
}

/// Refuses rows of several kinds of instruments: what differs between them is not the angle alone.
fn one_kind(rows: &[Row]) -> Result<()> {
    let kind = |row: &Row| row.instrument.map(|one| std::mem::discriminant(&one));
    if rows.windows(2).all(|pair| kind(&pair[0]) == kind(&pair[1])) {
        return Ok(());
    }
    Err(Error::input(
        "instruments of several kinds make no series of angles; give one of them, or several arms",
    ))
}

/// Columns in front of tables where rows differ by more than their angle: the header, and of each row its cells.
pub(super) fn front(rows: &[Row]) -> (String, Vec<String>) {
    let several = |differ: &dyn Fn(&Row) -> bool| rows.iter().any(differ);
    let instruments = several(&|row| row.instrument != rows[0].instrument);
    let turns = several(&|row| row.turn_deg != rows[0].turn_deg);
    let header = [(instruments, "instrument,"), (turns, "turn_deg,")];
    let header = header.iter().filter(|(given, _)| *given).map(|(_, name)| *name).collect();
    let cells = rows.iter().map(|row| {
        let instrument = row.instrument.filter(|_| instruments).map(|one| csv_cell(&one.to_string()) + ",");
        let turn = turns.then(|| format!("{},", row.turn_deg));
        instrument.unwrap_or_default() + &turn.unwrap_or_default()
    });
    (header, cells.collect())
}

impl Masked {
    /// The blind of a structure, material or species by its name.
    fn vane(self, subject: &str) -> Result<Vane> {
        let name = subject.split(':').next().unwrap_or_default();
        let feather = open::is_built_in(subject).then(|| SceneDescription::named(name)).transpose()?;
        let row = feather.as_ref().and_then(SceneDescription::feather).map(|feather| feather.distal);
        let width_um = row.map_or(FLAT_WIDTH_UM, |row| row.width_um);
        match (self, row) {
            (Self::Slats([pitch_um, turn_deg]), _) => {
                Ok(Vane { pitch_um, width_um, turn: turn_deg.to_radians() })
            }
            (Self::Feather, Some(row)) => {
                let across = f64::sin(0.5 * (row.base_angle + row.end_angle));
                Ok(Vane { pitch_um: row.spacing_um * across, width_um, turn: row.tilt })
            }
            (Self::Feather, None) => Err(Error::input(format!(
                "--masked: {} has no feather of its own; give --masked=PITCH,TURN, from one barbule to the next in µm and their turn in degrees, as in --masked=14,-8",
                shortened(subject)
            ))),
        }
    }
}

fn masked(text: &str) -> Result<Masked> {
    if text == "feather" {
        return Ok(Masked::Feather);
    }
    match sets::parse("--masked", text)?[..] {
        [pitch_um, turn_deg] if (0.1..=1000.0).contains(&pitch_um) && turn_deg.abs() <= 80.0 => {
            Ok(Masked::Slats([pitch_um, turn_deg]))
        }
        _ => Err(Error::input(format!(
            "--masked {}: give PITCH,TURN with 0.1 to 1000 µm and -80 to 80 degrees, as in 14,-8",
            shortened(text)
        ))),
    }
}

fn turns(text: &str) -> Result<Turns> {
    let values = sets::parse("--turn", text)?;
    match values.iter().find(|turn| turn.abs() > 360.0) {
        Some(bad) => Err(Error::input(format!("--turn: {bad}° is more than a whole turn; give -360 to 360"))),
        None => Ok(Turns(values)),
    }
}

fn tilt(text: &str) -> Result<Tilt> {
    let values = sets::parse("--tilt", text)?;
    let tilt = match values[..] {
        [both] => [both; 2],
        [slope, turn] => [slope, turn],
        _ => return Err(Error::input("--tilt: give one standard deviation in degrees, or two, as in 8,2")),
    };
    if tilt.iter().all(|one| (0.0..=MOST_TILT_DEG).contains(one)) {
        return Ok(Tilt(tilt));
    }
    Err(Error::input(format!("--tilt {text}: give standard deviations from 0 to {MOST_TILT_DEG} degrees")))
}
