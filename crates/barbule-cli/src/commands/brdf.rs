//! `barbule brdf`: values of a material's BRDF as numbers.

mod asked;
mod output;

use std::io::Write;
use std::path::PathBuf;

use barbule::brdf::pictures::projected_grid;
use barbule::brdf::{
    FeatherBrdf, FeatherMaterial, Marginal, Options, Reciprocity, marginals, reflected_fractions, values,
};
use barbule::bsdf::Arch;
use barbule::error::shortened;
use barbule::figures;
use barbule::io::{Coordinate, LabelledArrays, Numbers, Quantity};
use barbule::progress::{OnlyStops, Progress as _};
use barbule::scattering::directions::azimuths;
use barbule::scattering::far_field::Polarization;
use barbule::{DVec3, Error, Result};
use clap::ValueEnum;
use serde_json::{Value, json};

use crate::common::{Common, print, print_json};
use crate::materials;
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs};
use asked::{
    Direction, Instances, Wavelengths, angles_of, direction, instances, place, towards, wavelengths,
};
use output::{Answer, Form, INCIDENT, INSTANCE};

/// Most values of one run as text: instances times incident directions, wavelengths, and outgoing directions or azimuths.
const MOST_VALUES: usize = 2_000_000;

/// The same as arrays alone.
const MOST_IN_ARRAYS: usize = 100_000_000;

/// Bytes of the program with a material.
const MATERIAL_BYTES: u64 = 24_000_000;

/// Bytes of a value as a number and as text, at most; and in arrays alone: three quantities, each as numbers and, one at a time, as bytes.
const VALUE_BYTES: u64 = 320;
const ARRAY_VALUE_BYTES: u64 = 32;

/// Most curves or maps in one figure.
const MOST_DRAWN: usize = 9;

/// Names of axes, and the unit of angles.
const WAVELENGTH: &str = "wavelength_nm";
const OUTGOING: &str = "wo";
const AZIMUTH: &str = "phi_out_deg";
const DEGREE: &str = "degree";

/// Where examples and the meaning of angles are.
const AFTER: &str = "\
Angles are degrees: THETA is the longitude towards the barbule's base and tip, PHI the azimuth across it, each between -90 \
and 90, and the direction is (cosθ sinφ, sinθ, cosθ cosφ) with x across, y along, z out of the barbule. At THETA,PHI = 0,30 \
the mirror direction is 0,-30.

Examples:
  barbule brdf starling --wavelength 520 --wi 0,30 --wo 0,-30 --wo 0,-20
  barbule brdf starling --wavelength 450,550,650 --wi 0,0 --wo-grid 64 --instance 3 --csv grid.csv
  barbule brdf starling --wavelength 520 --wi 0,60 --wo 0,-20 --reciprocity steeper
  barbule brdf rock-dove --wavelength 520 --wi 0,30 --wo 0,10 --place 0.9
  barbule brdf starling --wavelength 520 --wi 0,30 --instance 0:59:1 --wo-grid 9 -o g.zarr
  barbule brdf starling --wavelength 400:694:6 --wi 0,30 --marginal --json";

