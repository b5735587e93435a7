//! Birds that look, and in which light.

use barbule::open;
use barbule::spectrum::Spectrum;
use barbule::vision::{Catches, Compared, Eye, Light, Tetrahedral, View};
use barbule::{Error, Result};
use clap::Args;
use serde_json::{Value, json};

/// What every bird's name says in `--help`.
pub(crate) const BIRD: &str = "Whose eye: a name as `barbule birds` lists it, or a file (.toml, .csv)";

/// What every light says in `--help`.
pub(crate) const LIGHT: &str =
    "The light that birds see in: D65, forest, sky, ideal, D50, A, E, a file of power per nm, or quanta:FILE";

/// What to add to refusals of what does not reach into the ultraviolet.
pub(crate) const REACH: &str = "; structures are simulated there by --wavelengths 300:700:4";

/// The flags of commands whose spectra birds may look at.
#[derive(Debug, Clone, Args)]
pub(crate) struct BirdArgs {
    /// What a bird sees of it: a name as `barbule birds` lists it, or a file (repeatable). Wavelengths are then 300:700:4 unless given
    #[arg(long = "bird", value_name = "NAME|FILE")]
    pub(crate) birds: Vec<String>,
    #[arg(long, value_name = "NAME|FILE", default_value = "D65", requires = "birds", help = LIGHT)]
    illuminant: String,
}

/// A bird as it was typed, and what it sees by.
pub(crate) type Viewer = (String, View);

impl BirdArgs {
    /// The birds, of which each must see enough within the wavelengths.
    ///
    /// # Errors
    /// A name or file is no eye or no light, or a cone sees too much outside.
    pub(crate) fn views(&self, range_nm: (f64, f64)) -> Result<Vec<Viewer>> {
        let view = |name: &String| {
            let view = view(open::eye(name)?, open::light(&self.illuminant)?)?;
            let what = "the reflectance";
            view.check(what, range_nm.into()).map_err(|error| error.followed_by(REACH))?;
            Ok((name.clone(), view))
        };
        self.birds.iter().map(|name| view(name).map_err(|error: Error| error.at("--bird"))).collect()
    }
}

/// An eye in a light.
///
/// # Errors
/// As [`View::new`].
pub(crate) fn view(eye: Eye, light: Light) -> Result<View> {
    View::new(eye, light).map_err(|error| error.at("--illuminant"))
}

/// What a bird sees at each of several angles.
#[derive(Debug, Clone)]
pub(crate) struct Sight {
    typed: String,
    name: String,
    light: String,
    cones: Vec<String>,
    looks: Vec<(Catches, Option<Tetrahedral>)>,
    /// Each angle's reflectance beside what was measured there, in this order; empty without measurements.
    beside: Vec<Option<Compared>>,
}

impl Sight {
    /// Of reflectances, one for each angle.
    ///
    /// # Errors
    /// As [`View::look`].
    pub(crate) fn of((typed, view): &Viewer, means: &[Spectrum]) -> Result<Self> {
        Ok(Self {
            typed: typed.clone(),
            name: view.eye.name.clone(),
            light: view.light.name.clone(),
            cones: view.eye.cones.iter().map(|cone| cone.name.clone()).collect(),
            looks: means.iter().map(|mean| view.look(mean)).collect::<Result<_>>()?,
            beside: Vec::new(),
        })
    }

    /// The same beside what was measured at each angle, where something was.
    ///
    /// # Errors
    /// A measurement does not reach where a cone sees.
    pub(crate) fn beside(
        mut self,
        (_, view): &Viewer,
        means: &[Spectrum],
        measured: &[Option<&Spectrum>],
    ) -> Result<Self> {
        let compared = |(mean, measured): (&Spectrum, &Option<&Spectrum>)| {
            let pair = measured.map(|measured| view.compare(&[mean.clone(), measured.clone()]));
            pair.transpose().map_err(|(_, error)| error.at("--measured"))
        };
        self.beside = means.iter().zip(measured).map(compared).collect::<Result<_>>()?;
        Ok(self)
    }

    /// For machines: `catches[angle][cone]`, `double[angle]`, `tetrahedral[angle]`.
    pub(crate) fn document(&self) -> Value {
        let each = || self.looks.iter();
        let mut document = json!({
            "name": self.typed,
            "title": self.name,
            "illuminant": self.light,
            "cones": self.cones,
            "catches": each().map(|(catches, _)| &catches.cones).collect::<Vec<_>>(),
            "double": each().map(|(catches, _)| catches.double).collect::<Vec<_>>(),
            "tetrahedral": each().map(|(_, place)| place.map(tetrahedral_json)).collect::<Vec<_>>(),
        });
        if !self.beside.is_empty() {
            let of = |found: &Compared| {
                json!({
                    "catches": found.catches[1].cones,
                    "delta_s": found.delta_s[0][1],
                    "delta_s_rarest": found.delta_s_rarest[0][1],
                    "delta_l": found.delta_l[0][1],
                })
            };
            document["measured"] =
                json!(self.beside.iter().map(|one| one.as_ref().map(of)).collect::<Vec<_>>());
        }
        document
    }

    /// One line for people on an angle.
    pub(crate) fn words(&self, angle: usize) -> String {
        let (catches, place) = &self.looks[angle];
        let mut text =
            format!("{} in {}: {}", self.name, self.light, words(&self.cones, catches, place.as_ref()));
        if let Some(Some(found)) = self.beside.get(angle) {
            let number = |value: Option<f64>| value.map_or_else(|| "–".into(), |value| format!("{value:.2}"));
            text += &format!(
                "; measured is ΔS {} ({} by the rarest cones) and ΔL {} away, in just noticeable differences",
                number(found.delta_s[0][1]),
                number(found.delta_s_rarest[0][1]),
                number(found.delta_l[0][1])
            );
        }
        text
    }

    /// What bars of the catches are.
    pub(crate) fn legend(&self) -> String {
        format!(
            "what the cones {} of {} catch in {}, each over white; the tallest bar is the most of them",
            self.cones.join(", "),
            self.name,
            self.light
        )
    }

    /// What the cones catch at an angle, each over white.
    pub(crate) fn catches(&self, angle: usize) -> &[f64] {
        &self.looks[angle].0.cones
    }
}

/// Catches and place in a few words.
pub(crate) fn words(cones: &[String], catches: &Catches, place: Option<&Tetrahedral>) -> String {
    let mut parts: Vec<String> =
        cones.iter().zip(&catches.cones).map(|(name, q)| format!("{name} {q:.4}")).collect();
    parts.extend(catches.double.map(|q| format!("double {q:.4}")));
    parts.extend(place.map(|place| {
        format!(
            "hue θ {:.1}°, φ {:.1}°, chroma r {:.3} ({:.0} % of the most)",
            place.theta_deg,
            place.phi_deg,
            place.r,
            100.0 * place.achieved
        )
    }));
    parts.join(", ")
}

/// A place for machines.
pub(crate) fn tetrahedral_json(place: Tetrahedral) -> Value {
    json!({
        "theta_deg": place.theta_deg, "phi_deg": place.phi_deg, "r": place.r, "r_achieved": place.achieved,
        "xyz": place.xyz, "shares": place.shares,
    })
}
