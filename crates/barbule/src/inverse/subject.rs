//! Species and lattices with sizes to be found.

use serde_json::Value;

use super::{MOST_PARAMETERS, Parameter};
use crate::error::{did_you_mean, shortened};
use crate::fields::Kind;
use crate::structure::{GeneratorParameters, Lattice, SpeciesFile, SpeciesModel};
use crate::{Error, Result};

/// A range that nobody gave goes from and to these parts of the present value.
const USUAL_PARTS: [f64; 2] = [0.75, 1.35];
/// Where such a range holds what is no structure, its ends come nearer by this part.
const NEARER: f64 = 0.8;
const MOST_NEARER: usize = 12;
/// Lengths of lattices that can be meant, µm.
const LENGTHS_UM: [f64; 2] = [0.001, 10.0];
/// What of lattices can be found.
const LATTICE_KEYS: [&str; 5] = ["period_um", "row_pitch_um", "cortex_um", "diameter_um", "hollow_um"];

/// What is simulated, with the sizes that are not looked for.
#[derive(Debug, Clone)]
pub enum Subject {
    /// A variant of a species.
    Species {
        /// Its file, whose text fitted sizes are put into.
        file: Box<SpeciesFile>,
        /// Its model.
        model: Box<SpeciesModel>,
    },
    /// A crystal under a flat surface.
    Lattice(Box<Lattice>),
}

/// A size that is left open, as `period_um` or `period_um=0.15..0.25`.
#[derive(Debug, Clone, PartialEq)]
pub struct Open {
    /// Its key.
    pub key: String,
    /// Where it is looked for; none: about its present value.
    pub range: Option<[f64; 2]>,
}

impl Open {
    /// Reads `KEY` or `KEY=LOW..HIGH`.
    ///
    /// # Errors
    /// Neither.
    pub fn parse(text: &str) -> Result<Self> {
        let Some((key, range)) = text.split_once('=') else {
            return Ok(Self { key: text.trim().to_owned(), range: None });
        };
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        match range.split_once("..").and_then(|(low, high)| Some((number(low)?, number(high)?))) {
            Some((low, high)) if low < high => {
                Ok(Self { key: key.trim().to_owned(), range: Some([low, high]) })
            }
            _ => Err(Error::input(format!(
                "'{}' is no range of a key; write KEY or KEY=LOW..HIGH, as in cortex_um=0.2..0.5",
                shortened(text)
            ))),
        }
    }
}