/// Arguments of `barbule brdf`.
#[derive(Debug, clap::Args)]
#[command(after_help = AFTER)]
#[command(group = clap::ArgGroup::new("incoming").required(true).args(["wi", "wi_grid"]))]
#[command(group = clap::ArgGroup::new("outgoing").required(true).args(["wo", "wo_grid", "marginal"]))]
pub(crate) struct Args {
    /// A material file, or SPECIES[:VARIANT]
    material: String,
    /// Vacuum wavelengths in nm, within the material's
    #[arg(long, alias = "wavelengths", value_name = "SET", value_parser = wavelengths)]
    wavelength: Wavelengths,
    /// Direction towards the light (repeatable)
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true,
        value_parser = |text: &str| direction("--wi", text))]
    wi: Vec<Direction>,
    /// Towards the light: the centres of N × N cells over the hemisphere seen from above, where they lie inside it
    #[arg(long, value_name = "N")]
    wi_grid: Option<usize>,
    /// Direction towards the eye (repeatable)
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true,
        value_parser = |text: &str| direction("--wo", text))]
    wo: Vec<Direction>,
    /// Towards the eye: the centres of N × N cells over the hemisphere seen from above, where they lie inside it
    #[arg(long, value_name = "N")]
    wo_grid: Option<usize>,
    /// In place of values their integral over the outgoing θ at each azimuth: what far fields call intensity
    #[arg(long)]
    marginal: bool,
    /// Outgoing azimuths of --marginal, at (n+½)·180°/N − 90° [default: 400]
    #[arg(long, value_name = "N")]
    azimuths: Option<usize>,
    /// Which instance, from 0 to 2⁶⁴ − 1, or a set of them, as in 0:59:1; without it the smooth mean
    #[arg(long, value_name = "K", allow_hyphen_values = true, value_parser = instances)]
    instance: Option<Instances>,
    /// What one place across the barbule gives of it, from -1 to 1 as x goes: where its section is an arch, each place mirrors its own
    /// pairs of directions [default: the whole barbule]
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = place)]
    place: Option<f64>,
    /// Incident polarization: of the electric field along e₁ (1) or e₂ (2), or unpolarized light
    #[arg(long, value_enum, default_value_t = Light::Mean)]
    polarization: Light,
    /// What makes values the same when light and eye change places: none, as fitted; steeper, as in pictures, the tables of whichever
    /// direction has the smaller |PHI|; mean, of both orders
    #[arg(long, value_name = "none|steeper|mean", default_value = Reciprocity::AsFitted.word(),
        value_parser = |text: &str| Reciprocity::named("--reciprocity", text))]
    reciprocity: Reciprocity,
    /// Draw --marginal as curves or --wo-grid as maps (.svg, .pdf or .png), or write all values: .csv, .npy or .zarr
    #[arg(short, long, value_name = "F")]
    output: Option<PathBuf>,
    /// Write a table, one row per wavelength and direction
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Incident polarizations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Light {
    /// Unpolarized
    Mean,
    /// Polarization 1
    #[value(name = "1")]
    First,
    /// Polarization 2
    #[value(name = "2")]
    Second,
}

