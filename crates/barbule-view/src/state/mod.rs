//! What a viewer's window shows, without the window: what is open and what was moved in it, how it is looked at, what is pinned
//! beside it, and every change to be undone.

mod beside;
mod catalogue;
mod command;
mod export;
mod history;
mod picture;
mod saved;
mod slider;
mod species;
mod stack;
mod subject;
mod view;

use std::collections::BTreeMap;
use std::path::Path;

use barbule::error::shortened;
use barbule::fields::NumbersByName;
use barbule::io::read_text;
use barbule::open::{self, Opening};
use barbule::progress::Progress;
use barbule::scene::description::SceneDescription;
use barbule::scene::feather::{Feather, VaneDisc};
use barbule::structure::Structure;
use barbule::{Error, Result};

pub use beside::Beside;
pub use catalogue::{Entry, catalogue};
pub use command::{Command, Figure};
pub use export::Export;
pub use history::History;
pub use picture::{NamedStructure, NeededFile};
pub use saved::{FORMAT, Kept, Saved, named_from_anywhere};
pub use slider::{Slider, spoken};
pub use species::SpeciesSizes;
pub use stack::StackSizes;
pub use subject::{Grating, Subject, What};
pub use view::{Camera, Frame, Light, Mode, Seer, Shown, View};

use crate::scene::{Bend, SPHERE_MM};

/// Changes that can be undone.
const MOST_STEPS: usize = 200;
/// A picture of a ball or a vane is so much wider than it.
const ROOM: f64 = 1.3;
/// The width of a picture of the preset's snake, mm.
const SNAKE_MM: f64 = 120.0;

/// Everything that is undone together: what was moved and how it is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Sizes that were moved, by the keys of their sliders.
    pub moved: BTreeMap<String, f64>,
    /// How it is looked at.
    pub view: View,
}

/// What became of a file that was dropped onto the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dropped {
    /// It is open now, in place of what was.
    Opened,
    /// It is a measured spectrum, drawn beside what is computed.
    Measured,
}

/// A viewer without its window.
#[derive(Debug, Clone)]
pub struct State {
    subject: Subject,
    view: View,
    pinned: Option<Subject>,
    beside: Vec<Beside>,
    history: History<Setting>,
    opening: Opening,
}

