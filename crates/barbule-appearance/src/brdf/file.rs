//! Feather materials as the bytes of `.barbule` files: *safetensors* containers with a JSON description. Whoever opens files, or
//! fetches them, is above.
//!
//! `docs/formats/material.md` describes the layout. Parameters are 16-bit codes, so that a material of the default
//! sampling stays under 600 kB; each array has the map that suits it.

use std::collections::{BTreeMap, HashMap};

use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use serde::{Deserialize, Serialize};

use super::container::checksum_of;
use super::halo::Halo;
use super::material::{
    FeatherMaterial, LobeSet, ParameterSet, STEEPEST_FRACTION, SteadySet, achromatic_lengths, table_axes,
};
use super::noise::Spectral;
use crate::scattering::lobe::FitKind;
use crate::scattering::statistics::{Axes, Sides};
use crate::{Error, Result};

/// Version of the layout: steady parts are shares of the mean since 5.
const SCHEMA: u32 = 5;

/// The one entry of the container's metadata.
const ENTRY: &str = "barbule";

/// The description inside the container.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Description {
    schema: u32,
    program: String,
    kind: String,
    /// `both` where the arrays hold both signs of φ_i, else `alike`.
    sides: String,
    sigma: f64,
    seed: u64,
    /// h of the height phase, µm, and the share of achromatic instances; left out where both are 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    height_um: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    achromatic: Option<f64>,
    /// How a code k of each array becomes a value.
    maps: BTreeMap<String, String>,
    info: serde_json::Value,
    /// BLAKE3 of this description without the checksum, then of each tensor's name and bytes in the order of names.
    checksum: String,
}

/// How a 16-bit code k stands for a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Map {
    /// 0.001^(1 − k/65535), relative step 1.1e-4.
    Roughness,
    /// (k − 32768)/32767 · π/2, so that 0 is exact.
    Azimuth,
    /// (k/65535)², finer where little is reflected.
    Fraction,
    /// 64^((k − 32768)/32767), so that 1 is exact.
    Length,
    /// k/65535.
    Share,
    /// (k − 32768)/32767 · 4, so that 0 is exact.
    Slope,
}

impl Map {
    fn text(self) -> &'static str {
        match self {
            Self::Roughness => "0.001^(1 - k/65535)",
            Self::Azimuth => "(k - 32768)/32767 * pi/2",
            Self::Fraction => "(k/65535)^2",
            Self::Length => "64^((k - 32768)/32767)",
            Self::Share => "k/65535",
            Self::Slope => "(k - 32768)/32767 * 4",
        }
    }

    fn value(self, code: u16) -> f32 {
        let unit = f64::from(code) / 65535.0;
        let signed = ((f64::from(code) - 32768.0) / 32767.0).max(-1.0);
        (match self {
            Self::Roughness => libm::pow(0.001, 1.0 - unit),
            Self::Azimuth => signed * std::f64::consts::FRAC_PI_2 * (1.0 - 1e-7),
            Self::Fraction => unit * unit,
            Self::Length => libm::pow(64.0, signed),
            Self::Share => unit,
            Self::Slope => STEEPEST_FRACTION * signed,
        }) as f32
    }

    fn code(self, value: f32) -> u16 {
        let v = f64::from(value);
        let signed = |s: f64| 32768.0 + 32767.0 * s.clamp(-1.0, 1.0);
        let code = match self {
            Self::Roughness => 65535.0 * (1.0 - libm::log(v.max(1e-9)) / libm::log(0.001)),
            Self::Azimuth => signed(v / std::f64::consts::FRAC_PI_2),
            Self::Fraction => 65535.0 * v.max(0.0).sqrt(),
            Self::Length => signed(libm::log(v.max(1e-9)) / libm::log(64.0)),
            Self::Share => 65535.0 * v,
            Self::Slope => signed(v / STEEPEST_FRACTION),
        };
        code.round().clamp(0.0, 65535.0) as u16
    }
}

/// Arrays of a lobe of the mean, with their maps; the names of the second have an ending.
const LOBE: [(&str, Map); 3] = [("m", Map::Roughness), ("phi", Map::Azimuth), ("rho", Map::Fraction)];

