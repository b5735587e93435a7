//! Layers of any media in any number under a flat, arched or folded top.
//!
//! Every layer lies under the one before by its own thickness along the normal, so layers never cross, whatever the parameters.

mod build;
#[cfg(test)]
mod tests;

use serde::Serialize;

use super::super::curve::point_count;
use super::super::section::{MOST_POINTS, Parts};
use super::generator::{Generator, Random};
use crate::error::{did_you_mean, shortened};
use crate::fields::{Fed, FieldValue, Fields, Key, Kind, Map, Record, Text, Usual, Value, path_of, within};
use crate::identity::{Hasher, Identify};
use crate::material::Library;
use crate::{Error, Result, record};

/// Layers of one stack, repetitions written out.
const MOST_LAYERS: usize = 2000;
/// No stack of layers is thicker.
const THICKEST_UM: f64 = 100.0;
/// No spread of thicknesses is larger, as a part.
const LARGEST_SPREAD: f64 = 0.5;
/// What the key `core_spread` is, for people.
const CORE_SPREAD: &str = "Standard deviation of the core's own thickness between individuals, as a part; unless given, barbules are equally thick and the core takes up what layers differ by.";
/// An arch is no higher than this part of its width: its ends slope by 70°.
const HIGHEST_ARCH: f64 = 0.35;

/// What is on the lower side of a barbule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LowerSide {
    /// Nothing: the core goes on.
    None,
    /// The cortex.
    Plain,
    /// The same layers in reverse, with random thicknesses of their own.
    Mirrored,
}

impl LowerSide {
    const NAMES: [(&'static str, Self); 3] =
        [("none", Self::None), ("plain", Self::Plain), ("mirrored", Self::Mirrored)];

    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, side)| *side == self).map_or("", |(name, _)| name)
    }
}

/// One layer of a multilayer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MultilayerLayer {
    /// Its medium: a name, a mixture or an index.
    pub medium: String,
    /// Its mean thickness.
    pub thickness_um: f64,
    /// Standard deviation between individuals, a part of the thickness.
    pub spread: f64,
    /// Standard deviation between this layer's repetitions in one individual, a part of the thickness.
    pub spread_within: f64,
    /// The thickness varies along the barbule by ± this part of itself.
    pub waviness: f64,
}

impl MultilayerLayer {
    fn keys() -> Vec<Key> {
        let part =
            |name, about: &'static str| Key::new::<Option<f64>>(name, &[], about, &within(0, 0.5), None);
        vec![
            Key::new::<String>(
                "medium",
                &[],
                "What it is made of.",
                &Text("a medium, a mixture or an index"),
                None,
            ),
            Key::new::<f64>("thickness_um", &[], "Its mean thickness.", &within(0.001, 10), None),
            part("spread", "Standard deviation of its thickness between individuals, as a part."),
            part("spread_within", "The same between repetitions in an individual."),
            part("waviness", "Its thickness varies along the barbule by ± this part."),
        ]
    }
}

impl Identify for MultilayerLayer {
    fn feed(&self, to: &mut Hasher) {
        let Self { medium, thickness_um, spread, spread_within, waviness } = self;
        to.text("medium", medium)
            .number("thickness_um", *thickness_um)
            .number("spread", *spread)
            .number("spread_within", *spread_within)
            .number("waviness", *waviness);
    }
}

