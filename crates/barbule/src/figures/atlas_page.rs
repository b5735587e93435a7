//! An atlas as a page that a browser opens from a folder: maps, the spectrum of the place that is touched, and a file of each
//! structure. Nothing in it comes from elsewhere.

use std::path::Path;

use serde_json::{Value, json};

use super::atlas::{AtlasColours, Panel, atlas_map, panels};
use crate::atlas::Atlas;
use crate::io::sweep::SweepStore;
use crate::io::{claim_output, is_inside_store, make_folder, read_own, write_whole};
use crate::plot::{Format, Page};
use crate::spectrum::look::hex;
use crate::{Error, Result};

/// The page but for its words and numbers.
const TEMPLATE: &str = include_str!("atlas_page.html");

/// Structures and numbers of spectra on one page, at most: they are in its text.
const MOST_CELLS: usize = 20_000;
const MOST_NUMBERS: usize = 10_000_000;

/// What a page says of itself; others are not written over.
const GENERATOR: &[u8] = b"<meta name=\"generator\" content=\"barbule atlas\">";

/// The bytes at the beginning of a page among which it says so.
const GENERATOR_WITHIN: usize = 500;

/// The page, and its figure.
const INDEX: &str = "index.html";
const MAP: &str = "map.svg";

/// The largest page that is looked at, 1 GiB.
const MOST_PAGE: u64 = 1 << 30;

/// The folder of the structures' files.
const STRUCTURES: &str = "structures";

/// Reflectances on the page are whole numbers of this part.
const PART: f64 = 1e-4;

/// The files of a page by their paths in its folder: `index.html`, `map.svg` with `notes` inside, and `structures/N.toml` of each cell.
///
/// # Errors
/// The atlas has no colours, nothing is in its store yet, or it has more cells than a page holds.
pub fn atlas_page(
    atlas: &Atlas,
    store: &SweepStore,
    notes: &[(&str, &str)],
) -> Result<Vec<(String, Vec<u8>)>> {
    check_size(atlas)?;
    let colours = AtlasColours::read(atlas, store)?;
    let there = colours.of.iter().flatten().count();
    if there == 0 {
        return Err(Error::input("nothing is in the store yet; compute some of it first"));
    }
    let (means, stds) = (store.numbers("mean")?, store.numbers("std")?);
    let cells: Vec<Value> = (0..atlas.cells())
        .map(|cell| of_cell(atlas, &colours, cell, means[cell].as_deref(), stds[cell].as_deref()))
        .collect();
    let panels: Vec<Value> = panels(atlas).iter().map(of_panel).collect();
    let data = json!({
        "nm": atlas.wavelengths().nm(),
        "angles": atlas.angles_deg(),
        "cells": cells,
        "panels": panels,
    });
    let about = format!("{there} of {} structures.", atlas.cells());
    let index = TEMPLATE
        .replace("@TITLE@", &escaped(atlas.name()))
        .replace("@ABOUT@", &about)
        // A closing tag in a text would end the script.
        .replace("@DATA@", &data.to_string().replace("</", "<\\/"));
    let map = atlas_map(atlas.name(), atlas, &colours, &Page::default())?.encode(Format::Svg, notes)?;
    let mut files = vec![(INDEX.to_owned(), index.into_bytes()), (MAP.to_owned(), map)];
    for cell in (0..atlas.cells()).filter(|cell| colours.of[*cell].is_some()) {
        files.push((structure_file(cell), atlas.toml(cell)?.into_bytes()));
    }
    Ok(files)
}

/// Refuses an atlas that no page holds, or that has no colours.
fn check_size(atlas: &Atlas) -> Result<()> {
    let curve = atlas.angles_deg().len() * atlas.wavelengths().len();
    if atlas.cells() > MOST_CELLS || atlas.cells() * curve > MOST_NUMBERS {
        return Err(Error::input(format!(
            "a page holds up to {MOST_CELLS} structures and {MOST_NUMBERS} reflectances, but the atlas has {} and {}; open the store by xarray instead",
            atlas.cells(),
            atlas.cells() * curve
        )));
    }
    AtlasColours::check(atlas)
}

