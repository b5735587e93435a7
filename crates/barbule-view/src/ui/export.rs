//! Writing what is seen: pictures, tables, figures, scenes, species and the viewer itself, and commands that make the same.
//!
//! A small window asks for the file's name. Files lie in the working folder unless the name says otherwise; none that was read is
//! written over.

use std::path::{Path, PathBuf};

use barbule::Unobserved;
use barbule::error::shortened;
use barbule::io::image::write_png;
use barbule::io::{read_own, write_together, write_whole};
use barbule::plot::{self, Band, Format, MeasuredBand, Page};
use barbule::spectrum::Spectrum;
use eframe::egui::{self, Context, Key};

use crate::live::{Curves, Known, Results};
use crate::state::{Command, Export, NeededFile, State, Subject};
use crate::{Error, Result};

/// Names that are tried with a number behind them before an older file is written over.
const MOST_NAMES: usize = 1000;
/// A figure's size, px of 1/96 inch.
const FIGURE_PX: [f64; 2] = [720.0, 480.0];

/// The little window that asks for a name.
#[derive(Debug)]
pub(super) struct Asking {
    /// What is to be written.
    pub export: Export,
    /// The name, as it is typed.
    pub name: String,
    /// Whether the box was given the cursor.
    has_focus: bool,
}

/// What became of the little window.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// It is open still.
    Waits,
    /// Nothing is to be written.
    Leaves,
    /// The file is to be written.
    Writes,
}

impl Asking {
    /// Asks for the name of a file of something, which is usually free in a folder.
    pub(super) fn new(export: Export, subject: &Subject, folder: &Path) -> Self {
        Self { export, name: free_name(folder, &export.file_name(subject)), has_focus: false }
    }

    /// Where the file lies.
    pub(super) fn path(&self, folder: &Path) -> PathBuf {
        folder.join(self.name.trim())
    }

    /// Draws the window.
    pub(super) fn show(&mut self, ctx: &Context, folder: &Path) -> Answer {
        let mut is_open = true;
        let mut answer = Answer::Waits;
        let title = format!("Write {}", self.export.name());
        egui::Window::new(title)
            .open(&mut is_open)
            .collapsible(false)
            .resizable(false)
            .default_width(360.0)
            .show(ctx, |ui| {
                let label = ui.label("Name of the file");
                let text = egui::TextEdit::singleline(&mut self.name).desired_width(320.0).char_limit(1000);
                let typed = ui.add(text).labelled_by(label.id);
                if !self.has_focus {
                    typed.request_focus();
                    self.has_focus = true;
                }
                let path = self.path(folder);
                let refused = self.export.check(&path).err().map(|error| error.to_string());
                match &refused {
                    Some(words) => ui.colored_label(super::look::WRONG, words),
                    None if path.exists() => ui.label("There is a file of this name; it is replaced."),
                    None => ui.weak(format!("in {}", shortened(&whole(folder).display().to_string()))),
                };
                ui.horizontal(|ui| {
                    let is_entered = typed.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                    let write = ui.add_enabled(refused.is_none(), egui::Button::new("Write"));
                    if refused.is_none() && (write.clicked() || is_entered) {
                        answer = Answer::Writes;
                    }
                    if ui.button("Cancel").clicked() {
                        answer = Answer::Leaves;
                    }
                });
            });
        if is_open { answer } else { Answer::Leaves }
    }
}

/// A folder by its whole path, where that is known.
fn whole(folder: &Path) -> PathBuf {
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned())
}