record! {
    /// The numbers of the multilayer generator.
    #[derive(Debug, Clone, PartialEq, serde::Serialize)]
    pub struct MultilayerSizes {
        /// Width of the barbule.
        width_um: f64 = "width_um", within(1, 200);
        /// Thickness of the cortex above the layers; 0: none.
        cortex_um: f64 = "cortex_um", within(0, 10), or 0.0;
        /// How often the layers follow each other.
        repeats: usize = "repeats", within(1, 2000), or 1;
        /// Mean thickness of the core, where there is a lower side.
        core_um: f64 = "core_um", within(0.01, 100), or 1.0;
        /// Standard deviation of thicknesses between individuals, as a part, for the cortex and layers that give none.
        spread: f64 = "spread", within(0, 0.5), or 0.0;
        /// Standard deviation of thicknesses between repetitions in an individual, as a part, for layers that give none.
        spread_within: f64 = "spread_within", within(0, 0.5), or 0.0;
        /// Thicknesses vary along the barbule by ± this part, for the cortex and layers that give none.
        waviness: f64 = "waviness", within(0, 0.5), or 0.0;
        /// Correlation length of the waviness.
        waviness_correlation_um: f64 = "waviness_correlation_um", within(0.05, 100), or 2.0;
        /// The boundary under each layer is rough by ± this.
        layer_roughness_um: f64 = "layer_roughness_um", within(0, 1), or 0.0;
        /// Correlation length of these boundaries' roughness.
        layer_roughness_correlation_um: f64 = "layer_roughness_correlation_um", within(0.05, 100), or 0.5;
        /// The top's and the bottom's roughness spans ± this.
        roughness_amplitude_um: f64 = "roughness_amplitude_um", within(0, 10), or 0.0;
        /// Correlation length of the top's and the bottom's roughness.
        roughness_correlation_um: f64 = "roughness_correlation_um", within(0.05, 100), or 1.5;
        /// Height of an arch's middle over its ends; negative: a trough.
        sagitta_um: f64 = "sagitta_um", within(-70, 70), or 0.0;
        /// Slope of the two arms of a folded barbule; positive: a ridge, negative: a groove.
        fold_deg: f64 = "fold_deg", within(-60, 60), or 0.0;
        /// Radius that rounds the fold.
        fold_radius_um: f64 = "fold_radius_um", within(0, 200), or 1.0;
        /// Width of a level part between the arms.
        fold_flat_um: f64 = "fold_flat_um", within(0, 200), or 0.0;
        /// Only over this width, about the middle, are there layers; beyond they are their own mean.
        layered_width_um: f64 = "layered_width_um", within(0.5, 200), or 200.0;
        /// Distance of points along the shapes.
        point_spacing_um: f64 = "point_spacing_um", within(0.005, 1), or 0.03;
    }
}

/// Parameters of the multilayer generator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Multilayer {
    /// The layers from the top down, repeated.
    pub layers: Vec<MultilayerLayer>,
    /// The medium around the barbule.
    pub outside: String,
    /// The cortex' medium.
    pub cortex_medium: String,
    /// The medium under the layers.
    pub core: String,
    /// What is on the lower side.
    pub lower: LowerSide,
    /// Standard deviation of the core's own thickness between individuals, a part of it. None: the barbule is equally thick in
    /// all individuals, and the core takes up what their layers differ by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub core_spread: Option<f64>,
    /// The numbers.
    #[serde(flatten)]
    pub sizes: MultilayerSizes,
}

impl Record for Multilayer {
    fn keys() -> Vec<Key> {
        let about = "The layers from the top down, each { medium, thickness_um } and, where its own, spread, spread_within, waviness.";
        let layer = Kind::Table(MultilayerLayer::keys());
        let layers = Kind::List { of: Box::new(layer), least: 1, most: MOST_LAYERS };
        let text = |name, about: &'static str, usual: &str| {
            Key::new::<String>(
                name,
                &[],
                about,
                &Text("a medium, a mixture or an index"),
                Some(usual.to_owned()),
            )
        };
        let lower = Kind::Word(LowerSide::NAMES.map(|(name, _)| name).to_vec());
        let usual = Usual::Value(LowerSide::Plain.name().into());
        let mut keys = vec![
            Key { name: "layers", aliases: &[], about, kind: layers, usual: Usual::Needed },
            text("outside", "The medium around the barbule.", "air"),
            text("cortex_medium", "The medium of the cortex.", "keratin"),
            text("core", "The medium under the layers.", "keratin"),
            Key { name: "lower", aliases: &[], about: "What is on the lower side.", kind: lower, usual },
            Key::new::<Option<f64>>("core_spread", &[], CORE_SPREAD, &within(0, LARGEST_SPREAD), None),
        ];
        keys.extend(MultilayerSizes::keys());
        keys
    }

    fn read_fields(fields: &Fields<'_>) -> Result<Self> {
        let text = |key: &str, usual: &str| Ok::<_, Error>(fields.text(key)?.unwrap_or(usual).to_owned());
        let sizes = MultilayerSizes::read_fields(fields)?;
        Ok(Self {
            layers: layers(fields, [sizes.spread, sizes.spread_within, sizes.waviness])?,
            outside: text("outside", "air")?,
            cortex_medium: text("cortex_medium", "keratin")?,
            core: text("core", "keratin")?,
            lower: lower_side(fields)?,
            core_spread: core_spread(fields)?,
            sizes,
        })
    }

    fn check_given(fields: &Fields<'_>) -> Result<()> {
        MultilayerSizes::check_given(fields)?;
        if fields.get("layers").is_some() {
            layers(fields, [0.0; 3])?;
        }
        for key in ["outside", "cortex_medium", "core"] {
            fields.text(key)?;
        }
        lower_side(fields)?;
        core_spread(fields).map(drop)
    }

    fn write_into(&self, table: &mut Map<String, Value>) {
        if let Ok(Value::Object(own)) = serde_json::to_value(self) {
            table.extend(own);
        }
    }

    fn check(&self, place: &str) -> Result<()> {
        self.core_spread.check_value(&path_of(place, "core_spread"), &within(0, LARGEST_SPREAD))?;
        Record::check(&self.sizes, place)
    }

    fn feed_fields(&self, to: &mut Hasher) {
        let Self { layers, outside, cortex_medium, core, lower, core_spread, sizes } = self;
        to.list("layers", layers)
            .text("outside", outside)
            .text("cortex_medium", cortex_medium)
            .text("core", core)
            .text("lower", lower.name())
            .part("sizes", &Fed(sizes));
        // Only where it is given, so that what was made before there was this key keeps its name.
        if let Some(core_spread) = core_spread {
            to.number("core_spread", *core_spread);
        }
    }
}

