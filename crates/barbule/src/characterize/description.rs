//! What decides a campaign's numbers, as stores and materials record it.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::identity::{Hasher, Identify};
use crate::scattering::statistics::Sides;
use crate::{Error, Result};

/// Everything that decides the numbers of a campaign. Results are the same campaign's where these are equal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CampaignDescription {
    /// [`CAMPAIGN_VERSION`](super::CAMPAIGN_VERSION) of the program that computes.
    pub campaign_version: u64,
    /// [`crate::structure::Structure::description`].
    pub structure: Value,
    /// Vacuum wavelengths, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// cosθ_i, rising.
    pub cos_theta_i: Vec<f64>,
    /// cosφ_i, rising.
    pub cos_phi_i: Vec<f64>,
    /// Number of instances.
    pub instances: usize,
    /// Seed of instances and tilts.
    pub seed: u64,
    /// Largest tilt of an instance, degrees.
    pub tilt_deg: f64,
    /// Whether a material keeps both incident polarizations apart.
    pub polarized: bool,
    /// Every how many-th wavelength and direction was kept.
    pub thinned: Option<usize>,
    /// Which signs of φ_i were simulated; not recorded where φ_i ≥ 0 stands for both.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub sides: Sides,
    /// Whether each instance counts with its mirror image; recorded only where it does.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub mirror: bool,
    /// The standard deviation, µm, over which inclusions are averaged along the top; recorded only where they are.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub smooth_um: Option<f64>,
    /// Places across the barbule at which instances were lit in turn; recorded only where they are several.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub places: usize,
}

fn one() -> usize {
    1
}

fn is_one(value: &usize) -> bool {
    *value == 1
}

fn is_usual<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl CampaignDescription {
    /// Reads what a store or a material recorded.
    ///
    /// # Errors
    /// A field is missing or of another type.
    pub fn read(recorded: &Value) -> Result<Self> {
        Self::deserialize(recorded).map_err(|e| {
            Error::input(format!("records no campaign of this program ({e}); simulate it again"))
        })
    }

    /// As it is recorded.
    ///
    /// # Errors
    /// Never for numbers that are finite.
    pub fn to_json(&self) -> Result<Value> {
        serde_json::to_value(self).map_err(|e| Error::machine(format!("the campaign has no JSON form: {e}")))
    }

    /// The width of the barbules, µm, where the structure's description has it.
    #[must_use]
    pub fn width_um(&self) -> Option<f64> {
        let parameters = &self.structure["parameters"];
        parameters["width_um"].as_f64().or_else(|| self.structure["width_um"].as_f64())
    }

    /// Whether an earlier result is of this campaign.
    #[must_use]
    pub fn is_recorded(&self, recorded: &Value) -> bool {
        Self::read(recorded).is_ok_and(|there| there == *self)
    }
}

impl Identify for CampaignDescription {
    fn feed(&self, to: &mut Hasher) {
        let Self {
            campaign_version,
            structure,
            wavelengths_nm,
            cos_theta_i,
            cos_phi_i,
            instances,
            seed,
            tilt_deg,
            polarized,
            thinned,
            sides,
            mirror,
            smooth_um,
            places,
        } = self;
        to.count("campaign", *campaign_version)
            .part("structure", &Recorded(structure))
            .numbers("wavelengths_nm", wavelengths_nm)
            .numbers("cos_theta_i", cos_theta_i)
            .numbers("cos_phi_i", cos_phi_i)
            .count("instances", *instances as u64)
            .count("seed", *seed)
            .number("tilt_deg", *tilt_deg)
            .count("polarized", u64::from(*polarized))
            .count("thinned", thinned.map_or(0, |every| every as u64));
        // Only what is not as usual, so that results without these keys keep their names.
        if *sides == Sides::Both {
            to.text("sides", "both");
        }
        if *mirror {
            to.count("mirror", 1);
        }
        if let Some(deviation_um) = smooth_um {
            to.number("smooth_um", *deviation_um);
        }
        if *places > 1 {
            to.count("places", *places as u64);
        }
    }
}

/// A description as results hold it, whatever the order of its keys.
struct Recorded<'a>(&'a Value);

