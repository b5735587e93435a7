//! One way to write any of the formats: what the command line and Python both call.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Value, json};

use super::film::{FilmFormat, OneFilm};
use super::gonio::{Gonio, GonioGrid};
use super::osl::OslMaterial;
use super::scene::{ExportOptions, Exported};
use super::{BsdfTable, Deviation, Flavour, Model, usd};
use crate::brdf::{FeatherBrdf, Reciprocity};
use crate::io::image::{encode_exr, write_exr};
use crate::io::{
    FEW_BARBULES, MOST_WRITTEN_BARBULES, WRITTEN_IDENTITY, bytes_of, check_writable, encode_bsdf,
    write_together, write_usd, write_whole,
};
use crate::progress::Progress;
use crate::scene::description::{Named, ReadyScene};
use crate::scene::feather::{Feather, Grown, Level, VaneDisc};
use crate::spectrum::Spectrum;
use crate::stack::Stack;
use crate::{DVec3, Error, Result};

/// Barbules in the table of a shader.
const BARBULES: usize = 64;

barbule_base::words! {
    /// What other programs read.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Format {
        /// A scene for Mitsuba 3 with the plugin of `barbule.mitsuba`: XML, and shapes in a folder beside.
        "mitsuba": Mitsuba,
        /// A material's table over wavelengths, for Mitsuba's and pbrt's `measured`.
        "bsdf": Bsdf,
        /// The same of red, green and blue.
        "bsdf-rgb": BsdfRgb,
        /// A scene for pbrt-v4, its materials as tables.
        "pbrt": Pbrt,
        /// A material's shader and its table, for Blender's Cycles.
        "osl": Osl,
        /// A feather as USD, with ids and a preview material.
        "usd": Usd,
        /// A stack of one film as glTF with iridescence.
        "gltf": Gltf,
        /// A stack of one film as MaterialX with OpenPBR's surface.
        "openpbr": OpenPbr,
        /// A material's goniometric table as text.
        "csv": Csv,
        /// The same as a picture of many channels.
        "exr": Exr,
    }
}

/// What a format is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// A material.
    Material,
    /// A scene.
    Scene,
    /// A stack.
    Stack,
}

impl Format {
    /// What it is made of.
    #[must_use]
    pub fn needs(self) -> Needs {
        match self {
            Self::Bsdf | Self::BsdfRgb | Self::Osl | Self::Csv | Self::Exr => Needs::Material,
            Self::Mitsuba | Self::Pbrt | Self::Usd => Needs::Scene,
            Self::Gltf | Self::OpenPbr => Needs::Stack,
        }
    }

    /// The ending of its files' names, by which other programs know them.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Mitsuba => "xml",
            Self::Bsdf | Self::BsdfRgb => "bsdf",
            Self::Usd => "usda",
            Self::OpenPbr => "mtlx",
            Self::Pbrt | Self::Osl | Self::Gltf | Self::Csv | Self::Exr => self.word(),
        }
    }

    /// Whether it has tables that [`Request::most_bytes`] limits.
    #[must_use]
    pub fn has_size(self) -> bool {
        matches!(self, Self::Bsdf | Self::BsdfRgb | Self::Pbrt)
    }
}

/// What is exported.
#[derive(Debug, Clone, Copy)]
pub enum Source<'a> {
    /// A material.
    Material(&'a FeatherBrdf),
    /// A scene.
    Scene(&'a ReadyScene),
    /// A stack, and its name.
    Stack(&'a Stack, &'a str),
}

/// How it is exported.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// What for.
    pub format: Format,
    /// The file; formats of several files name the others after it.
    pub path: &'a Path,
    /// Most bytes of a `.bsdf`.
    pub most_bytes: usize,
    /// Width and height of pictures of scenes, pixels; the scene's own, or 1280 × 800, without.
    pub picture: Option<[u32; 2]>,
    /// Samples per pixel of these pictures.
    pub samples: u32,
    /// Names of a scene's parts that are left out, as mattes call them.
    pub without: &'a [String],
    /// Seed of feathers and their barbules.
    pub seed: u64,
    /// What made it, as names and texts, for formats that carry them.
    pub notes: &'a [(&'a str, &'a str)],
}