/// Endings of the lobes of a set's mean: a single lobe has none of the second.
const MEAN: [&str; 2] = ["", "_2"];

/// Arrays of the steady part.
const STEADY: [(&str, Map); 3] =
    [("m_sta", Map::Roughness), ("phi_sta", Map::Azimuth), ("share_sta", Map::Share)];

/// Whether an array belongs to each set, to those of unpolarized light alone, or to all sets together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Belongs {
    Set,
    Unpolarized,
    Material,
}

/// What else there is.
const OTHERS: [(&str, Map, Belongs); 4] = [
    ("length", Map::Length, Belongs::Set),
    ("fraction_1", Map::Share, Belongs::Unpolarized),
    ("fraction_1_slope", Map::Slope, Belongs::Unpolarized),
    ("correlation", Map::Share, Belongs::Material),
];

/// The arrays over directions alone, in single precision.
const SLOPES: [&str; 2] = ["steepness", "strength"];

/// The arrays of a halo: its widths and axes in double precision, then its shares and its power in single.
const HALO_AXES: [&str; 4] = ["halo_sigma", "halo_wavelengths_nm", "halo_cos_theta", "halo_cos_phi"];
const HALO_INDEX: &str = "halo_index";
const HALO_SHARES: &str = "halo_shares";
const HALO_POWER: &str = "halo_power";

/// The arrays of a set by name, empty ones left out.
fn arrays(set: &ParameterSet) -> Vec<(String, Map, &[f32])> {
    let mut all = Vec::new();
    for (ending, LobeSet { m, phi, reflected }) in MEAN.iter().zip(&set.mean) {
        for ((name, map), values) in LOBE.into_iter().zip([m, phi, reflected]) {
            all.push((format!("{name}{ending}"), map, &values[..]));
        }
    }
    let SteadySet { m, phi, share } = &set.steady;
    for ((name, map), values) in STEADY.into_iter().zip([m, phi, share]) {
        all.push((name.to_owned(), map, &values[..]));
    }
    let [length, fraction, fraction_slope, _] = OTHERS;
    for ((name, map, _), values) in
        [(length, &set.length), (fraction, &set.fraction_1), (fraction_slope, &set.fraction_1_slope)]
    {
        all.push((name.to_owned(), map, &values[..]));
    }
    all.retain(|(_, _, values)| !values.is_empty());
    all
}

/// How the codes of every array that can be become values.
fn maps() -> impl Iterator<Item = (String, Map)> {
    let of_lobe = |ending: &'static str| LOBE.map(|(name, map)| (format!("{name}{ending}"), map));
    let others = STEADY.into_iter().chain(OTHERS.map(|(name, map, _)| (name, map)));
    MEAN.into_iter().flat_map(of_lobe).chain(others.map(|(name, map)| (name.to_owned(), map)))
}

/// Prefix of a set's arrays.
fn prefix(set: usize, sets: usize) -> String {
    if sets == 1 { String::new() } else { format!("p{}.", set + 1) }
}