impl Multilayer {
    /// The number of the core among the media of a section that has a lower side; none of a section without.
    #[must_use]
    pub fn core_region(&self) -> Option<usize> {
        let cortex = usize::from(self.sizes.cortex_um > 0.0);
        (self.lower != LowerSide::None).then(|| 1 + cortex + self.layers.len() * self.sizes.repeats)
    }

    fn check_shape(&self) -> Result<()> {
        let refuse = |message: String| Err(Error::input(message));
        let width = self.sizes.width_um;
        if self.sizes.sagitta_um.abs() > HIGHEST_ARCH * width {
            return refuse(format!(
                "parameters.sagitta_um is {}, but an arch is at most {HIGHEST_ARCH} of its width high; make it {} or less",
                self.sizes.sagitta_um,
                HIGHEST_ARCH * width
            ));
        }
        let round = 2.0 * self.sizes.fold_radius_um * libm::sin(self.sizes.fold_deg.abs().to_radians());
        if self.sizes.fold_deg != 0.0 && round + self.sizes.fold_flat_um > width {
            return refuse(format!(
                "parameters.fold_radius_um is {} and fold_flat_um {}, which makes the fold {:.3} µm wide, wider than the barbule (width_um = {width}); make them smaller",
                self.sizes.fold_radius_um,
                self.sizes.fold_flat_um,
                round + self.sizes.fold_flat_um
            ));
        }
        if self.sizes.layered_width_um < width && self.two_media().is_none() {
            return refuse(format!(
                "parameters.layered_width_um is {}, under width_um, which needs layers of two different media; leave it out",
                self.sizes.layered_width_um
            ));
        }
        Ok(())
    }

    fn check_size(&self) -> Result<()> {
        let refuse = |message: String| Err(Error::input(message));
        let layers = self.layers.len().saturating_mul(self.sizes.repeats);
        if layers > MOST_LAYERS {
            return refuse(format!(
                "parameters.repeats is {}, which makes {layers} layers, over the limit of {MOST_LAYERS}",
                self.sizes.repeats
            ));
        }
        let group: f64 = self.layers.iter().map(|layer| layer.thickness_um).sum();
        let deep = self.sizes.cortex_um + self.sizes.repeats as f64 * group;
        if deep > THICKEST_UM {
            return refuse(format!(
                "parameters.layers are {deep:.3} µm thick in all, over the limit of {THICKEST_UM} µm; thicknesses are in µm: make them or repeats smaller"
            ));
        }
        let sides = if self.lower == LowerSide::Mirrored { 2 } else { 1 };
        let points = (sides * layers + 4) * point_count(self.sizes.width_um, self.sizes.point_spacing_um);
        if points > MOST_POINTS {
            return refuse(format!(
                "parameters.point_spacing_um is {}, which makes {points} points, over the limit of {MOST_POINTS}; make it larger, or repeats smaller",
                self.sizes.point_spacing_um
            ));
        }
        let thinnest = self.layers.iter().map(|layer| layer.thickness_um).fold(f64::INFINITY, f64::min);
        if self.sizes.layer_roughness_um >= 0.5 * thinnest {
            return refuse(format!(
                "parameters.layer_roughness_um is {}, so that the boundaries of a layer of {thinnest} µm meet; make it under half of that, {}",
                self.sizes.layer_roughness_um,
                0.5 * thinnest
            ));
        }
        Ok(())
    }
}

