//! What the store of an atlas holds: its axes, its arrays, and how many cells are one unit of work.

use std::path::Path;

use serde_json::{Value, json};

use super::design::{Design, Swept};
use super::plan::Plan;
use super::{Atlas, Plane};
use crate::Result;
use crate::characterize::CAMPAIGN_VERSION;
use crate::fields::Record as _;
use crate::io::Numbers;
use crate::io::sweep::{SweepArray, SweepAxis, SweepCoordinate, SweepLayout};

/// Files of a finished store that usual units keep to, and cells of the smallest usual unit.
const USUAL_FILES: usize = 9_000;
const USUAL_CELLS: usize = 8;

/// The names of axes and arrays.
pub(super) const PATCH: &str = "patch";
const SAMPLE: &str = "sample";
const ANGLE: &str = "angle";
const WAVELENGTH: &str = "wavelength";
const TRISTIMULUS: &str = "tristimulus";
const CHANNEL: &str = "channel";
/// Mean reflected fraction.
pub(super) const MEAN: &str = "mean";
/// Its standard deviation over individuals.
pub(super) const STD: &str = "std";
/// The wavelength of the highest peak.
pub(super) const PEAK: &str = "peak_nm";
/// CIE XYZ.
pub(super) const XYZ: &str = "xyz";
/// sRGB at the reflectance's own luminance.
pub(super) const SRGB: &str = "srgb";
/// sRGB as bright as a screen can show it.
pub(super) const NORMALIZED: &str = "srgb_normalized";

/// A store's layout as it is put together.
pub(super) struct Contents(SweepLayout);

impl Contents {
    /// What the store of an atlas holds.
    pub(super) fn of(atlas: &Atlas, plan: &Plan) -> Result<Self> {
        let (mut cells, coordinates) = swept(&atlas.design);
        if atlas.has_patches() {
            cells.insert(0, patches(atlas));
        }
        let mut layout = SweepLayout {
            name: atlas.name.clone(),
            width: atlas.width.name().to_owned(),
            cells,
            block: Vec::new(),
            further: further(atlas),
            coordinates,
            arrays: arrays(atlas),
            with_materials: atlas.material.is_some(),
            description: description(atlas, plan)?,
        };
        let per_unit = plan.unit_cells.unwrap_or_else(|| usual_cells(&layout));
        layout.block =
            block(&layout.cells.iter().map(|axis| axis.values.len()).collect::<Vec<_>>(), per_unit);
        Ok(Self(layout))
    }

    pub(super) fn layout(self) -> SweepLayout {
        self.0
    }
}

/// Cells of a unit: at least so many, and as many more as keep the files few.
fn usual_cells(layout: &SweepLayout) -> usize {
    if layout.with_materials {
        return 1;
    }
    let units = USUAL_FILES / (layout.arrays.len() + 1);
    layout.count().div_ceil(units).max(USUAL_CELLS)
}

/// A block of about so many cells: whole axes from the last one on, as far as they go in, then a part of the next.
pub(super) fn block(lengths: &[usize], cells: usize) -> Vec<usize> {
    let mut left = cells.max(1);
    let mut block: Vec<usize> = lengths
        .iter()
        .rev()
        .map(|length| {
            let part = left.min(*length);
            // Of an axis that does not go in as a whole nothing before it does.
            left = if part < *length { 1 } else { left.div_ceil(*length) };
            part
        })
        .collect();
    block.reverse();
    block
}