/// The bytes of a material's file. Equal materials give equal bytes.
///
/// # Errors
/// A material that fails [`FeatherMaterial::check`].
pub fn encode_material(material: &FeatherMaterial) -> Result<Vec<u8>> {
    material.check()?;
    let axes = &material.axes;
    let shape = vec![axes.wavelengths_nm().len(), axes.cos_theta().len(), axes.phis()];
    let codes = |map: Map, values: &[f32]| -> Vec<u8> {
        values.iter().flat_map(|&v| map.code(v).to_le_bytes()).collect()
    };
    let doubles = |values: &[f64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut tensors: BTreeMap<String, (Dtype, Vec<usize>, Vec<u8>)> = BTreeMap::new();
    for (name, values) in [
        ("wavelengths_nm", axes.wavelengths_nm()),
        ("cos_theta", axes.cos_theta()),
        ("cos_phi", axes.cos_phi()),
        ("noise_power", &material.noise_power),
    ] {
        tensors.insert(name.into(), (Dtype::F64, vec![values.len()], doubles(values)));
    }
    for (number, set) in material.sets.iter().enumerate() {
        let place = prefix(number, material.sets.len());
        for (name, map, values) in arrays(set) {
            tensors.insert(format!("{place}{name}"), (Dtype::U16, shape.clone(), codes(map, values)));
        }
    }
    for (name, map, _) in OTHERS.into_iter().filter(|(.., belongs)| *belongs == Belongs::Material) {
        tensors.insert(name.into(), (Dtype::U16, shape.clone(), codes(map, &material.correlation)));
    }
    let spectral = (material.spectral != Spectral::default()).then_some(material.spectral);
    for (name, values) in SLOPES.into_iter().zip([&material.steepness, &material.strength]) {
        tensors.insert(name.into(), (Dtype::F32, shape[1..].to_vec(), floats(values)));
    }
    if let Some(halo) = &material.halo {
        let axes = [&halo.sigma, &halo.wavelengths_nm, &halo.cos_theta, &halo.cos_phi];
        for (name, values) in HALO_AXES.into_iter().zip(axes) {
            tensors.insert(name.into(), (Dtype::F64, vec![values.len()], doubles(values)));
        }
        let shape: Vec<usize> = axes.iter().map(|axis| axis.len()).collect();
        tensors.insert(HALO_INDEX.into(), (Dtype::F64, vec![1], doubles(&[halo.index])));
        tensors.insert(HALO_POWER.into(), (Dtype::F32, shape[1..].to_vec(), floats(&halo.power)));
        tensors.insert(HALO_SHARES.into(), (Dtype::F32, shape, floats(&halo.shares)));
    }
    let mut description = Description {
        schema: SCHEMA,
        program: format!("barbule {}", env!("CARGO_PKG_VERSION")),
        kind: kind_name(material.kind).into(),
        sides: sides_name(axes.sides()).into(),
        sigma: material.sigma,
        seed: material.seed,
        height_um: spectral.map(|spectral| spectral.height_um),
        achromatic: spectral.map(|spectral| spectral.achromatic),
        maps: maps().map(|(name, map)| (name, map.text().to_owned())).collect(),
        info: material.info.clone(),
        checksum: String::new(),
    };
    let bytes = tensors.iter().map(|(name, (_, _, bytes))| (name.as_str(), bytes.as_slice()));
    description.checksum = checksum_of(&description, bytes)?;
    let json =
        serde_json::to_string(&description).map_err(|e| Error::machine(format!("no JSON form: {e}")))?;
    let views = tensors
        .iter()
        .map(|(name, (dtype, shape, bytes))| {
            TensorView::new(*dtype, shape.clone(), bytes)
                .map(|view| (name.as_str(), view))
                .map_err(|e| Error::machine(format!("array {name} cannot be stored: {e}")))
        })
        .collect::<Result<Vec<_>>>()?;
    safetensors::serialize(views, Some(HashMap::from([(ENTRY.to_owned(), json)])))
        .map_err(|e| Error::machine(format!("the material cannot be stored: {e}")))
}

/// A material from the bytes of its file. Never allocates more than a few times the bytes given.
///
/// # Errors
/// Anything but a complete, undamaged material of a known schema, in one sentence.
pub fn decode_material(bytes: &[u8]) -> Result<FeatherMaterial> {
    let damaged = |what: String| Error::input(format!("is not a material file: {what}"));
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| damaged(short(&e.to_string())))?;
    let json = metadata.metadata().as_ref().and_then(|entries| entries.get(ENTRY)).ok_or_else(|| {
        damaged(format!("its metadata has no entry '{ENTRY}' (another kind of safetensors?)"))
    })?;
    let description = describe(json)?;
    let container = SafeTensors::deserialize(bytes).map_err(|e| damaged(short(&e.to_string())))?;
    let mut names = container.names();
    names.sort_unstable();
    let views = names
        .iter()
        .map(|name| container.tensor(name).map(|view| (*name, view)))
        .collect::<Result<BTreeMap<_, _>, _>>()
        .map_err(|e| damaged(short(&e.to_string())))?;
    let bare = Description { checksum: String::new(), ..description.clone() };
    let found = checksum_of(&bare, views.iter().map(|(name, view)| (*name, view.data())))?;
    if found != description.checksum {
        return Err(Error::input(
            "the checksum does not match the contents: the file was damaged or edited; fetch or fit it again",
        ));
    }
    let axes = table_axes(
        doubles(&views, "wavelengths_nm")?,
        doubles(&views, "cos_theta")?,
        doubles(&views, "cos_phi")?,
    )?
    .with_sides(sides_of(&description.sides)?);
    let count = if views.contains_key("p1.m") { 2 } else { 1 };
    let sets: Vec<ParameterSet> = (0..count)
        .map(|set| decode_set(&views, &axes, &prefix(set, count), count == 1))
        .collect::<Result<_>>()?;
    let [height_um, achromatic] =
        [description.height_um, description.achromatic].map(|value| value.unwrap_or_default());
    let material = FeatherMaterial {
        correlation: codes(&views, &axes, "correlation", Map::Share)?,
        steepness: singles(&views, SLOPES[0], &[axes.cos_theta().len(), axes.phis()])?,
        strength: singles(&views, SLOPES[1], &[axes.cos_theta().len(), axes.phis()])?,
        achromatic_length: achromatic_lengths(&axes, &sets),
        sets,
        spectral: Spectral { height_um, achromatic },
        halo: views.contains_key(HALO_SHARES).then(|| decode_halo(&views)).transpose()?,
        axes,
        kind: kind_of(&description.kind)?,
        sigma: description.sigma,
        noise_power: doubles(&views, "noise_power")?,
        seed: description.seed,
        info: description.info,
    };
    material.check()?;
    Ok(material)
}