/// A name that no file of a folder has: the usual one, or with a number before its ending.
fn free_name(folder: &Path, name: &str) -> String {
    let (stem, end) = name.rsplit_once('.').unwrap_or((name, ""));
    let numbered = (2..MOST_NAMES).map(|number| format!("{stem}-{number}.{end}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    names.find(|name| !folder.join(name).exists()).unwrap_or_else(|| name.to_owned())
}

/// Pixels of a picture. Shape of the bytes: `[row, column, channel]`, sRGB.
#[derive(Debug, Clone)]
pub(super) struct Pixels {
    /// Columns and rows.
    pub size: [u32; 2],
    /// The bytes.
    pub bytes: Vec<u8>,
    /// Whether there are four channels, the last of them how much is covered.
    pub has_alpha: bool,
}

/// Writes the picture.
///
/// # Errors
/// The file cannot be written.
pub(super) fn write_picture(path: &Path, state: &State, pixels: &Pixels) -> Result<()> {
    let command = state.picture_command(pixels.size, &Unobserved).map(|command| command.line());
    let command = command.unwrap_or_default();
    let facts = [("Title", state.subject().title()), ("Comment", command)];
    let facts: Vec<(&str, &str)> = facts.iter().map(|(name, text)| (*name, text.as_str())).collect();
    write_png(path, pixels.size, &pixels.bytes, pixels.has_alpha, &facts)
}

/// Writes everything that is not the picture.
///
/// # Errors
/// It is not computed yet, there is none of this kind, or the file cannot be written.
pub(super) fn write(path: &Path, export: Export, state: &State, results: &Results) -> Result<()> {
    match export {
        Export::Picture => Err(Error::machine("pictures are written from their pixels")),
        Export::Table => write_whole(path, curves(&results.own)?.csv().as_bytes()),
        Export::Figure => {
            let drawing = figure(state, results)?;
            let bytes = drawing.encode(Format::of(path)?, &[("Title", &state.subject().title())])?;
            write_whole(path, &bytes)
        }
        Export::Scene => {
            let (scene, files) = state.scene(&Unobserved)?;
            let folder = path.parent().unwrap_or(Path::new(""));
            refuse_others(folder, &files)?;
            let scene = scene.to_toml()?;
            let beside: Vec<PathBuf> = files.iter().map(|file| folder.join(&file.name)).collect();
            let mut all = vec![(path, scene.as_bytes())];
            all.extend(beside.iter().zip(&files).map(|(path, file)| (path.as_path(), file.text.as_bytes())));
            write_together(&all)
        }
        Export::Species | Export::State => write_whole(path, state.text_of(export, &Unobserved)?.as_bytes()),
    }
}

fn curves(of: &Known) -> Result<&Curves> {
    of.curves.as_ref().ok_or_else(|| Error::input("the spectrum is not computed yet; wait until it is drawn"))
}

/// Reflectance at the view's angle with what is pinned and measured, drawn as `barbule spectrum` does.
fn figure(state: &State, results: &Results) -> Result<plot::Drawing> {
    let angle = state.view().angle_deg;
    let mut bands = vec![band(state.subject().title(), curves(&results.own)?, angle)?];
    if let (Some(pinned), Some(curves)) = (state.pinned(), &results.pinned.curves) {
        bands.push(band(format!("{} (pinned)", pinned.title()), curves, angle)?);
    }
    let measured = state.beside().iter().map(|beside| {
        let found = beside.measured();
        let band = Band { name: beside.name(), mean: found.mean.clone(), std: found.std.clone(), peak: None };
        MeasuredBand { band, samples: Vec::new(), beside: None }
    });
    let measured: Vec<MeasuredBand> = measured.collect();
    let title = format!("{}, light from {angle}°", state.subject().title());
    Ok(plot::spectra(&title, &bands, &measured).draw_on(&Page::sized(FIGURE_PX[0], FIGURE_PX[1])))
}

/// The curve of curves that is nearest to an angle.
fn band(name: String, curves: &Curves, angle_deg: f64) -> Result<Band> {
    let wanted = angle_deg.to_radians();
    // Flat layers reflect the same from either side.
    let off = |angle: f64| (angle - wanted).abs().min((angle + wanted).abs() + 1e-9);
    let row = (0..curves.angle.len()).min_by(|a, b| off(curves.angle[*a]).total_cmp(&off(curves.angle[*b])));
    let row = row.unwrap_or_default();
    let mean: Spectrum = curves.spectrum(row)?;
    let columns = curves.at.len();
    let std = curves.std.as_ref().and_then(|all| all.get(row * columns..(row + 1) * columns));
    Ok(Band { name, mean, std: std.map(<[f64]>::to_vec), peak: None })
}

/// Writes the files that a command reads beside where it is run.
///
/// # Errors
/// Another file of one of their names is there.
pub(super) fn write_needed(command: &Command, folder: &Path) -> Result<()> {
    refuse_others(folder, &command.files)?;
    let paths: Vec<PathBuf> = command.files.iter().map(|file| folder.join(&file.name)).collect();
    let is_missing = |path: &&PathBuf| !path.exists();
    let files: Vec<(&Path, &[u8])> = paths
        .iter()
        .zip(&command.files)
        .filter(|(path, _)| is_missing(path))
        .map(|(path, file)| (path.as_path(), file.text.as_bytes()))
        .collect();
    write_together(&files)
}

/// Refuses files whose names others have that hold something else.
fn refuse_others(folder: &Path, files: &[NeededFile]) -> Result<()> {
    for file in files {
        let path = folder.join(&file.name);
        let is_other = |bytes: Vec<u8>| bytes != file.text.as_bytes();
        let is_taken = path.exists() && read_own(&path, file.text.len() as u64).map_or(true, is_other);
        if is_taken {
            return Err(Error::input(format!(
                "{} is there already and holds something else; move it away, or work in another folder",
                shortened(&path.display().to_string())
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::open::Opening;
    use barbule::spectrum::Wavelengths;

    fn opened(text: &str) -> State {
        State::open(text, &Opening::default(), &Unobserved).unwrap()
    }

    fn results() -> Results {
        let at = Wavelengths::new([400.0, 500.0, 600.0]).unwrap();
        let reflected = vec![0.1, 0.2, 0.3, 0.3, 0.2, 0.1];
        let curves = Curves::new(at, vec![0.0, 0.5], reflected, None).unwrap();
        Results { own: Known { curves: Some(curves), ..Known::default() }, pinned: Known::default() }
    }

    #[test]
    fn usual_names_are_free() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(free_name(folder.path(), "a.png"), "a.png");
        std::fs::write(folder.path().join("a.png"), "").unwrap();
        std::fs::write(folder.path().join("a-2.png"), "").unwrap();
        assert_eq!(free_name(folder.path(), "a.png"), "a-3.png");
    }

    #[test]
    fn each_kind_of_file_is_written_as_what_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let mut state = opened("starling:pink");
        state.move_size("cortex_um", 0.2).unwrap();
        let written = |export: Export, name: &str| {
            let path = folder.path().join(name);
            write(&path, export, &state, &results()).map(|()| std::fs::read(&path).unwrap())
        };
        assert!(
            written(Export::Table, "a.csv").unwrap().starts_with(b"angle_deg,wavelength_nm,mean\n0,400,0.1")
        );
        assert!(written(Export::Figure, "a.svg").unwrap().starts_with(b"<"));
        assert!(written(Export::Figure, "a.pdf").unwrap().starts_with(b"%PDF"));
        assert!(
            String::from_utf8(written(Export::Species, "s.toml").unwrap())
                .unwrap()
                .contains("cortex_um = 0.2")
        );
        let again = written(Export::State, "view.toml").unwrap();
        assert!(String::from_utf8(again).unwrap().contains("barbule_view = 1"));
        // A scene brings the species that it names.
        written(Export::Scene, "scene.toml").unwrap();
        assert!(folder.path().join("my-starling.toml").exists());
        let pixels = Pixels { size: [2, 1], bytes: vec![9; 6], has_alpha: false };
        let picture = folder.path().join("p.png");
        write_picture(&picture, &state, &pixels).unwrap();
        assert!(std::fs::read(picture).unwrap().starts_with(b"\x89PNG"));
        let refused = write(&folder.path().join("b.csv"), Export::Table, &state, &Results::default());
        assert!(refused.unwrap_err().to_string().contains("is not computed yet"));
    }

    #[test]
    fn files_of_commands_never_take_the_place_of_others() {
        let folder = tempfile::tempdir().unwrap();
        let state = opened("air/keratin:300/melanin");
        let command = state.picture_command([64, 48], &Unobserved).unwrap();
        write_needed(&command, folder.path()).unwrap();
        // The same once more is nothing else.
        write_needed(&command, folder.path()).unwrap();
        std::fs::write(folder.path().join("scene.toml"), "preset = 'magpie'").unwrap();
        let refused = write_needed(&command, folder.path()).unwrap_err().to_string();
        assert!(refused.contains("scene.toml is there already and holds something else"), "{refused}");
    }
}
