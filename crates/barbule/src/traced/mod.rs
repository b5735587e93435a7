//! From what a micrograph shows to measures in nm and to files that simulate.

#[cfg(feature = "figures")]
mod figure;
mod files;

use serde_json::{Value, json};

use crate::error::counted;
use crate::material::Library;
use crate::trace::{Bar, Grey, Kind, Options, Spread, Traced, scale_bar, trace};
use crate::{Error, Result};

/// What a micrograph is, beside its pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Micrograph {
    /// How long a pixel is.
    pub nm_per_px: f64,
    /// Media of the classes of grey, from the brightest: two or three names; else air, keratin and melanin, without air where
    /// the picture has two classes.
    pub media: Option<Vec<String>>,
    /// Grey levels 0 to 255 of the flattened picture between the classes, from the brighter; else found.
    pub thresholds: Option<Vec<f64>>,
    /// What to trace it as; else decided by what is there.
    pub kind: Option<Kind>,
    /// Keratin above the first row of a lattice where the picture does not show it, nm.
    pub cortex_nm: Option<f64>,
    /// What the section is called.
    pub name: String,
}

impl Micrograph {
    /// A picture of such pixels of which everything else is found.
    #[must_use]
    pub fn of_pixels(nm_per_px: f64) -> Self {
        Self { nm_per_px, media: None, thresholds: None, kind: None, cortex_nm: None, name: "traced".into() }
    }
}

/// A micrograph that was traced, in nm.
#[derive(Debug, Clone)]
pub struct TracedImage {
    /// What was found, in px.
    pub traced: Traced,
    /// How long a pixel is.
    pub nm_per_px: f64,
    /// Media of the classes, from the brightest.
    pub media: Vec<String>,
    /// Keratin above the first row of a lattice, nm.
    pub cortex_nm: f64,
    /// Whether the picture shows it.
    pub shows_cortex: bool,
    /// What one should know about the result, a sentence each.
    pub notes: Vec<String>,
    name: String,
    library: Library,
}

/// Lengths of a pixel that can be meant, nm.
const PIXELS_NM: std::ops::RangeInclusive<f64> = 1e-3..=1e4;

/// Traces a micrograph; names of media are those of `library`.
///
/// # Errors
/// A length of a pixel outside 0.001 to 10,000 nm, unknown media, or as [`trace`].
pub fn trace_image(picture: &Grey, given: &Micrograph, library: &Library) -> Result<TracedImage> {
    if !PIXELS_NM.contains(&given.nm_per_px) {
        return Err(Error::input(format!(
            "`nm_per_px`: a pixel would be {} nm long; give 0.001 to 10000 nm",
            given.nm_per_px
        ))
        .naming(&["nm_per_px"]));
    }
    if let Some(cortex) = given.cortex_nm.filter(|nm| !(0.0..=50_000.0).contains(nm)) {
        return Err(
            Error::input(format!("`cortex_nm` is {cortex} nm; give 0 to 50000 nm")).naming(&["cortex_nm"])
        );
    }
    for name in given.media.iter().flatten() {
        library.get(name).map_err(|error| error.at("`classes`").naming(&["classes"]))?;
    }
    let options = Options {
        classes: given.media.as_ref().map(Vec::len),
        thresholds: given.thresholds.clone(),
        kind: given.kind,
    };
    let traced = trace(picture, &options)?;
    let media = given.media.clone().unwrap_or_else(|| usual_media(traced.levels.len()));
    let shown = traced.cortex.map(|cortex| cortex.mean * given.nm_per_px);
    let mut found = TracedImage {
        nm_per_px: given.nm_per_px,
        media,
        cortex_nm: given.cortex_nm.or(shown).unwrap_or(0.0),
        shows_cortex: shown.is_some(),
        notes: Vec::new(),
        name: given.name.clone(),
        library: library.clone(),
        traced,
    };
    found.notes = notes(&found, given);
    Ok(found)
}

/// Finds the scale bar of a picture, which is `nm` long: the bar, the picture without the rows in which it and its words lie, and the length of
/// a pixel, nm.
///
/// # Errors
/// There is no such bar, or nothing is left beside it.
pub fn scaled_by_bar(picture: &Grey, nm: f64) -> Result<(Bar, Grey, f64)> {
    let bar = scale_bar(picture).ok_or_else(|| {
        Error::input(
            "has no scale bar that is found: a level bar of the picture's black or white near its upper or lower border, at least four times as long as high; measure it and give its pixels, as in `100nm=85px`",
        )
        .naming(&["nm_per_px"])
    })?;
    let [from, to] = bar.free;
    let free = picture.part([0, from, picture.size()[0], to.saturating_sub(from)])?;
    Ok((bar, free, nm / bar.length))
}

fn usual_media(classes: usize) -> Vec<String> {
    ["air", "keratin", "melanin"][3 - classes.clamp(2, 3)..].iter().map(|name| (*name).to_owned()).collect()
}