/// Reads the description, its schema first: later versions may have other fields.
fn describe(json: &str) -> Result<Description> {
    #[derive(Deserialize)]
    struct Schema {
        schema: u32,
    }
    let refuse = |e: serde_json::Error| {
        Error::input(format!("the description in its metadata is not valid: {}", short(&e.to_string())))
    };
    let Schema { schema } = serde_json::from_str(json).map_err(refuse)?;
    if schema != SCHEMA {
        return Err(Error::input(format!(
            "has schema {schema}, but this program reads schema {SCHEMA}; fit it again or use another version of barbule"
        )));
    }
    let description: Description = serde_json::from_str(json).map_err(refuse)?;
    for (name, map) in maps() {
        if description.maps.get(&name).map(String::as_str) != Some(map.text()) {
            let error =
                Error::input(format!("array {name} has another map than '{}'; fit it again", map.text()));
            return Err(error.about(name));
        }
    }
    Ok(description)
}

fn decode_set(
    views: &BTreeMap<&str, TensorView<'_>>,
    axes: &Axes,
    place: &str,
    fractions: bool,
) -> Result<ParameterSet> {
    let array =
        |name: &str, ending: &str, map: Map| codes(views, axes, &format!("{place}{name}{ending}"), map);
    let lobe = |ending: &str| -> Result<LobeSet> {
        let [(m, roughness), (phi, azimuth), (rho, fraction)] = LOBE;
        Ok(LobeSet {
            m: array(m, ending, roughness)?,
            phi: array(phi, ending, azimuth)?,
            reflected: array(rho, ending, fraction)?,
        })
    };
    let [length, fraction, fraction_slope, _] = OTHERS;
    let other = |(name, map, belongs): (&str, Map, Belongs)| match belongs {
        Belongs::Unpolarized if !fractions => Ok(Vec::new()),
        _ => array(name, "", map),
    };
    // The first lobe is always there; the second where any of its arrays is.
    let second =
        LOBE.iter().any(|(name, _)| views.contains_key(format!("{place}{name}{}", MEAN[1]).as_str()));
    Ok(ParameterSet {
        mean: MEAN[..=usize::from(second)].iter().map(|ending| lobe(ending)).collect::<Result<_>>()?,
        steady: SteadySet {
            m: array(STEADY[0].0, "", STEADY[0].1)?,
            phi: array(STEADY[1].0, "", STEADY[1].1)?,
            share: array(STEADY[2].0, "", STEADY[2].1)?,
        },
        length: other(length)?,
        fraction_1: other(fraction)?,
        fraction_1_slope: other(fraction_slope)?,
    })
}