impl State {
    /// Opens what people type, as [`Subject::open`] has it, or a saved viewer by its file; looked at from where it looks best.
    ///
    /// # Errors
    /// As [`Subject::open`] and [`Saved::parse`].
    pub fn open(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Self> {
        let path = Path::new(text);
        let is_toml = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
        if is_toml && !open::is_built_in(text) && path.is_file() {
            let file = read_text(path)?;
            if Saved::is_meant(&file) {
                let saved = Saved::parse(&file).map_err(|error| error.in_file(path))?;
                return Self::restored(&saved, opening, progress).map_err(|error| error.in_file(path));
            }
        }
        let subject = Subject::open(text, opening, progress)?;
        let view = first_view(&subject, opening, progress)?;
        Ok(Self::new(subject, view, opening))
    }

    fn new(subject: Subject, view: View, opening: &Opening) -> Self {
        let (history, opening) = (History::new(MOST_STEPS), opening.clone());
        Self { subject, view, pinned: None, beside: Vec::new(), history, opening }
    }

    /// A viewer as it was saved.
    ///
    /// # Errors
    /// What it names is not there, or its sizes do not fit.
    pub fn restored(saved: &Saved, opening: &Opening, progress: &dyn Progress) -> Result<Self> {
        let opened = |kept: &Kept| {
            let mut subject = Subject::open(&kept.open, opening, progress)?;
            subject.put(&kept.sizes.0).map_err(|error| error.at("sizes"))?;
            Ok::<_, Error>(subject)
        };
        let subject = opened(&saved.subject).map_err(|error| error.at("open"))?;
        let pinned = saved.pinned.as_ref().map(opened).transpose().map_err(|error| error.at("pinned"))?;
        check_mode(&subject, &saved.view)?;
        let beside = saved.measured.iter().map(|file| Beside::read(file)).collect::<Result<_>>();
        let beside = beside.map_err(|error| error.at("measured"))?;
        Ok(Self { pinned, beside, ..Self::new(subject, saved.view.clone(), opening) })
    }

    /// What a file keeps of it.
    #[must_use]
    pub fn saved(&self) -> Saved {
        let kept = |subject: &Subject| Kept {
            open: named_from_anywhere(subject.text()),
            sizes: NumbersByName(subject.moved()),
        };
        Saved {
            version: FORMAT,
            subject: kept(&self.subject),
            measured: self.beside.iter().map(|one| named_from_anywhere(one.file())).collect(),
            pinned: self.pinned.as_ref().map(kept),
            view: self.view.clone(),
        }
    }

    /// What is open.
    #[must_use]
    pub fn subject(&self) -> &Subject {
        &self.subject
    }

    /// How it is looked at.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// What is pinned beside it.
    #[must_use]
    pub fn pinned(&self) -> Option<&Subject> {
        self.pinned.as_ref()
    }

    /// Measured spectra that are drawn beside it.
    #[must_use]
    pub fn beside(&self) -> &[Beside] {
        &self.beside
    }

    /// Opens what people type in place of what is open, which keeps what is pinned and measured, unless it brings some of its own.
    ///
    /// # Errors
    /// As [`Self::open`]; then nothing has changed.
    pub fn open_instead(&mut self, text: &str, progress: &dyn Progress) -> Result<()> {
        let opened = Self::open(text, &self.opening, progress)?;
        let pinned = opened.pinned.clone().or_else(|| self.pinned.take());
        let mut beside = std::mem::take(&mut self.beside);
        if !opened.beside.is_empty() {
            beside.clone_from(&opened.beside);
        }
        *self = Self { pinned, beside, ..opened };
        Ok(())
    }

    /// Takes a file that was dropped onto the window: a measured spectrum is drawn beside what is computed, everything else is opened as
    /// by [`Self::open_instead`].
    ///
    /// # Errors
    /// It cannot be read as either, or there are as many measured spectra as can be told apart; then nothing has changed.
    pub fn drop_file(&mut self, path: &Path, progress: &dyn Progress) -> Result<Dropped> {
        let file = path.to_string_lossy();
        if !Beside::is_meant(path)? {
            return self.open_instead(&file, progress).map(|()| Dropped::Opened);
        }
        if self.beside.len() >= Beside::MOST {
            return Err(Error::input(format!(
                "{}: {} measured spectra are shown, as many as can be told apart; take one away",
                shortened(&file),
                Beside::MOST
            )));
        }
        self.beside.push(Beside::read(&file)?);
        Ok(Dropped::Measured)
    }

    /// Takes a measured spectrum away, by its place among them.
    pub fn take_away(&mut self, index: usize) {
        if index < self.beside.len() {
            self.beside.remove(index);
        }
    }

    /// The feather that it is shown on as a feather, and the part of that which is grown.
    ///
    /// # Errors
    /// Its scene shows no lone feather.
    pub fn feather(&self, progress: &dyn Progress) -> Result<(Feather, VaneDisc)> {
        let scene = scene_of(&self.subject, &self.view, &self.opening, progress)?;
        scene.lone_feather().map(|of| (of.feather, of.window)).ok_or_else(|| {
            Error::input(format!(
                "the scene of {} shows no feather by itself; choose a preset that does, as starling-feather",
                shortened(self.subject.text())
            ))
        })
    }

    /// Media, cache and seed.
    #[must_use]
    pub fn opening(&self) -> &Opening {
        &self.opening
    }

    fn setting(&self) -> Setting {
        Setting { moved: self.subject.moved(), view: self.view.clone() }
    }

    /// Moves one of the sliders. Moves of the same follow each other as one change until [`Self::settle`].
    ///
    /// # Errors
    /// As [`Subject::put`]; then nothing has changed.
    pub fn move_size(&mut self, key: &str, value: f64) -> Result<()> {
        let before = self.setting();
        let mut moved = before.moved.clone();
        moved.insert(key.to_owned(), value);
        self.subject.put(&moved)?;
        self.record(before, key);
        Ok(())
    }

    /// Puts all sizes back to what they were at first.
    ///
    /// # Errors
    /// None: what was open makes a structure.
    pub fn reset_sizes(&mut self) -> Result<()> {
        let before = self.setting();
        self.subject.put(&BTreeMap::new())?;
        self.record(before, "all sizes");
        self.settle();
        Ok(())
    }

    /// Changes how it is looked at; `what` is what people move, as `camera`, so that a drag is one change.
    ///
    /// # Errors
    /// What is open cannot be looked at so, or a number is out of its range; then nothing has changed.
    pub fn look(&mut self, what: &str, change: impl FnOnce(&mut View)) -> Result<()> {
        let mut view = self.view.clone();
        change(&mut view);
        check_mode(&self.subject, &view)?;
        barbule::fields::Record::check(&view, "")?;
        let before = self.setting();
        self.view = view;
        self.record(before, what);
        Ok(())
    }

    /// Another mode, from where it looks best there.
    ///
    /// # Errors
    /// As [`Self::look`].
    pub fn choose(&mut self, mode: Mode, progress: &dyn Progress) -> Result<()> {
        let camera = first_camera(&self.subject, mode, &self.view, &self.opening, progress)?;
        self.look("mode", |view| (view.mode, view.camera) = (mode, camera))?;
        self.settle();
        Ok(())
    }

    fn record(&mut self, before: Setting, what: &str) {
        if before != self.setting() {
            self.history.record(before, what);
        }
    }

    /// The hand lets go: the next change is another one.
    pub fn settle(&mut self) {
        self.history.settle();
    }

    /// Undoes the last change. Whether there was one.
    ///
    /// # Errors
    /// None: what was before was possible.
    pub fn undo(&mut self) -> Result<bool> {
        let now = self.setting();
        let before = self.history.undo(now);
        self.put(before)
    }

    /// Does again what was undone last. Whether there was something.
    ///
    /// # Errors
    /// None: what was before was possible.
    pub fn redo(&mut self) -> Result<bool> {
        let now = self.setting();
        let after = self.history.redo(now);
        self.put(after)
    }

    fn put(&mut self, setting: Option<Setting>) -> Result<bool> {
        let Some(Setting { moved, view }) = setting else { return Ok(false) };
        self.subject.put(&moved)?;
        self.view = view;
        Ok(true)
    }

    /// How many changes can be undone, and redone.
    #[must_use]
    pub fn steps(&self) -> [usize; 2] {
        self.history.steps()
    }

    /// Pins what is open, as it is, to be compared with.
    pub fn pin(&mut self) {
        self.pinned = Some(self.subject.clone());
    }

    /// Takes what is pinned away.
    pub fn unpin(&mut self) {
        self.pinned = None;
    }

    /// What is pinned is open, and what was open is pinned. Whether something was pinned; what could be undone is gone then.
    ///
    /// # Errors
    /// It cannot be looked at as what is open is, nor from where it looks best.
    pub fn swap(&mut self, progress: &dyn Progress) -> Result<bool> {
        let Some(pinned) = self.pinned.clone() else { return Ok(false) };
        let view = match check_mode(&pinned, &self.view) {
            Ok(()) => self.view.clone(),
            Err(_) => first_view(&pinned, &self.opening, progress)?,
        };
        self.pinned = Some(std::mem::replace(&mut self.subject, pinned));
        self.view = view;
        self.history = History::new(MOST_STEPS);
        Ok(true)
    }

    /// Sizes of what is open that differ from those of what is pinned, where both have them: the slider, and the pinned value.
    #[must_use]
    pub fn differences(&self) -> Vec<(Slider, f64)> {
        let pinned: BTreeMap<String, f64> =
            self.pinned.iter().flat_map(Subject::sliders).map(|s| (s.key, s.value)).collect();
        let own = self.subject.sliders().into_iter();
        own.filter_map(|slider| {
            let other = *pinned.get(&slider.key)?;
            (other != slider.value).then_some((slider, other))
        })
        .collect()
    }

    /// The structure as it is; none of gratings, scenes and materials that record none.
    ///
    /// # Errors
    /// As [`Subject::structure`].
    pub fn structure(&self) -> Result<Option<Structure>> {
        self.subject.structure()
    }

    /// The scene that shows it, for the renderer, and the files that it names.
    ///
    /// # Errors
    /// As [`Subject::scene`].
    pub fn scene(&self, progress: &dyn Progress) -> Result<(SceneDescription, Vec<NeededFile>)> {
        self.subject.scene(&self.view, &self.opening, progress)
    }

    /// The command that draws what the window shows.
    ///
    /// # Errors
    /// As [`Command::picture`].
    pub fn picture_command(&self, size: [u32; 2], progress: &dyn Progress) -> Result<Command> {
        Command::picture(&self.subject, &self.view, size, &self.opening, progress)
    }

    /// The command that makes a figure of it.
    ///
    /// # Errors
    /// As [`Command::figure`].
    pub fn figure_command(&self, figure: Figure, file: &str) -> Result<Command> {
        Command::figure(&self.subject, &self.view, figure, file)
    }

    /// The text of a file of it that is text: scene, species or state.
    ///
    /// # Errors
    /// It has none of this kind, or the format cannot write it.
    pub fn text_of(&self, export: Export, progress: &dyn Progress) -> Result<String> {
        match (export, self.subject.what()) {
            (Export::Scene, _) => self.scene(progress)?.0.to_toml(),
            (Export::State, _) => self.saved().to_toml(),
            (Export::Species, What::Species(sizes) | What::Material(_, Some(sizes))) => sizes.file_text(),
            _ => Err(Error::input(format!(
                "of a {} no {} are written as text",
                self.subject.kind(),
                export.name()
            ))),
        }
    }
}

fn check_mode(subject: &Subject, view: &View) -> Result<()> {
    let modes = subject.modes();
    if modes.contains(&view.mode) {
        return Ok(());
    }
    let known: Vec<&str> = modes.iter().map(|mode| mode.word()).collect();
    Err(Error::input(format!(
        "view.mode is {}, but a {} is shown as {}; choose one of them",
        view.mode.word(),
        subject.kind(),
        known.join(", ")
    )))
}

/// How something is looked at first: as a feather where it can be, else as its first mode, in the light of its scene.
fn first_view(subject: &Subject, opening: &Opening, progress: &dyn Progress) -> Result<View> {
    let modes = subject.modes();
    let mode = if modes.contains(&Mode::Feather) { Mode::Feather } else { modes[0] };
    let mut view = View { mode, ..View::default() };
    if matches!(mode, Mode::Feather | Mode::Scene) {
        let scene = scene_of(subject, &view, opening, progress)?;
        let bearing = scene.light.bearing;
        (view.light.azimuth_deg, view.light.elevation_deg) = (bearing.azimuth_deg, bearing.elevation_deg);
        view.light.radius_deg = scene.light.radius_deg;
        if scene.light.strength > 0.0 {
            view.light.strength = scene.light.strength.min(100.0);
        }
    }
    view.camera = first_camera(subject, mode, &view, opening, progress)?;
    Ok(view)
}

/// From where something is looked at first in a mode.
fn first_camera(
    subject: &Subject,
    mode: Mode,
    view: &View,
    opening: &Opening,
    progress: &dyn Progress,
) -> Result<Camera> {
    let usual = Camera::usual();
    Ok(match mode {
        Mode::Sphere => Camera { width_mm: 2.0 * ROOM * SPHERE_MM, elevation_deg: 20.0, ..usual },
        Mode::Vane => Camera { width_mm: ROOM * Bend::USUAL.size_mm[0], elevation_deg: 70.0, ..usual },
        Mode::Snake => {
            Camera { width_mm: SNAKE_MM, elevation_deg: 42.0, target_mm: [0.0, 0.0, 14.0], ..usual }
        }
        Mode::Feather | Mode::Scene => {
            let scene = scene_of(subject, view, opening, progress)?;
            Camera {
                azimuth_deg: scene.camera.bearing.azimuth_deg,
                elevation_deg: scene.camera.bearing.elevation_deg,
                width_mm: scene.camera.width_mm,
                target_mm: scene.camera.target,
            }
        }
    })
}

/// The scene that suits something, as it is: its preset's or the view's.
fn scene_of(
    subject: &Subject,
    view: &View,
    opening: &Opening,
    progress: &dyn Progress,
) -> Result<SceneDescription> {
    match (&view.preset, subject.what()) {
        (Some(preset), _) => SceneDescription::named(preset).map_err(|error| error.at("preset")),
        (None, What::Scene(scene)) => Ok(scene.as_ref().clone()),
        (None, What::Grating(_)) => SceneDescription::named("snake"),
        (None, _) => open::description(subject.text(), opening, progress),
    }
}

#[cfg(test)]
mod tests;