impl Identify for Recorded<'_> {
    fn feed(&self, to: &mut Hasher) {
        match self.0 {
            Value::Null => to.text("none", ""),
            Value::Bool(value) => to.count("truth", u64::from(*value)),
            Value::Number(number) => to.number("number", number.as_f64().unwrap_or(f64::NAN)),
            Value::String(text) => to.text("text", text),
            Value::Array(values) => to.list("values", values.iter().map(Recorded)),
            Value::Object(fields) => {
                let mut fields: Vec<(&String, &Value)> = fields.iter().collect();
                fields.sort_by_key(|(key, _)| *key);
                to.count("fields", fields.len() as u64);
                for (key, value) in fields {
                    to.part(key, &Recorded(value));
                }
                to
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterize::CampaignOptions;
    use crate::identity::hash;
    use crate::structure::{FINER_THAN_LIGHT_UM, Smoothing, Structure};

    #[test]
    fn the_order_of_recorded_keys_does_not_count_and_all_else_does() {
        let of = |text: &str| hash("recorded", &Recorded(&serde_json::from_str(text).unwrap()));
        let texts = [
            r#"{"a": 1, "b": [2, "c"]}"#,
            r#"{"a": 1, "b": [2, "d"]}"#,
            r#"{"a": 1.5, "b": [2, "c"]}"#,
            r#"{"a": 1, "c": [2, "c"]}"#,
            r#"{"a": 1, "b": [2], "c": null}"#,
            r#"{"a": true, "b": [2, "c"]}"#,
            r#"{"a": {"b": 1}}"#,
            r#"{"a": {}, "b": 1}"#,
        ];
        assert_eq!(of(texts[0]), of(r#"{"b": [2.0, "c"], "a": 1}"#));
        for (index, text) in texts.iter().enumerate() {
            assert!(!texts[..index].iter().any(|other| of(other) == of(text)), "{text}");
        }
    }

    #[test]
    fn a_campaign_is_what_it_records() {
        let of = |stack: &str, options: &CampaignOptions| {
            options.plan(Structure::flat(stack).unwrap()).unwrap().description
        };
        let (usual, more) =
            (CampaignOptions::default(), CampaignOptions { seed: 2, ..CampaignOptions::default() });
        let film = of("air/keratin:300/air", &usual);
        assert_eq!(film, of("air/keratin:300.0/air", &usual));
        assert!(film.to_json().unwrap().get("sides").is_none());
        let mut both = CampaignDescription { sides: Sides::Both, mirror: true, ..film.clone() };
        let mut recorded = both.to_json().unwrap();
        assert_eq!(CampaignDescription::read(&recorded).unwrap(), both);
        assert!(both != film && hash("campaign", &both) != hash("campaign", &film));
        both.mirror = false;
        assert_ne!(both.to_json().unwrap(), recorded);
        recorded["sides"] = "left".into();
        let refused = CampaignDescription::read(&recorded).unwrap_err().to_string();
        assert!(refused.contains("`left`, expected `alike` or `both`"), "{refused}");
        assert!(film != of("air/keratin:301/air", &usual) && film != of("air/keratin:300/air", &more));
        let shipped = barbule_birds::material("starling-green").unwrap();
        let shipped = crate::io::decode_material(shipped).unwrap();
        let shipped = CampaignDescription::read(&shipped.info["campaign"]).unwrap();
        let plan = |name: &str| usual.plan(Structure::builtin(name).unwrap()).unwrap().description;
        assert_eq!(shipped, plan("starling"));
        assert!(shipped != plan("starling:pink") && shipped != plan("bronzewing"));
    }

    #[test]
    fn averages_along_the_top_are_recorded_where_they_are() {
        let of = |smoothing: Smoothing| {
            let bird = Structure::builtin("hummingbird").unwrap().smoothed(smoothing);
            CampaignOptions::default().plan(bird).unwrap().description
        };
        let (usual, off) = (of(Smoothing::Usual), of(Smoothing::Off));
        assert_eq!((usual.smooth_um, off.smooth_um), (Some(FINER_THAN_LIGHT_UM), None));
        assert!(usual == of(Smoothing::Over(FINER_THAN_LIGHT_UM)));
        assert!(off.to_json().unwrap().get("smooth_um").is_none());
        for (one, other) in [(&usual, &off), (&usual, &of(Smoothing::Over(0.1)))] {
            assert!(one != other && hash("campaign", one) != hash("campaign", other));
            assert_eq!(one.structure, other.structure);
            assert_eq!(CampaignDescription::read(&one.to_json().unwrap()).unwrap(), *one);
        }
    }
}