/// The values of an array of the axes' shape.
fn codes(views: &BTreeMap<&str, TensorView<'_>>, axes: &Axes, name: &str, map: Map) -> Result<Vec<f32>> {
    let shape = [axes.wavelengths_nm().len(), axes.cos_theta().len(), axes.phis()];
    let view = shaped(views, name, Dtype::U16, &shape)?;
    Ok(view.data().as_chunks::<2>().0.iter().map(|b| map.value(u16::from_le_bytes(*b))).collect())
}

fn decode_halo(views: &BTreeMap<&str, TensorView<'_>>) -> Result<Halo> {
    let [sigma, nm, cos_theta, cos_phi] = HALO_AXES.map(|name| doubles(views, name));
    let (sigma, wavelengths_nm, cos_theta, cos_phi) = (sigma?, nm?, cos_theta?, cos_phi?);
    let shape = [sigma.len(), wavelengths_nm.len(), cos_theta.len(), cos_phi.len()];
    Ok(Halo {
        shares: singles(views, HALO_SHARES, &shape)?,
        power: singles(views, HALO_POWER, &shape[1..])?,
        index: shaped(views, HALO_INDEX, Dtype::F64, &[1]).and(doubles(views, HALO_INDEX))?[0],
        sigma,
        wavelengths_nm,
        cos_theta,
        cos_phi,
    })
}

/// The values of an array of this shape in single precision.
fn singles(views: &BTreeMap<&str, TensorView<'_>>, name: &str, shape: &[usize]) -> Result<Vec<f32>> {
    let view = shaped(views, name, Dtype::F32, shape)?;
    Ok(view.data().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
}

/// An array of this type and shape.
fn shaped<'a, 'b>(
    views: &'a BTreeMap<&str, TensorView<'b>>,
    name: &str,
    dtype: Dtype,
    shape: &[usize],
) -> Result<&'a TensorView<'b>> {
    let view = view(views, name, dtype)?;
    if view.shape() != shape {
        let error = Error::input(format!(
            "array {name} has shape {}, but the axes ask for {}",
            short(&format!("{:?}", view.shape())),
            short(&format!("{shape:?}"))
        ));
        return Err(error.about(name));
    }
    Ok(view)
}

fn view<'a, 'b>(
    views: &'a BTreeMap<&str, TensorView<'b>>,
    name: &str,
    dtype: Dtype,
) -> Result<&'a TensorView<'b>> {
    let view = views.get(name).ok_or_else(|| {
        Error::input(format!("array {name} is missing; the file is incomplete, fit the material again"))
            .about(name)
    })?;
    if view.dtype() != dtype {
        let error = Error::input(format!("array {name} has type {:?}, but must be {dtype:?}", view.dtype()));
        return Err(error.about(name));
    }
    Ok(view)
}

fn doubles(views: &BTreeMap<&str, TensorView<'_>>, name: &str) -> Result<Vec<f64>> {
    let view = view(views, name, Dtype::F64)?;
    if view.shape().len() != 1 {
        let error =
            Error::input(format!("array {name} has {} dimensions, but must have one", view.shape().len()));
        return Err(error.about(name));
    }
    Ok(view.data().as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect())
}

fn kind_name(kind: FitKind) -> &'static str {
    match kind {
        FitKind::Marginal => "marginal",
        FitKind::Cone => "cone",
    }
}

fn kind_of(name: &str) -> Result<FitKind> {
    match name {
        "marginal" => Ok(FitKind::Marginal),
        "cone" => Ok(FitKind::Cone),
        other => Err(Error::input(format!(
            "the fit's kind is '{}', but must be 'marginal' or 'cone'",
            short(other)
        ))),
    }
}

fn sides_name(sides: Sides) -> &'static str {
    match sides {
        Sides::Alike => "alike",
        Sides::Both => "both",
    }
}

fn sides_of(name: &str) -> Result<Sides> {
    match name {
        "alike" => Ok(Sides::Alike),
        "both" => Ok(Sides::Both),
        other => {
            Err(Error::input(format!("its sides are '{}', but must be 'alike' or 'both'", short(other))))
        }
    }
}

/// A message of another library, or a user's text, in a length that fits a sentence.
fn short(text: &str) -> String {
    let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(160).collect();
    if text.chars().count() > 160 { format!("{line}…") } else { line }
}

#[cfg(test)]
mod tests;