/// Says before any work what the folder of an atlas' page will hold.
///
/// # Errors
/// A file is there in the folder's place, the folder is a store or inside one or has another page, or an input lies where the page would be written; an atlas that no page holds.
pub fn claim_atlas_page(folder: &Path, atlas: &Atlas) -> Result<()> {
    check_size(atlas)?;
    let refuse = |what: &str| Err(Error::input(what).in_file(folder));
    if folder.is_file() {
        return refuse("is a file; give a folder");
    }
    let around = [Some(folder), folder.parent()].into_iter().flatten();
    let is_store = |path: &Path| path.join("zarr.json").is_file() || is_inside_store(path);
    if around.filter(|path| !path.as_os_str().is_empty()).any(is_store) {
        return refuse("lies inside a campaign store; give a name elsewhere");
    }
    let files = [INDEX.to_owned(), MAP.to_owned()].into_iter();
    files.chain((0..atlas.cells()).map(structure_file)).try_for_each(|name| {
        let path = folder.join(name);
        claim_output(&path, &path.display().to_string())
    })?;
    let index = folder.join(INDEX);
    if index.exists() {
        let page = read_own(&index, MOST_PAGE).unwrap_or_default();
        if !page.windows(GENERATOR.len()).take(GENERATOR_WITHIN).any(|part| part == GENERATOR) {
            return refuse("has an index.html that is not the page of an atlas; give another folder");
        }
    }
    Ok(())
}

/// Writes the files of [`atlas_page`] into a folder, the page itself last, when all that it names is there.
///
/// # Errors
/// The folder cannot be made, or a file not be written.
pub fn write_atlas_page(folder: &Path, files: &[(String, Vec<u8>)]) -> Result<()> {
    make_folder(&folder.join(STRUCTURES))?;
    files.iter().rev().try_for_each(|(name, bytes)| write_whole(&folder.join(name), bytes))
}

/// The file of a cell's structure.
fn structure_file(cell: usize) -> String {
    format!("{STRUCTURES}/{cell:06}.toml")
}

/// A cell: its words, and of each angle colour, mean and spread.
fn of_cell(
    atlas: &Atlas,
    colours: &AtlasColours,
    cell: usize,
    mean: Option<&[f64]>,
    std: Option<&[f64]>,
) -> Value {
    let (Some(Some(own)), Some(mean), Some(std)) = (colours.of.get(cell), mean, std) else {
        return Value::Null;
    };
    let count = atlas.wavelengths().len();
    let whole = |values: &[f64]| -> Vec<Vec<i64>> {
        values.chunks(count).map(|row| row.iter().map(|v| (v / PART).round() as i64).collect()).collect()
    };
    let hexes: Vec<String> = own.iter().map(|colour| hex(*colour)).collect();
    json!({"w": atlas.words(cell), "c": hexes, "m": whole(mean), "s": whole(std)})
}

fn of_panel(panel: &Panel) -> Value {
    json!({
        "title": panel.title,
        "xLabel": panel.x.label,
        "yLabel": panel.y.label,
        "x": panel.x.range,
        "y": panel.y.range,
        "columns": panel.x.at.len(),
        "cells": panel.cells,
    })
}

/// A text for the page.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unobserved;
    use crate::atlas::{Plan, run};
    use crate::math::simd::Width;
    use crate::open::Opening;
    use crate::progress::Shard;

    #[test]
    fn a_page_has_its_maps_its_spectra_and_a_file_of_each_structure() {
        let text = "barbule = 1
name = '</script><b>'
structure = 'air/keratin:300/melanin:300/air'
wavelengths_nm = '400:700:50'
individuals = 1
[[vary]]
key = 'layer1'
values = '200:300:50'
[[vary]]
key = 'layer2'
values = [200, 300, 500]
";
        let folder = tempfile::tempdir().unwrap();
        let plan = Plan::parse(text).unwrap();
        let atlas =
            Atlas::new(&plan, Path::new("."), &Opening::default(), Width::best(), &Unobserved).unwrap();
        let store = atlas.create(&folder.path().join("s.zarr")).unwrap();
        assert!(
            atlas_page(&atlas, &store, &[]).unwrap_err().to_string().contains("nothing is in the store yet")
        );
        run(&atlas, &store, &atlas.units(Shard::WHOLE), &Unobserved).unwrap();
        let files = atlas_page(&atlas, &store, &[]).unwrap();
        assert_eq!(files.len(), 2 + 9);
        let index = String::from_utf8(files[0].1.clone()).unwrap();
        assert_eq!(index.matches("</script>").count(), 1);
        assert!(index.as_bytes()[..GENERATOR_WITHIN].windows(GENERATOR.len()).any(|part| part == GENERATOR));
        assert!(index.contains("&lt;/script&gt;&lt;b&gt;") && !index.contains("http"), "{index}");
        let svg = String::from_utf8(files[1].1.clone()).unwrap();
        assert!(svg.contains("layer1 (nm)") && svg.contains("layer2 (nm)"), "{svg}");
        let (name, toml) = &files[10];
        assert_eq!(name, "structures/000008.toml");
        assert_eq!(std::str::from_utf8(toml).unwrap(), "stack = \"air/keratin:300/melanin:500/air\"\n");
    }
}