impl Light {
    fn polarization(self) -> Option<Polarization> {
        match self {
            Self::Mean => None,
            Self::First => Some(Polarization::First),
            Self::Second => Some(Polarization::Second),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::First => "1",
            Self::Second => "2",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Mean => "unpolarized",
            Self::First => "polarization 1",
            Self::Second => "polarization 2",
        }
    }
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let form = self.output.as_deref().map(Form::of);
        self.check(form)?;
        let figure = self.output.as_deref().filter(|_| form == Some(Form::Figure));
        check_outputs(figure, self.csv.as_deref())?;
        if let (Some(path), Some(form)) = (&self.output, form) {
            form.check(path)?;
        }
        let (material, hash) = materials::find(&self.material, &self.common)?;
        self.check_range(material.axes.wavelengths_nm())?;
        let (polarization, reciprocity) = (self.polarization.polarization(), self.reciprocity);
        let options = Options { polarization, reciprocity, ..Options::default() };
        // Only what decides the values is prepared.
        let brdf = FeatherBrdf::new(&material.around(&self.wavelength.0)?, options)?;
        let incoming = self.incoming();
        let on_arch = self.on_arch(&material)?;
        let title = self.title(&figures::title(&material), &incoming);
        let answer = if self.marginal {
            self.marginal(&brdf, &title, &incoming)?
        } else {
            self.values(&brdf, on_arch, &title, &incoming)?
        };
        self.say_flagged(&answer, &incoming);
        let provenance =
            Provenance::new(&self.common).with("material", &self.material).with("material_hash", &hash);
        let columns = || answer.columns().iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        if let (Some(path), Some(form)) = (&self.output, form) {
            answer.write(form, path, &provenance)?;
            let what = match form {
                Form::Figure if self.marginal => "marginals".to_owned(),
                Form::Figure => "f".to_owned(),
                Form::Npy => answer.arrays.quantities[0].name.to_owned(),
                Form::Table | Form::Zarr => columns(),
            };
            self.common.wrote(path, &format!("{what} of {title}"));
        }
        if let Some(path) = &self.csv {
            provenance.write_csv(path, &answer.csv())?;
            self.common.wrote(path, &format!("{} of {title}", columns()));
        }
        if self.common.json {
            let mut document = json!({
                "material": self.material,
                "material_hash": hash,
                "instance": null,
                "place": self.place,
                "polarization": self.polarization.name(),
                "reciprocity": brdf.reciprocity().word(),
                "sigma": brdf.sigma(),
                "halo_sigma": brdf.halo_sigmas(),
            });
            if let Value::Object(keys) = &mut document {
                keys.extend(answer.json());
            }
            return print_json(out, &document);
        }
        if self.output.is_none() && self.csv.is_none() {
            return print(out, &format!("{title}\n{}", answer.aligned()));
        }
        Ok(())
    }

    /// What can be refused before any work.
    fn check(&self, form: Option<Form>) -> Result<()> {
        let refuse = |message: String| Err(Error::input(message));
        for (flag, size) in [("--wo-grid", self.wo_grid), ("--wi-grid", self.wi_grid)] {
            if let Some(size) = size.filter(|size| !(1..=1000).contains(size)) {
                return refuse(format!("{flag} {size}: give a number from 1 to 1000"));
            }
        }
        if self.azimuths.is_some() && !self.marginal {
            return refuse("--azimuths is of --marginal only; give --marginal, or leave it out".into());
        }
        if let Some(count) = self.azimuths.filter(|count| !(2..=100_000).contains(count)) {
            return refuse(format!("--azimuths {count}: give a number from 2 to 100000"));
        }
        if self.marginal && self.reciprocity != Reciprocity::AsFitted {
            return refuse("--marginal is of the lobes as they were fitted; leave --reciprocity out".into());
        }
        if self.marginal && self.place.is_some() {
            return refuse("--marginal is of the whole barbule; leave --place out".into());
        }
        self.check_count(form)?;
        if form == Some(Form::Figure) {
            if !self.wo.is_empty() {
                return refuse("-o draws --marginal or --wo-grid, and writes .csv, .npy and .zarr; single directions have no figure".into());
            }
            if self.wi.len() != 1 || self.names().len() != 1 {
                return refuse(
                    "-o draws one --wi and one --instance; give one each, or a .csv, .npy or .zarr".into(),
                );
            }
            let waves = self.wavelength.0.len();
            if waves > MOST_DRAWN {
                return refuse(format!("-o draws at most {MOST_DRAWN} wavelengths, not {waves}; give fewer"));
            }
        }
        Ok(())
    }

    /// The arch and the place asked for; none of whole barbules and of flat ones, all of whose places reflect the same.
    fn on_arch(&self, material: &FeatherMaterial) -> Result<Option<(Arch, f64)>> {
        let Some(x) = self.place else { return Ok(None) };
        let arch = materials::barbules(material, &self.common).and_then(|barbules| barbules.arch());
        let arch = arch.map_err(|e| e.at("--place"))?;
        match arch {
            None => self.common.say("these barbules are flat: all places across them reflect the same"),
            Some(arch) => self.common.explain(&format!(
                "normals lean from {:.1}° at x = -1 to {:.1}° at x = 1",
                arch.low.to_degrees(),
                arch.high.to_degrees()
            )),
        }
        Ok(arch.map(|arch| (arch, x)))
    }

    /// Refuses more values than can be written or held.
    fn check_count(&self, form: Option<Form>) -> Result<()> {
        let waves = self.wavelength.0.len();
        let incident = self.wi.len() + self.wi_grid.map_or(0, |size| size * size);
        let each = self.wo.len() + self.wo_grid.map_or(0, |size| size * size) + self.azimuth_count();
        let names = self.names().len();
        let count = names.saturating_mul(incident).saturating_mul(waves).saturating_mul(each);
        let is_text = self.common.json || self.csv.is_some() || !matches!(form, Some(Form::Npy | Form::Zarr));
        let most = if is_text { MOST_VALUES } else { MOST_IN_ARRAYS };
        if count > most {
            let arrays = if is_text { ", or -o F.npy or F.zarr alone" } else { "" };
            let sets = match (names, incident) {
                (1, 1) => String::new(),
                _ => format!("{names} instances times {incident} incident directions times "),
            };
            return Err(Error::input(format!(
                "{sets}{waves} wavelengths times {each} directions are over {most} values; give fewer{arrays}"
            )));
        }
        let each_bytes = if is_text { VALUE_BYTES } else { ARRAY_VALUE_BYTES };
        self.common.check_memory("this table", MATERIAL_BYTES + each_bytes * count as u64, "fewer values")
    }

    /// The instances asked for; `None` is the mean.
    fn names(&self) -> Vec<Option<u64>> {
        match &self.instance {
            None => vec![None],
            Some(Instances(names)) => names.iter().map(|name| Some(*name)).collect(),
        }
    }

    /// Towards the light: as typed, or over the hemisphere.
    fn incoming(&self) -> Vec<(Direction, DVec3)> {
        match self.wi_grid {
            None => self.wi.iter().map(|wi| (*wi, towards(*wi))).collect(),
            Some(size) => projected_grid(size).into_iter().map(|w| (angles_of(&w), w)).collect(),
        }
    }

    fn azimuth_count(&self) -> usize {
        if self.marginal { self.azimuths.unwrap_or(400) } else { 0 }
    }

    fn check_range(&self, nodes_nm: &[f64]) -> Result<()> {
        let (first, last) = (nodes_nm[0], nodes_nm[nodes_nm.len() - 1]);
        match self.wavelength.0.iter().find(|nm| !(first..=last).contains(*nm)) {
            Some(bad) => Err(Error::input(format!(
                "--wavelength: {bad} nm is outside {first} to {last} nm, the wavelengths of {}",
                shortened(&self.material)
            ))),
            None => Ok(()),
        }
    }

    fn title(&self, material: &str, incoming: &[(Direction, DVec3)]) -> String {
        let which = match self.names()[..] {
            [None] => "mean".to_owned(),
            [Some(name)] => format!("instance {name}"),
            ref names => format!("{} instances", names.len()),
        };
        let from = match incoming {
            [([theta, phi], _)] => format!("θ_i {theta}°, φ_i {phi}°"),
            several => format!("{} incident directions", several.len()),
        };
        let order = match self.reciprocity {
            Reciprocity::AsFitted => "",
            Reciprocity::Steeper => ", by the steeper direction",
            Reciprocity::Mean => ", mean of both orders",
        };
        let place = self.place.map(|x| format!(", place {x}")).unwrap_or_default();
        format!("{material}, {which}, {}, {from}{place}{order}", self.polarization.words())
    }

    /// The axes that both kinds of values share, with the outgoing one.
    fn labelled(
        &self,
        incoming: &[(Direction, DVec3)],
        outgoing: (&'static str, usize),
        along: Vec<Coordinate>,
        quantities: Vec<Quantity>,
    ) -> LabelledArrays {
        let nm = &self.wavelength.0;
        let mut arrays = LabelledArrays { quantities, ..LabelledArrays::default() };
        let floats = |name, axis, units, meaning, values| Coordinate {
            name,
            axis,
            units,
            meaning,
            values: Numbers::Floats(values),
        };
        if let Some(Instances(names)) = &self.instance {
            arrays.axes.push((INSTANCE, names.len()));
            let (values, meaning) = (Numbers::Counts(names.clone()), "which barbule");
            arrays.coordinates.push(Coordinate {
                name: INSTANCE,
                axis: INSTANCE,
                units: "",
                meaning,
                values,
            });
        }
        arrays.axes.extend([(INCIDENT, incoming.len()), (WAVELENGTH, nm.len()), outgoing]);
        let angles = |k: usize| incoming.iter().map(|(angles, _)| angles[k]).collect();
        let (along_it, across) =
            ("inclination along the barbule towards the light", "azimuth across it towards the light");
        arrays.coordinates.push(floats(WAVELENGTH, WAVELENGTH, "nm", "vacuum wavelength", nm.clone()));
        arrays.coordinates.push(floats("theta_in_deg", INCIDENT, DEGREE, along_it, angles(0)));
        arrays.coordinates.push(floats("phi_in_deg", INCIDENT, DEGREE, across, angles(1)));
        arrays.coordinates.extend(along);
        arrays
    }

    fn values(
        &self,
        brdf: &FeatherBrdf,
        on_arch: Option<(Arch, f64)>,
        title: &str,
        incoming: &[(Direction, DVec3)],
    ) -> Result<Answer> {
        let nm = &self.wavelength.0;
        let grid = self.wo_grid.map(projected_grid);
        let asked = || self.wo.iter().map(|wo| towards(*wo)).collect();
        let wo: Vec<DVec3> = grid.clone().unwrap_or_else(asked);
        // As typed where they were typed.
        let angles: Vec<Direction> =
            if grid.is_some() { wo.iter().map(angles_of).collect() } else { self.wo.clone() };
        let quantity = |name, meaning| Quantity { name, units: "1/sr", meaning, values: Vec::new() };
        let mut quantities = vec![
            quantity("f", "BRDF, without the cosine"),
            quantity("s", "its steady part, the same in all instances"),
            quantity("pdf", "density with which the outgoing direction is drawn"),
        ];
        let names = self.names();
        let progress = Terminal::new(&self.common);
        progress.begin("values", (names.len() * incoming.len()) as u64);
        for name in names {
            for (_, wi) in incoming {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                for row in values(brdf, nm, *wi, &wo, name) {
                    for (value, wo) in row.into_iter().zip(&wo) {
                        let share = on_arch.map_or(1.0, |(arch, x)| arch.share(x, *wo, *wi));
                        let numbers = [share * value.f, share * value.steady, value.pdf];
                        quantities.iter_mut().zip(numbers).for_each(|(to, number)| to.values.push(number));
                    }
                }
                progress.advance(1);
            }
        }
        drop(progress);
        let along = |name, units, meaning, of: &dyn Fn(usize) -> f64| {
            let values = Numbers::Floats((0..wo.len()).map(of).collect());
            Coordinate { name, axis: OUTGOING, units, meaning, values }
        };
        let mut coordinates = vec![
            along("theta_out_deg", DEGREE, "inclination along the barbule towards the eye", &|k| {
                angles[k][0]
            }),
            along("phi_out_deg", DEGREE, "azimuth across it towards the eye", &|k| angles[k][1]),
        ];
        if grid.is_some() {
            coordinates.push(along("x_out", "", "x of the direction towards the eye", &|k| wo[k].x));
            coordinates.push(along("y_out", "", "y of the direction towards the eye", &|k| wo[k].y));
        }
        let drawing = self.wo_grid.filter(|_| self.draws()).map(|size| {
            let f: Vec<Vec<f64>> = quantities[0].values.chunks(wo.len()).map(<[f64]>::to_vec).collect();
            figures::hemisphere_maps(title, size, nm, &f)
        });
        let arrays = self.labelled(incoming, (OUTGOING, wo.len()), coordinates, quantities);
        Ok(Answer { arrays, reflected: None, grid: self.wo_grid, drawing })
    }

    /// Whether `-o` is a figure.
    fn draws(&self) -> bool {
        self.output.as_deref().is_some_and(|path| Form::of(path) == Form::Figure)
    }

    fn marginal(&self, brdf: &FeatherBrdf, title: &str, incoming: &[(Direction, DVec3)]) -> Result<Answer> {
        let nm = &self.wavelength.0;
        let phi_out: Vec<f64> = azimuths(self.azimuth_count()).collect();
        let quantity = |name, meaning| Quantity { name, units: "1/rad", meaning, values: Vec::new() };
        let mut quantities = vec![
            quantity(
                "marginal",
                "integral of f cos(phi_out) cos(theta_out)^2 over theta_out, over cos(theta_in)",
            ),
            quantity("marginal_s", "the same of the steady part"),
        ];
        let mut reflected = Vec::new();
        let names = self.names();
        let progress = Terminal::new(&self.common);
        progress.begin("marginals", (names.len() * incoming.len()) as u64);
        for name in names {
            for (_, wi) in incoming {
                let stops = OnlyStops(&progress);
                for Marginal { f, steady } in marginals(brdf, nm, *wi, &phi_out, name, &stops)? {
                    quantities[0].values.extend(f);
                    quantities[1].values.extend(steady);
                }
                reflected.extend(reflected_fractions(brdf, nm, *wi, name, &stops)?);
                progress.advance(1);
            }
        }
        drop(progress);
        let phi_out_deg: Vec<f64> = phi_out.iter().map(|phi| phi.to_degrees()).collect();
        let drawing = self.draws().then(|| {
            let f: Vec<Vec<f64>> = quantities[0].values.chunks(phi_out.len()).map(<[f64]>::to_vec).collect();
            figures::marginals(title, nm, &phi_out_deg, &f)
        });
        let coordinate = Coordinate {
            name: AZIMUTH,
            axis: AZIMUTH,
            units: DEGREE,
            meaning: "azimuth across the barbule towards the eye",
            values: Numbers::Floats(phi_out_deg),
        };
        let arrays = self.labelled(incoming, (AZIMUTH, phi_out.len()), vec![coordinate], quantities);
        Ok(Answer { arrays, reflected: Some(reflected), grid: None, drawing })
    }

    /// Says which instances give back more than falls in.
    fn say_flagged(&self, answer: &Answer, incoming: &[(Direction, DVec3)]) {
        let flagged = answer.flagged();
        let reflected = answer.reflected.as_deref().unwrap_or_default();
        let worst =
            (0..flagged.len()).filter(|k| flagged[*k]).max_by(|a, b| reflected[*a].total_cmp(&reflected[*b]));
        let Some(worst) = worst else { return };
        let nm = &self.wavelength.0;
        let ([theta, phi], _) = incoming[worst / nm.len() % incoming.len()];
        let which = match self.names()[worst / nm.len() / incoming.len()] {
            None => "the mean".to_owned(),
            Some(name) => format!("instance {name}"),
        };
        let count = flagged.iter().filter(|flagged| **flagged).count();
        self.common.say(&format!(
            "{which} gives back {:.2} of the light from θ_i {theta}°, φ_i {phi}° at {} nm: single instances may where light grazes, their mean does not ({count} of {} are flagged)",
            reflected[worst],
            nm[worst % nm.len()],
            flagged.len()
        ));
    }
}