/// The axes of the keys, and of samples their sizes along them.
fn swept(design: &Design) -> (Vec<SweepAxis>, Vec<SweepCoordinate>) {
    match design {
        Design::Grid(keys) => {
            let axis = |key: &Swept| SweepAxis {
                name: key.key.clone(),
                units: key.size.unit.clone(),
                meaning: key.size.about.clone(),
                values: Numbers::Floats(key.values.clone()),
                labels: Vec::new(),
            };
            (keys.iter().map(axis).collect(), Vec::new())
        }
        Design::Samples { count, keys } => {
            let coordinate = |key: &Swept| SweepCoordinate {
                name: key.key.clone(),
                axis: SAMPLE.into(),
                units: key.size.unit.clone(),
                meaning: key.size.about.clone(),
                values: key.values.clone(),
            };
            let axis = counted(SAMPLE, "number of the sample of a Latin hypercube", *count, Vec::new());
            (vec![axis], keys.iter().map(coordinate).collect())
        }
    }
}

/// An axis whose values only count, from 0.
fn counted(name: &str, meaning: &str, count: usize, labels: Vec<String>) -> SweepAxis {
    let values = Numbers::Counts((0..count as u64).collect());
    SweepAxis { name: name.into(), units: String::new(), meaning: meaning.into(), values, labels }
}

fn patches(atlas: &Atlas) -> SweepAxis {
    let names: Vec<String> = atlas.subjects.iter().map(|(name, _)| name.clone()).collect();
    counted(PATCH, &format!("patch of plumage: {}", listed(&names)), names.len(), names)
}

/// `0 a, 1 b`, of many the first.
fn listed(names: &[String]) -> String {
    const FEW: usize = 12;
    let words = names.iter().take(FEW).enumerate().map(|(i, name)| format!("{i} {name}"));
    let more = (names.len() > FEW).then(|| "…".to_owned());
    words.chain(more).collect::<Vec<_>>().join(", ")
}

/// The axes after those of cells.
fn further(atlas: &Atlas) -> Vec<SweepAxis> {
    let measured = |name: &str, units: &str, meaning: &str, values: &[f64]| SweepAxis {
        name: name.into(),
        units: units.into(),
        meaning: meaning.into(),
        values: Numbers::Floats(values.to_vec()),
        labels: Vec::new(),
    };
    let plane = match atlas.plane {
        Plane::Across => "angle of incidence across the barbule, phi_i",
        Plane::Along => "angle of incidence along the barbule, theta_i",
    };
    let mut axes = vec![
        measured(ANGLE, "degree", plane, &atlas.angles_deg),
        measured(WAVELENGTH, "nm", "vacuum wavelength", atlas.wavelengths.nm()),
    ];
    if atlas.has_colours {
        let words = |words: [&str; 3]| words.map(str::to_owned).to_vec();
        axes.push(counted(TRISTIMULUS, "0 X, 1 Y, 2 Z", 3, words(["X", "Y", "Z"])));
        axes.push(counted(CHANNEL, "0 red, 1 green, 2 blue", 3, words(["red", "green", "blue"])));
    }
    for (index, (_, view)) in atlas.views.iter().enumerate() {
        let cones: Vec<String> = view.eye.cones.iter().map(|cone| cone.name.clone()).collect();
        axes.push(counted(
            &cone_axis(atlas, index),
            &format!("cone: {}", listed(&cones)),
            cones.len(),
            cones,
        ));
    }
    axes
}

/// What a bird's axis of cones and its array are called.
fn cone_axis(atlas: &Atlas, index: usize) -> String {
    format!("cone_{}", bird_name(atlas, index))
}

/// What the array of a bird's catches is called.
pub(super) fn catches(atlas: &Atlas, index: usize) -> String {
    format!("catches_{}", bird_name(atlas, index))
}

/// A bird as arrays are called: the name or the file that the plan gives, in letters and digits, with its number where another is
/// called so.
fn bird_name(atlas: &Atlas, index: usize) -> String {
    let plain = |typed: &str| -> String {
        let lower = Path::new(typed).file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
        lower.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(40).collect()
    };
    let name = plain(&atlas.views[index].0);
    let same = atlas.views.iter().filter(|(typed, _)| plain(typed) == name).count();
    if same > 1 || name.is_empty() { format!("{name}{index}") } else { name }
}