/// What was decided or left out.
fn notes(found: &TracedImage, given: &Micrograph) -> Vec<String> {
    let traced = &found.traced;
    let mut notes = Vec::new();
    let decided = if given.media.is_none() && given.thresholds.is_none() { "found" } else { "given" };
    notes.push(format!(
        "greys {decided}, from bright to dark: {}; thresholds {}",
        found.media.join(", "),
        traced.thresholds.iter().map(|t| format!("{t:.0}")).collect::<Vec<_>>().join(" and ")
    ));
    let what = match traced.kind {
        Kind::Lattice => format!("a lattice of {}", counted(traced.rods.len(), "rod")),
        Kind::Layers => {
            format!("{} between the first and the last region", counted(traced.layers.len(), "layer"))
        }
        Kind::Section => format!("a section with {} inside", counted(traced.inclusions.len(), "region")),
    };
    let decided = if given.kind.is_some() { "traced as" } else { "taken for" };
    notes.push(format!("{decided} {what}; edges are blurred by {:.1} px", traced.blur));
    if traced.kind != Kind::Layers && traced.cut > 0 {
        notes.push(format!("{} cut by the border left out", counted(traced.cut, "region")));
    }
    if traced.rods.iter().any(|rod| rod.is_parted) && traced.kind == Kind::Lattice {
        let parted = traced.rods.iter().filter(|rod| rod.is_parted).count();
        notes.push(format!(
            "{} that touch others were parted, by circles through what is free of their outlines",
            counted(parted, "rod")
        ));
    }
    if traced.kind == Kind::Lattice && !found.shows_cortex && given.cortex_nm.is_none() {
        notes.push("the picture shows no surface above the rods: the file has no cortex, so that the first row touches the surface; give `cortex_nm` if you know it".into());
    }
    if traced.kind == Kind::Lattice
        && let (Some(cortex), Some(given)) = (traced.cortex, given.cortex_nm)
    {
        notes.push(format!(
            "the file has the cortex that was given, {given:.0} nm; the picture shows {:.0} nm",
            cortex.mean * found.nm_per_px
        ));
    }
    let smallest = match traced.kind {
        Kind::Layers => traced.layers.iter().map(|layer| layer.thickness.mean).fold(f64::INFINITY, f64::min),
        _ => traced.lattice.as_ref().map_or(f64::INFINITY, |lattice| lattice.diameter.mean),
    };
    if smallest < 12.0_f64.max(4.0 * traced.blur) {
        notes.push(format!(
            "the smallest measure is {smallest:.0} px: under 12 px, or four times the blur, measures are good to some percent only"
        ));
    }
    notes
}

fn spread_json(spread: Spread) -> Value {
    json!({"mean": spread.mean, "std": spread.std})
}

impl TracedImage {
    /// A length in px as nm.
    fn nm(&self, px: Spread) -> Spread {
        px.times(self.nm_per_px)
    }

    /// Layers from the top down with their media, nm; none of a picture that was traced as something else.
    pub fn layers_nm(&self) -> impl Iterator<Item = (&str, Spread)> {
        self.traced.layers.iter().map(|layer| (self.media[layer.class].as_str(), self.nm(layer.thickness)))
    }

    /// What was measured, as a document: `layers` or `lattice` (or neither of a section), each measure with `mean` and `std`; what was
    /// decided; lengths in nm.
    #[must_use]
    pub fn json(&self) -> Value {
        let traced = &self.traced;
        let mut document = json!({
            "kind": match traced.kind {
                Kind::Lattice => "lattice",
                Kind::Layers => "layers",
                Kind::Section => "section",
            },
            "nm_per_px": self.nm_per_px,
            "size_px": traced.flat.size(),
            "media": self.media,
            "thresholds": traced.thresholds,
            "levels": traced.levels,
            "blur_px": traced.blur,
            "noise": traced.noise,
            "notes": self.notes,
        });
        match (traced.kind, &traced.lattice) {
            (Kind::Layers, _) => {
                let layer = |(medium, thickness): (&str, Spread)| json!({"medium": medium, "thickness_nm": spread_json(thickness)});
                document["layers"] = self.layers_nm().map(layer).collect();
                document["turn_deg"] = traced.turn_deg.into();
            }
            (Kind::Lattice, Some(lattice)) => {
                document["lattice"] = json!({
                    "period_nm": spread_json(self.nm(lattice.period)),
                    "row_pitch_nm": spread_json(self.nm(lattice.row_pitch)),
                    "row_shift": spread_json(lattice.row_shift),
                    "diameter_nm": spread_json(self.nm(lattice.diameter)),
                    "hollow_nm": spread_json(self.nm(lattice.hollow)),
                    "rows": {"mean": lattice.rows, "std": 0.0},
                });
                document["rods"] = traced.rods.len().into();
                document["turn_deg"] = lattice.turn_deg.into();
                document["cortex_nm"] =
                    traced.cortex.map_or(Value::Null, |cortex| spread_json(self.nm(cortex)));
            }
            _ => {
                let medium = |class: &usize| self.media[*class].as_str();
                document["bands"] = traced.bands.classes.iter().map(medium).collect();
                document["regions"] = traced
                    .inclusions
                    .iter()
                    .map(|(class, outline)| {
                        let (area, [x, y]) = outline.area_and_middle();
                        json!({
                            "medium": medium(class),
                            "x_nm": x * self.nm_per_px,
                            "y_nm": y * self.nm_per_px,
                            "area_nm2": area * self.nm_per_px.powi(2),
                            "diameter_nm": outline.diameter() * self.nm_per_px,
                        })
                    })
                    .collect();
            }
        }
        document
    }
}