impl Subject {
    /// What it is called.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Species { model, .. } => model.title(),
            Self::Lattice(_) => "lattice".into(),
        }
    }

    /// The keys that set its colour most, which are looked for unless others are named.
    fn usual(&self) -> Vec<Open> {
        let keys: &[&str] = match self {
            Self::Species { file, .. } if file.generator != "crystal" => &["cortex_um"],
            _ => &["period_um", "row_pitch_um"],
        };
        keys.iter().map(|key| Open { key: (*key).to_owned(), range: None }).collect()
    }

    /// The open sizes with their ranges.
    ///
    /// # Errors
    /// An unknown key, one that holds no length or number, a range beyond what the key may be, or sizes that make no structure.
    pub(super) fn parameters(&self, open: &[Open]) -> Result<Vec<Parameter>> {
        let usual;
        let open = if open.is_empty() {
            usual = self.usual();
            &usual
        } else {
            open
        };
        if open.len() > MOST_PARAMETERS {
            return Err(Error::input(format!(
                "{} sizes are open, over the limit of {MOST_PARAMETERS}",
                open.len()
            )));
        }
        let mut parameters: Vec<Parameter> = Vec::new();
        for one in open {
            if parameters.iter().any(|p| p.name == one.key) {
                return Err(Error::input(format!("{} is open twice", shortened(&one.key))));
            }
            parameters.push(self.parameter(one)?);
        }
        self.narrowed(open, parameters)
    }

    fn parameter(&self, open: &Open) -> Result<Parameter> {
        let (present, [least, most], unit) = self.key(&open.key)?;
        let [low, high] = match open.range {
            Some([low, high]) if low >= least && high <= most => [low, high],
            Some([low, high]) => {
                return Err(Error::input(format!(
                    "{}={low}..{high}: it may be {least} to {most}",
                    shortened(&open.key)
                )));
            }
            None if present > 0.0 => {
                [(USUAL_PARTS[0] * present).max(least), (USUAL_PARTS[1] * present).min(most)]
            }
            None => {
                return Err(Error::input(format!(
                    "{} is {present}; say where to look for it, as in {0}=LOW..HIGH",
                    shortened(&open.key)
                )));
            }
        };
        Ok(Parameter { name: open.key.clone(), unit, low, high })
    }

    /// A key's present value, what it may be, and its unit.
    fn key(&self, name: &str) -> Result<(f64, [f64; 2], String)> {
        let unknown = |known: &[&str]| {
            let near = did_you_mean(name, known.iter().copied());
            Error::input(format!(
                "{} has no size '{}'{near} (known are {})",
                self.name(),
                shortened(name),
                shortened(&known.join(", "))
            ))
        };
        match self {
            Self::Lattice(lattice) => {
                let present = lattice_size(lattice, name).ok_or_else(|| unknown(&LATTICE_KEYS))?;
                Ok((present, LENGTHS_UM, "µm".into()))
            }
            Self::Species { file, model } => {
                let keys = GeneratorParameters::keys(&file.generator)?;
                let sizes: Vec<&str> = keys
                    .iter()
                    .filter(|key| matches!(key.kind, Kind::Number { whole: false, .. }))
                    .map(|key| key.name)
                    .collect();
                let Some(key) = keys.iter().find(|key| key.name == name && sizes.contains(&key.name)) else {
                    return Err(unknown(&sizes));
                };
                let Kind::Number { low, high, .. } = key.kind else { return Err(unknown(&sizes)) };
                let present = model_value(model)?[name].as_f64().unwrap_or(0.0);
                Ok((present, [low, high], key.unit().into()))
            }
        }
    }

    /// Ranges whose corners all are structures: those that nobody gave come nearer to the present sizes until they are.
    fn narrowed(&self, open: &[Open], mut parameters: Vec<Parameter>) -> Result<Vec<Parameter>> {
        for attempt in 0.. {
            let Err(error) = self.corners(&parameters) else { break };
            if attempt == MOST_NEARER || open.iter().all(|one| one.range.is_some()) {
                return Err(error.followed_by("; give another range, KEY=LOW..HIGH"));
            }
            for (p, _) in parameters.iter_mut().zip(open).filter(|(_, one)| one.range.is_none()) {
                let (present, ..) = self.key(&p.name)?;
                p.low = present + NEARER * (p.low - present);
                p.high = present + NEARER * (p.high - present);
            }
        }
        Ok(parameters)
    }

    fn corners(&self, parameters: &[Parameter]) -> Result<()> {
        for corner in 0..1_usize << parameters.len() {
            let size = |(k, p): (usize, &Parameter)| if corner >> k & 1 == 1 { p.high } else { p.low };
            let sizes: Vec<f64> = parameters.iter().enumerate().map(size).collect();
            if let Self::Species { model, .. } = &self.with(parameters, &sizes)? {
                model.section(1, 0)?;
            }
        }
        Ok(())
    }

    /// The same with other sizes.
    ///
    /// # Errors
    /// They make no structure.
    pub fn with(&self, parameters: &[Parameter], sizes: &[f64]) -> Result<Self> {
        match self {
            Self::Species { file, model } => {
                let changes: Vec<(&str, Value)> =
                    parameters.iter().zip(sizes).map(|(p, size)| (&p.name[..], (*size).into())).collect();
                let model = Box::new(model.with_parameters(&changes)?);
                Ok(Self::Species { file: file.clone(), model })
            }
            Self::Lattice(lattice) => {
                let mut lattice = lattice.clone();
                let cortex = lattice_size(&lattice, "cortex_um").unwrap_or(0.0);
                for (p, size) in parameters.iter().zip(sizes) {
                    set_lattice_size(&mut lattice, &p.name, *size);
                }
                let open = parameters.iter().zip(sizes).find(|(p, _)| p.name == "cortex_um");
                let cortex = open.map_or(cortex, |(_, size)| *size);
                lattice.depth_to_center_um = Lattice::depth_under_cortex(cortex, &lattice.rods);
                lattice.check()?;
                Ok(Self::Lattice(lattice))
            }
        }
    }

    /// The text of a file of it: a species file, or one of a lattice alone.
    ///
    /// # Errors
    /// What the format cannot write.
    pub fn toml(&self) -> Result<String> {
        match self {
            Self::Species { file, model } => {
                let Value::Object(mut values) = model_value(model)? else {
                    return Err(Error::machine("parameters are no table"));
                };
                values.remove("generator");
                file.flat_toml_of(Some(&model.variant), &values)
            }
            Self::Lattice(lattice) => crate::io::lattice_toml(lattice),
        }
    }
}

fn model_value(model: &SpeciesModel) -> Result<Value> {
    serde_json::to_value(&model.parameters)
        .map_err(|error| Error::machine(format!("parameters cannot be written: {error}")))
}

/// A size of a lattice; those of rods are the first one's.
fn lattice_size(lattice: &Lattice, key: &str) -> Option<f64> {
    let circle = |k: usize| lattice.rods.first()?.circles.get(k).map(|circle| circle.diameter_um);
    match key {
        "period_um" => Some(lattice.period_um),
        "row_pitch_um" => Some(lattice.row_pitch_um),
        "cortex_um" => Some(lattice.depth_to_center_um - Lattice::depth_under_cortex(0.0, &lattice.rods)),
        "diameter_um" => circle(0),
        "hollow_um" => circle(1),
        _ => None,
    }
}

fn set_lattice_size(lattice: &mut Lattice, key: &str, size: f64) {
    let place = match key {
        "period_um" => Some(&mut lattice.period_um),
        "row_pitch_um" => Some(&mut lattice.row_pitch_um),
        "diameter_um" => {
            lattice.rods.first_mut().and_then(|rod| rod.circles.first_mut()).map(|c| &mut c.diameter_um)
        }
        "hollow_um" => {
            lattice.rods.first_mut().and_then(|rod| rod.circles.get_mut(1)).map(|c| &mut c.diameter_um)
        }
        // The depth follows once all rods are known.
        _ => None,
    };
    if let Some(place) = place {
        *place = size;
    }
}