/// What was written.
#[derive(Debug, Clone)]
pub struct Written {
    /// The files, that of the request first, and folders of further ones.
    pub files: Vec<PathBuf>,
    /// Bytes of all of them.
    pub bytes: u64,
    /// What they are, in words.
    pub what: String,
    /// How far it is from what was exported; none of scenes whose materials are evaluated exactly.
    pub deviation: Option<Deviation>,
    /// What is lost or shown differently, a sentence each.
    pub remarks: Vec<String>,
    /// Numbers of the format's own.
    pub details: Value,
}

/// Exports.
///
/// # Errors
/// A source that the format is not made of, what the format has nothing for, a file that cannot be written, or a stop by `progress`.
pub fn export(source: Source<'_>, request: &Request<'_>, progress: &dyn Progress) -> Result<Written> {
    request.check_ending()?;
    check_writable(request.path)?;
    let mut written = match (request.format, source) {
        (Format::Bsdf, Source::Material(brdf)) => request.bsdf(brdf, Flavour::Spectral, progress),
        (Format::BsdfRgb, Source::Material(brdf)) => request.bsdf(brdf, Flavour::Rgb, progress),
        (Format::Csv | Format::Exr, Source::Material(brdf)) => request.gonio(brdf, progress),
        (Format::Osl, Source::Material(brdf)) => request.osl(brdf, progress),
        (Format::Mitsuba, Source::Scene(scene)) => request.mitsuba(scene, progress),
        (Format::Pbrt, Source::Scene(scene)) => request.pbrt(scene, progress),
        (Format::Usd, Source::Scene(scene)) => request.usd(scene, progress),
        (Format::Gltf, Source::Stack(stack, name)) => request.film((stack, name), FilmFormat::Gltf),
        (Format::OpenPbr, Source::Stack(stack, name)) => request.film((stack, name), FilmFormat::OpenPbr),
        (format, _) => Err(Error::input(format!(
            "{} is made of {}",
            format.word(),
            match format.needs() {
                Needs::Material => "a material",
                Needs::Scene => "a scene",
                Needs::Stack => "a stack",
            }
        ))),
    }?;
    written.bytes = written.files.iter().map(|path| bytes_of(path)).sum();
    Ok(written)
}

impl Written {
    /// As a JSON object: `files`, `bytes`, `relative_l1`, `bias`, `delta_e` (null where there are none), `remarks`, `details`.
    #[must_use]
    pub fn json(&self) -> Value {
        let number = |of: fn(&Deviation) -> f64| self.deviation.as_ref().map(of);
        let files: Vec<_> = self.files.iter().map(|path| path.to_string_lossy()).collect();
        json!({
            "files": files, "bytes": self.bytes, "relative_l1": number(|d| d.relative_l1), "bias": number(|d| d.bias),
            "delta_e": number(|d| d.delta_e), "remarks": self.remarks, "details": self.details,
        })
    }
}

