//! Birds that look, and in which light.

use barbule::open;
use barbule::spectrum::Spectrum;
use barbule::vision::{Catches, Eye, Light, Tetrahedral, View};
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

impl BirdArgs {
    /// The birds, of which each must see enough within the wavelengths.
    ///
    /// # Errors
    /// A name or file is no eye or no light, or a cone sees too much outside.
    pub(crate) fn views(&self, range_nm: (f64, f64)) -> Result<Vec<View>> {
        let view = |name: &String| {
            let view = view(open::eye(name)?, open::light(&self.illuminant)?)?;
            let what = "the reflectance";
            view.check(what, range_nm.into()).map_err(|error| error.followed_by(REACH))?;
            Ok(view)
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
    name: String,
    light: String,
    cones: Vec<String>,
    looks: Vec<(Catches, Option<Tetrahedral>)>,
}

impl Sight {
    /// Of reflectances, one for each angle.
    ///
    /// # Errors
    /// As [`View::look`].
    pub(crate) fn of(view: &View, means: &[Spectrum]) -> Result<Self> {
        Ok(Self {
            name: view.eye.name.clone(),
            light: view.light.name.clone(),
            cones: view.eye.cones.iter().map(|cone| cone.name.clone()).collect(),
            looks: means.iter().map(|mean| view.look(mean)).collect::<Result<_>>()?,
        })
    }

    /// For machines: `catches[angle][cone]`, `double[angle]`, `tetrahedral[angle]`.
    pub(crate) fn document(&self) -> Value {
        let each = || self.looks.iter();
        json!({
            "name": self.name,
            "illuminant": self.light,
            "cones": self.cones,
            "catches": each().map(|(catches, _)| &catches.cones).collect::<Vec<_>>(),
            "double": each().map(|(catches, _)| catches.double).collect::<Vec<_>>(),
            "tetrahedral": each().map(|(_, place)| place.map(tetrahedral_json)).collect::<Vec<_>>(),
        })
    }

    /// One line for people on an angle.
    pub(crate) fn words(&self, angle: usize) -> String {
        let (catches, place) = &self.looks[angle];
        format!("{} in {}: {}", self.name, self.light, words(&self.cones, catches, place.as_ref()))
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