impl Generator for Multilayer {
    fn width_um(&self) -> f64 {
        self.sizes.width_um
    }

    fn check(&self) -> Result<()> {
        self.check_shape()?;
        self.check_size()
    }

    fn parts(&self, random: &Random, _library: &Library) -> Parts {
        self.build(random)
    }

    fn is_curved(&self) -> bool {
        crate::structure::arch::is_arch(&self.shape())
    }

    fn media(&self) -> Vec<(String, &str)> {
        let key = |key: &str| format!("parameters.{key}");
        let mut media = vec![(key("outside"), self.outside.as_str())];
        if self.sizes.cortex_um > 0.0 {
            media.push((key("cortex_medium"), &self.cortex_medium));
        }
        let layers = self.layers.iter().enumerate();
        media.extend(layers.map(|(i, layer)| (key(&format!("layers[{i}].medium")), layer.medium.as_str())));
        media.push((key("core"), &self.core));
        media
    }
}

/// Spread, spread within and waviness of a layer, as given or else as usual.
fn spreads(fields: &Fields<'_>, usual: [f64; 3]) -> Result<[f64; 3]> {
    let part = |key: &str, usual: f64| {
        if fields.get(key).is_some() { fields.number_within(key, 0.0, 0.5) } else { Ok(usual) }
    };
    Ok([part("spread", usual[0])?, part("spread_within", usual[1])?, part("waviness", usual[2])?])
}

fn core_spread(fields: &Fields<'_>) -> Result<Option<f64>> {
    let given = fields.get("core_spread").is_some();
    given.then(|| fields.number_within("core_spread", 0.0, LARGEST_SPREAD)).transpose()
}

fn layers(fields: &Fields<'_>, usual: [f64; 3]) -> Result<Vec<MultilayerLayer>> {
    const EXAMPLE: &str =
        "[{ medium = \"melanin\", thickness_um = 0.1 }, { medium = \"keratin\", thickness_um = 0.1 }]";
    let path = fields.path("layers");
    let list = fields.list("layers", &format!("the layers from the top down, as in {EXAMPLE}"))?;
    if !(1..=MOST_LAYERS).contains(&list.len()) {
        return Err(Error::input(format!(
            "{path} has {} layers, but 1 to {MOST_LAYERS} are allowed",
            list.len()
        )));
    }
    let keys = MultilayerLayer::keys();
    let known: Vec<&str> = keys.iter().map(|key| key.name).collect();
    let layer = |(index, value): (usize, &Value)| {
        let fields = Fields::new(value, &format!("{path}[{index}]"), &known)?;
        let medium = fields.text("medium")?.ok_or_else(|| {
            Error::input(format!("{} is missing; give a medium, as in \"melanin\"", fields.path("medium")))
        })?;
        let [spread, spread_within, waviness] = spreads(&fields, usual)?;
        Ok(MultilayerLayer {
            medium: medium.to_owned(),
            thickness_um: fields.number_within("thickness_um", 0.001, 10.0)?,
            spread,
            spread_within,
            waviness,
        })
    };
    list.iter().enumerate().map(layer).collect()
}

fn lower_side(fields: &Fields<'_>) -> Result<LowerSide> {
    let Some(text) = fields.text("lower")? else { return Ok(LowerSide::Plain) };
    LowerSide::NAMES.iter().find(|(name, _)| *name == text).map(|(_, side)| *side).ok_or_else(|| {
        let names = LowerSide::NAMES.map(|(name, _)| name);
        Error::input(format!(
            "{} is '{}'{}; write {}",
            fields.path("lower"),
            shortened(text),
            did_you_mean(text, names),
            names.join(", ")
        ))
    })
}