impl Request<'_> {
    fn check_ending(&self) -> Result<()> {
        let ending = self.format.ending();
        if self.path.extension().is_some_and(|end| end.eq_ignore_ascii_case(ending)) {
            return Ok(());
        }
        Err(Error::input(format!("is to be {}; end its name with .{ending}", self.format.word()))
            .in_file(self.path))
    }

    fn written(&self, what: String, deviation: Option<Deviation>, details: Value) -> Written {
        Written { files: vec![self.path.to_owned()], bytes: 0, what, deviation, remarks: Vec::new(), details }
    }

    fn bsdf(&self, brdf: &FeatherBrdf, flavour: Flavour, progress: &dyn Progress) -> Result<Written> {
        // As scenes draw the material, and as their tables of pbrt are.
        let brdf = brdf.reciprocal_by(Reciprocity::Steeper);
        let (bytes, table) = self.table(&brdf, flavour, progress)?;
        write_whole(self.path, &bytes)?;
        let (r, channels) = (&table.resolution, table.channels());
        let what = format!("{} × {} directions, {channels} × {}² values each", r.thetas, r.phis, r.values);
        let details = json!({
            "theta_i": r.thetas, "phi_i": r.phis, "channels": channels, "values": r.values, "normals": r.normals,
            "sigma": table.crowding.sigma, "tail": table.crowding.tail, "m2": table.crowding.m2,
            "even": table.crowding.even,
        });
        Ok(self.written(what, Some(table.deviation), details))
    }

    fn table(
        &self,
        brdf: &FeatherBrdf,
        flavour: Flavour,
        progress: &dyn Progress,
    ) -> Result<(Vec<u8>, BsdfTable)> {
        let table = BsdfTable::of(brdf, flavour, self.most_bytes, progress)?;
        let mut about: serde_json::Map<String, Value> =
            self.notes.iter().map(|(name, text)| ((*name).to_owned(), (*text).into())).collect();
        about.insert(
            "frame".into(),
            "x along the barbule, z out of its upper side; indexed by the viewer's direction".into(),
        );
        Ok((encode_bsdf(&table.arrays, &Value::Object(about).to_string()), table))
    }

    fn gonio(&self, brdf: &FeatherBrdf, progress: &dyn Progress) -> Result<Written> {
        let gonio = Gonio::of(brdf, GonioGrid::default(), progress)?;
        if self.format == Format::Csv {
            write_whole(self.path, gonio.csv(self.notes).as_bytes())?;
        } else {
            let planes = gonio.planes();
            let facts: Vec<(&str, &str)> = (planes.facts.iter().map(|(name, text)| (&name[..], &text[..])))
                .chain(self.notes.iter().copied())
                .collect();
            let named = planes.planes.iter().map(|(name, values)| (&name[..], values.clone())).collect();
            write_exr(self.path, planes.size, named, vec![], &facts, &[])?;
        }
        let values = |nm: &[f64], view: DVec3, light: DVec3| {
            let own = gonio.interpolated(view, light);
            let spectrum = Spectrum::new(gonio.grid().wavelengths.clone(), own);
            nm.iter().map(|nm| spectrum.as_ref().map_or(0.0, |spectrum| spectrum.held(*nm))).collect()
        };
        let deviation = Deviation::of(&Model::Spectral(&values), brdf)?;
        let [a, b, c, d] = gonio.grid().lengths();
        let what = format!(
            "{} × {} pairs of directions, {} wavelengths",
            a * b,
            c * d,
            gonio.grid().wavelengths.len()
        );
        let details = json!({ "theta_i": a, "phi_i": b, "theta_s": c, "phi_s": d });
        Ok(self.written(what, Some(deviation), details))
    }

    fn osl(&self, brdf: &FeatherBrdf, progress: &dyn Progress) -> Result<Written> {
        let table = self.path.with_extension("exr");
        check_writable(&table)?;
        let material = OslMaterial::of(brdf, BARBULES, progress)?;
        let (size, planes) = material.planes();
        let picture = encode_exr(size, planes, vec![], self.notes, &[])?;
        let name = table.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let shader = material.shader(&name, self.notes);
        write_together(&[(self.path, shader.as_bytes()), (&table, &picture)])?;
        let values = |view, light| material.value(view, light);
        let deviation = Deviation::of(&Model::Rgb(&values), brdf)?;
        let what = format!("a shader, and its colours of {BARBULES} barbules in {}", table.display());
        let mut written = self.written(what, Some(deviation), json!({ "barbules": BARBULES }));
        written.files.push(table);
        Ok(written)
    }

    fn exported(&self, scene: &ReadyScene, progress: &dyn Progress) -> Result<Exported> {
        let size = self.picture.or(scene.size).unwrap_or(ExportOptions::default().size);
        let options =
            ExportOptions { size, samples: self.samples, seed: self.seed, without: self.without.to_vec() };
        Exported::new(scene, options, progress)
    }

    /// The folder of a scene's further files.
    fn folder(&self) -> PathBuf {
        self.path.with_extension("")
    }

    fn mitsuba(&self, scene: &ReadyScene, progress: &dyn Progress) -> Result<Written> {
        let exported = self.exported(scene, progress)?;
        exported.write_mitsuba(self.path)?;
        let what = format!("a scene, its shapes and tables in {}", self.folder().display());
        let mut written = self.written(what, None, Value::Null);
        written.files.push(self.folder());
        written.remarks = exported.remarks().to_vec();
        Ok(written)
    }

    fn pbrt(&self, scene: &ReadyScene, progress: &dyn Progress) -> Result<Written> {
        let exported = self.exported(scene, progress)?;
        let folder = self.folder();
        let mut first = None;
        exported.write_pbrt(self.path, &mut |brdf| {
            let (bytes, table) = self.table(brdf, Flavour::Spectral, progress)?;
            first.get_or_insert(table.deviation);
            Ok(bytes)
        })?;
        let what = format!("a scene, its shapes and tables in {}", folder.display());
        let mut written = self.written(what, first, Value::Null);
        written.files.push(folder);
        written.remarks = exported.remarks().to_vec();
        Ok(written)
    }

    fn usd(&self, scene: &ReadyScene, progress: &dyn Progress) -> Result<Written> {
        let feather = scene
            .feather()
            .ok_or_else(|| Error::input("the scene has no feather; USD is one of a feather"))?;
        let (brdf, name, hash) = worn(scene)
            .ok_or_else(|| Error::input("the scene's feather wears no material that USD could preview"))?;
        let grown = grown(feather, self.seed, progress)?;
        let look = usd::look(&brdf, &name, &hash)?;
        write_usd(self.path, &grown, &look, self.notes)?;
        let counts = grown.counts();
        let [r, g, b] = look.colour;
        let values = |view, light| usd::value(&look, view, light);
        let deviation = Deviation::of(&Model::Rgb(&values), &brdf)?;
        let what = format!("a feather of {} barbs and {} barbules", counts.barbs, counts.barbules);
        let details = json!({
            "barbs": counts.barbs, "barbules": counts.barbules, "colour": [r, g, b], "roughness": look.roughness,
        });
        Ok(self.written(what, Some(deviation), details))
    }

    fn film(&self, (stack, name): (&Stack, &str), format: FilmFormat) -> Result<Written> {
        let film = OneFilm::of(stack)?;
        let (rows, deviation) = film.compare(stack, format)?;
        write_whole(self.path, &film.encode(format, name, self.notes)?)?;
        let angles =
            rows.iter().map(|row| format!("{:.0}° {:.1}", row.angle_deg, row.delta_e)).collect::<Vec<_>>();
        let what = format!(
            "a film of {:.0} nm and index {:.3}; ΔE00 {}",
            film.thickness_nm,
            film.index,
            angles.join(", ")
        );
        let angles: Vec<Value> = rows
            .iter()
            .map(|row| {
                json!({
                    "angle_deg": row.angle_deg, "delta_e": row.delta_e, "delta_e_of_indices": row.delta_e_of_indices,
                    "exact": row.exact, "format": row.format,
                })
            })
            .collect();
        let details = json!({
            "index": film.index, "thickness_nm": film.thickness_nm, "base_index": film.base_index, "angles": angles,
        });
        let mut written = self.written(what, Some(deviation), details);
        if film.absorbs {
            written
                .remarks
                .push("the film absorbs, which these formats do not have: it is clear there".into());
        }
        if film.is_cut {
            written.remarks.push(
                "the boundary with the base reflects more than any base of index 1 and more: it is air there"
                    .into(),
            );
        }
        Ok(written)
    }
}

/// The material of the first barbules that wear one, its name and hash.
fn worn(scene: &ReadyScene) -> Option<(Arc<FeatherBrdf>, String, String)> {
    let mut scene = (**scene).clone();
    scene.needed_mut().into_iter().find_map(|(_, named)| match named {
        Named::Material(slot) => {
            Some((slot.value().ok()?.clone(), slot.name.clone(), slot.hash().to_owned()))
        }
        _ => None,
    })
}

/// A whole feather, with its barbules where they are few.
fn grown(feather: &Feather, seed: u64, progress: &dyn Progress) -> Result<Grown> {
    let whole = VaneDisc::WHOLE;
    let (_, barbs) = feather.barbs_within(whole, (seed, WRITTEN_IDENTITY), progress)?;
    let barbules: usize = barbs.iter().map(|barb| feather.barbule_count(barb)).sum();
    if barbules <= FEW_BARBULES.min(MOST_WRITTEN_BARBULES) {
        return feather.grow_watched(whole, Level::Barbules, None, (seed, WRITTEN_IDENTITY), progress);
    }
    progress.note(&format!("barbs only: with its {barbules} barbules the file would be large"));
    feather.grow_barbs(whole, seed, WRITTEN_IDENTITY, progress)
}
