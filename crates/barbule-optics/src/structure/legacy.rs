//! Identities of version 1: hashes of texts as `Debug` printed the types of that time.
//!
//! They are in materials, stores and tables that earlier versions made, and serve only to recognise these. The texts are
//! spelled out here and fixed for good; only how the values are reached may follow renamings.

use serde_json::{Map, Value, json};

use super::{
    Circle, CrystalLayer, Inclusion, Lattice, Loop, Medium, Placed, Polyline, Regularity, Rod, Section,
    Structure, Substance,
};
use crate::Complex64;
use crate::material::{Library, Material, Rule};

/// [`Structure::description`] as version 1 wrote it.
#[must_use]
pub(super) fn description(structure: &Structure) -> Value {
    match structure {
        Structure::Species(model) => json!({
            "species": model.name,
            "variant": model.variant,
            "parameters": model.parameters,
            "materials": materials(&model.library, ["air", "keratin", "melanin"].into_iter())
                .into_iter()
                .map(|(name, hash)| (name, hash.into()))
                .collect::<Map<_, _>>(),
        }),
        // No earlier version knew it.
        Structure::Stack(_) | Structure::Below(_) => structure.description(),
        Structure::Sections { name, sections } => json!({
            "sections": name,
            "hashes": sections.iter().map(section_hash).collect::<Vec<_>>(),
        }),
    }
}

/// A lattice's hash as version 1 wrote it.
#[must_use]
pub(super) fn lattice_hash(lattice: &Lattice) -> String {
    let circles = lattice.rods.iter().flat_map(|rod| &rod.circles).map(|circle| &circle.medium);
    let media = [&lattice.host, &lattice.incidence].into_iter().chain(circles);
    let materials = list(media.map(|m| some(lattice.material(m).ok().as_ref().map(material))));
    let places = list(lattice.placed().map(|Placed { rod, row, x_um, depth_um }| {
        format!("Placed {{ rod: {rod}, row: {row}, x_um: {x_um:?}, depth_um: {depth_um:?} }}")
    }));
    let rods = list(lattice.rods.iter().map(rod));
    hash(&format!("{:?} {places} {rods} {materials}", lattice.period_um))
}

fn section_hash(section: &Section) -> String {
    let names = section.all_media().flat_map(Medium::substances).filter_map(|substance| match substance {
        Substance::Named(name) => Some(name.as_str()),
        Substance::Index(_) => None,
    });
    let materials = materials(&section.library, names)
        .into_iter()
        .map(|(name, hash)| format!("{name:?}: String({hash:?})"))
        .collect::<Vec<_>>();
    let boundaries = list(section.boundaries.iter().map(polyline));
    let media = list(section.media.iter().map(medium));
    let inclusions = list(section.inclusions.iter().map(inclusion));
    let mut text =
        format!("({:?}, {boundaries}, {media}, {inclusions}) {{{}}}", section.width_um, materials.join(", "));
    if let Some(CrystalLayer { lattice, offset_um, regularity }) = &section.crystal {
        let regularity =
            some(regularity.as_ref().map(|Regularity { x_um, value }| {
                format!("Regularity {{ x_um: {x_um:?}, value: {value:?} }}")
            }));
        text += &format!(" {} {offset_um:?} {regularity}", lattice_hash(lattice));
    }
    hash(&text)
}

/// The hash of each named material, in the order of first appearance.
fn materials<'a>(library: &Library, names: impl Iterator<Item = &'a str>) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    for name in names {
        if found.iter().all(|(known, _)| known != name)
            && let Ok(named) = crate::material::parse(name, library)
        {
            found.push((name.to_owned(), hash(&material(&named))));
        }
    }
    found
}

fn material(of: &Material) -> String {
    match of {
        Material::Constant(index) => format!("Constant({})", complex(index)),
        Material::Cauchy { a, b_nm2 } => format!("Cauchy {{ a: {a:?}, b_nm2: {b_nm2:?} }}"),
        Material::AbsorbingCauchy { a, b_nm2, c, decay_nm } => {
            format!("AbsorbingCauchy {{ a: {a:?}, b_nm2: {b_nm2:?}, c: {c:?}, decay_nm: {decay_nm:?} }}")
        }
        Material::Table(table) => format!(
            "Table(Table {{ name: {:?}, wavelength_nm: {:?}, index: {} }})",
            table.name(),
            table.wavelengths_nm(),
            list(table.indices().iter().map(complex))
        ),
        Material::Mixture(mixture) => format!(
            "Mixture(Mixture {{ a: {}, b: {}, fraction: {:?}, rule: {}, depth: {} }})",
            material(mixture.a()),
            material(mixture.b()),
            mixture.fraction(),
            match mixture.rule() {
                Rule::Linear => "Linear",
                Rule::MaxwellGarnett => "MaxwellGarnett",
                Rule::Bruggeman => "Bruggeman",
            },
            mixture.depth()
        ),
    }
}

fn medium(of: &Medium) -> String {
    match of {
        Medium::Pure(pure) => format!("Pure({})", substance(pure)),
        Medium::Mixture { first, second, x_um, fraction } => format!(
            "Mixture {{ first: {}, second: {}, x_um: {x_um:?}, fraction: {fraction:?} }}",
            substance(first),
            substance(second)
        ),
    }
}

fn substance(of: &Substance) -> String {
    match of {
        Substance::Named(name) => format!("Named({name:?})"),
        Substance::Index(index) => format!("Index({})", complex(index)),
    }
}

fn inclusion(Inclusion { outline, medium: inside, holes }: &Inclusion) -> String {
    let holes = list(holes.iter().map(closed));
    format!("Inclusion {{ outline: {}, medium: {}, holes: {holes} }}", closed(outline), medium(inside))
}

fn closed(of: &Loop) -> String {
    match of {
        Loop::Polygon(corners) => format!("Polygon({})", polyline(corners)),
        Loop::Circle { x_um, z_um, radius_um } => {
            format!("Circle {{ x_um: {x_um:?}, z_um: {z_um:?}, radius_um: {radius_um:?} }}")
        }
    }
}

fn polyline(Polyline { x_um, z_um }: &Polyline) -> String {
    format!("Polyline {{ x_um: {x_um:?}, z_um: {z_um:?} }}")
}

fn rod(Rod { x_um, z_um, rows, circles }: &Rod) -> String {
    let circles = list(circles.iter().map(|Circle { diameter_um, medium }| {
        format!("Circle {{ diameter_um: {diameter_um:?}, medium: {} }}", substance(medium))
    }));
    let rows = some(rows.map(|rows| rows.to_string()));
    format!("Rod {{ x_um: {x_um:?}, z_um: {z_um:?}, rows: {rows}, circles: {circles} }}")
}

fn complex(Complex64 { re, im }: &Complex64) -> String {
    format!("Complex {{ re: {re:?}, im: {im:?} }}")
}

fn some(text: Option<String>) -> String {
    text.map_or("None".to_owned(), |text| format!("Some({text})"))
}

fn list(texts: impl Iterator<Item = String>) -> String {
    format!("[{}]", texts.collect::<Vec<_>>().join(", "))
}

fn hash(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}