fn arrays(atlas: &Atlas) -> Vec<SweepArray> {
    let array = |name: &str, units: &str, meaning: &str, along: &[&str], is_bytes| SweepArray {
        name: name.into(),
        units: units.into(),
        meaning: meaning.into(),
        along: along.iter().map(|name| (*name).to_owned()).collect(),
        is_bytes,
    };
    let curve = [ANGLE, WAVELENGTH];
    let mut all = vec![
        array(MEAN, "", "reflected fraction of unpolarized light, mean over individuals", &curve, false),
        array(STD, "", "standard deviation of the reflected fraction over individuals", &curve, false),
        array(
            PEAK,
            "nm",
            "wavelength of the highest peak; none where the reflectance only rises or falls",
            &[ANGLE],
            false,
        ),
    ];
    if atlas.has_colours {
        all.push(array(
            XYZ,
            "",
            "CIE 1931 XYZ under D65; a perfect white has Y = 1",
            &[ANGLE, TRISTIMULUS],
            false,
        ));
        all.push(array(
            SRGB,
            "",
            "sRGB at the reflectance's own luminance, 0 to 255",
            &[ANGLE, CHANNEL],
            true,
        ));
        let bright = "sRGB as bright as a screen can show it, 0 to 255";
        all.push(array(NORMALIZED, "", bright, &[ANGLE, CHANNEL], true));
    }
    for (index, (_, view)) in atlas.views.iter().enumerate() {
        let meaning = format!(
            "quanta that cones of {} catch in {}, over those of white",
            view.eye.name, view.light.name
        );
        let axis = cone_axis(atlas, index);
        all.push(array(&catches(atlas, index), "", &meaning, &[ANGLE, &axis], false));
    }
    all
}

/// Every parameter that decides a number.
fn description(atlas: &Atlas, plan: &Plan) -> Result<Value> {
    let subject = |(name, subject): &(String, super::Subject)| {
        Ok(json!({"name": name, "structure": subject.structure()?.description()}))
    };
    let eyes = atlas.views.iter().map(|(_, view)| {
        let cones = view.eye.all_cones().map(|cone| {
            json!({"name": cone.name, "peak_nm": cone.peak_nm, "sensitivity": digest(cone.sensitivity.values())})
        });
        json!({
            "name": view.eye.name,
            "cones": cones.collect::<Vec<_>>(),
            "light": view.light.name,
            "quanta": digest(view.light.quanta.values()),
        })
    });
    let mut table = plan.table();
    if let Value::Object(table) = &mut table {
        // What they say is opened or laid out: files may lie elsewhere, and the block is an attribute of its own.
        for key in ["structure", "patches", "birds", "illuminant", "unit_cells", "barbule"] {
            table.remove(key);
        }
    }
    Ok(json!({
        "campaign_version": CAMPAIGN_VERSION,
        "seed": atlas.seed,
        "plan": table,
        "patches": atlas.subjects.iter().map(subject).collect::<Result<Vec<_>>>()?,
        "eyes": eyes.collect::<Vec<_>>(),
    }))
}

/// A short name of a curve by its numbers.
fn digest(values: &[f64]) -> String {
    let mut hasher = crate::identity::Hasher::new("curve");
    let hex = hasher.numbers("values", values).hex();
    hex.chars().take(16).collect()
}

#[cfg(test)]
mod tests {
    use super::block;

    #[test]
    fn blocks_are_whole_axes_from_the_last_one_on() {
        assert_eq!(block(&[40, 30], 8), [1, 8]);
        assert_eq!(block(&[40, 30], 60), [2, 30]);
        assert_eq!(block(&[3, 300], 1), [1, 1]);
        assert_eq!(block(&[5, 4, 3], 24), [2, 4, 3]);
        assert_eq!(block(&[5, 4, 3], 7), [1, 3, 3]);
        assert_eq!(block(&[2, 2], 100), [2, 2]);
    }
}
