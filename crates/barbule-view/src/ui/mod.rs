//! The window: [`App`] holds the state, the results and the workers, draws everything, and alone changes anything.
//!
//! ```text
//! keys, bar, picture, panes ──► Action ──► App ──► State ──► live::Desk ──► Results ──► panes
//!                                                                 └───────► Show ─────► stage
//! ```

mod action;
mod bar;
mod export;
mod gizmos;
mod help;
mod keys;
pub mod look;
pub mod panes;
mod picture;
mod saving;
mod status;
mod traced;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use barbule::Unobserved;
use barbule::error::shortened;
use eframe::egui::{self, CentralPanel, CollapsingHeader, Context, Frame, Margin, Panel, ScrollArea, Ui};

pub use action::Action;
pub use saving::{Saving, lost, restored, usual_file, usual_folder};

use crate::gpu::Gpu;
use crate::live::{Desk, Effort, News, Results};
use crate::state::{Command, Dropped, Mode, State, catalogue};
use crate::{Error, Result, show};
use bar::{Asked, Finder};
use export::{Answer, Asking, Pixels};
use keys::Wish;
use status::{Frames, Line, Message};

/// Widths of the panel of sliders, points: usual, least and most.
const LEFT: [f32; 3] = [260.0, 190.0, 420.0];
/// Widths of the panel of linked views.
const RIGHT: [f32; 3] = [360.0, 260.0, 640.0];
/// Progress is drawn anew after so long, s.
const PROGRESS_S: f32 = 0.1;
/// Pixels of the picture of a command where none is drawn.
const USUAL_PX: [u32; 2] = [1024, 1024];

/// What a window begins with.
pub struct Start {
    /// What is open.
    pub state: State,
    /// The folder in which files are written.
    pub folder: PathBuf,
    /// Where the state is kept when the window closes.
    pub saving: Option<Saving>,
    /// What is said first, as that a saved state was damaged.
    pub words: Option<String>,
    /// How much is computed.
    pub effort: Effort,
}

/// A window's adapter, and the format of its pixels.
#[derive(Debug, Clone)]
pub struct Adapter {
    /// The adapter.
    pub gpu: Gpu,
    /// The format of the window's pixels.
    pub format: wgpu::TextureFormat,
}

/// The viewer with its window.
pub struct App {
    state: State,
    results: Results,
    desk: Desk,
    effort: Effort,
    /// What draws the picture in real time, or why nothing does.
    stage: std::result::Result<picture::Shared, String>,
    adapter: String,
    picture: picture::Memory,
    traced: traced::Traced,
    panes: panes::Memory,
    finder: Finder,
    asking: Option<Asking>,
    message: Option<Message>,
    has_help: bool,
    frames: Frames,
    folder: PathBuf,
    saving: Option<Saving>,
    title: String,
}

impl App {
    /// A viewer in a window; without an adapter everything but the picture works.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn new(ctx: &Context, adapter: Option<Adapter>, start: Start) -> Result<Self> {
        look::apply(ctx);
        let own = ctx.clone();
        let desk = Desk::new(move || own.request_repaint())?;
        let (name, stage) = match adapter {
            None => {
                let why = "No graphics adapter is there to draw the picture; install the driver of the graphics card, or one in software (mesa-vulkan-drivers on Debian and Ubuntu).";
                ("no graphics adapter".to_owned(), Err(why.to_owned()))
            }
            Some(Adapter { gpu, format }) => {
                (gpu.to_string(), picture::Shared::new(gpu, format).map_err(|error| error.to_string()))
            }
        };
        let effort = Effort { draws: stage.is_ok(), ..start.effort };
        Ok(Self {
            state: start.state,
            results: Results::default(),
            desk,
            effort,
            stage,
            adapter: name,
            picture: picture::Memory::default(),
            traced: traced::Traced::default(),
            panes: panes::Memory::default(),
            finder: Finder::new(catalogue()?),
            asking: None,
            message: start.words.map(|words| Message { words, is_wrong: true }),
            has_help: false,
            frames: Frames::default(),
            folder: start.folder,
            saving: start.saving,
            title: String::new(),
        })
    }

    /// What is open, and how it is looked at.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What has been computed.
    #[must_use]
    pub fn results(&self) -> &Results {
        &self.results
    }

    /// Whether something is computed, samples of the traced picture among it.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.desk.is_busy() || self.traced.is_busy()
    }

    /// What the window says at its bottom.
    #[must_use]
    pub fn words(&self) -> Option<&str> {
        self.message.as_ref().map(|message| message.words.as_str())
    }

    /// Draws a frame of the window, and does what was asked for in it.
    pub fn draw(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.frames.note(ctx.input(|input| input.time));
        self.follow();
        let mut actions = Vec::new();
        self.take_files(&ctx);
        let wishes = keys::pressed(&ctx, &self.state);
        let mut asked: Vec<Asked> = wishes.into_iter().map(Asked::Wish).collect();
        asked.extend(self.panels(ui, &mut actions));
        self.windows(&ctx);
        for asked in asked {
            match asked {
                Asked::Wish(Wish::Do(action)) => {
                    actions.push(action);
                    // A key that is pressed is one change.
                    actions.push(Action::Settle);
                }
                Asked::Wish(Wish::Help) => self.has_help = !self.has_help,
                Asked::Wish(Wish::Find) => self.finder.focus(),
                Asked::Wish(Wish::Leave) => self.leave(&mut actions),
                Asked::Wish(Wish::Nothing) => {}
                Asked::FigureCommand(figure) => {
                    let file = format!("{}.svg", figure.stem());
                    let command = self.state.figure_command(figure, &file);
                    let copied = command.and_then(|command| self.copy(&ctx, &command));
                    self.tell(copied);
                }
            }
        }
        if !actions.is_empty() {
            for action in actions {
                let done = self.apply(&ctx, action);
                self.tell(done);
            }
            self.follow();
            ctx.request_repaint();
        }
        self.entitle(&ctx);
        if self.desk.is_busy() {
            ctx.request_repaint_after_secs(PROGRESS_S);
        }
    }

    /// Everything around the picture, and the picture.
    fn panels(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) -> Vec<Asked> {
        let now = ui.input(|input| input.time);
        let bar = Panel::top("bar").show(ui, |ui| bar::bar(ui, &self.state, &mut self.finder, actions));
        Panel::bottom("status").show(ui, |ui| {
            let line = Line {
                busy: self.desk.busy(now),
                of: &self.results.own,
                adapter: &self.adapter,
                bytes: self.stage.as_ref().ok().map(picture::Shared::bytes),
                rate: self.frames.rate(),
            };
            status::status(ui, &line, &mut self.message, actions);
        });
        let [usual, least, most] = LEFT;
        Panel::left("sizes").default_size(usual).size_range(least..=most).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                ui.heading(self.state.subject().title());
                ui.weak(self.state.subject().kind());
                panes::sliders(ui, &self.state, &self.results, &mut self.panes, actions);
            });
        });
        let [usual, least, most] = RIGHT;
        Panel::right("views").default_size(usual).size_range(least..=most).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.views(ui, actions));
        });
        let frame = Frame::new().fill(look::BEHIND).inner_margin(Margin::ZERO);
        CentralPanel::default().frame(frame).show(ui, |ui| self.middle(ui, actions));
        bar.inner
    }

    /// The linked views, one under the other.
    fn views(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        type Pane = fn(&mut Ui, &State, &Results, &mut panes::Memory, &mut Vec<Action>);
        let is_pinned = self.state.pinned().is_some();
        let all: [(&str, Pane, bool); 5] = [
            ("Open against pinned", panes::comparison, is_pinned),
            ("Reflectance", panes::spectrum, true),
            ("Colour against angle", panes::angles, true),
            ("Lobe", panes::lobe, true),
            ("Section", panes::section, true),
        ];
        for (title, pane, is_there) in all {
            if is_there {
                CollapsingHeader::new(title).default_open(true).show_unindented(ui, |ui| {
                    pane(ui, &self.state, &self.results, &mut self.panes, actions);
                });
                ui.separator();
            }
        }
    }

    /// The picture.
    fn middle(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        if self.state.view().mode == Mode::Scene {
            traced::traced(ui, &self.state, &mut self.traced, actions);
            return;
        }
        // Nobody sees its samples here.
        self.traced.stop();
        picture::picture(ui, &self.state, &self.stage, &mut self.picture, actions);
        let Some(rect) = self.picture.rect else { return };
        if self.stage.is_ok() {
            gizmos::gizmos(ui, rect, &self.state, actions);
            self.remark(ui, rect, actions);
        }
    }

    /// What the picture lacks, said on it.
    fn remark(&self, ui: &mut Ui, rect: egui::Rect, actions: &mut Vec<Action>) {
        let subject = self.state.subject();
        let is_whole = self.results.own.material.is_some() || subject.stack().is_some();
        if is_whole || self.desk.is_making_material() || !matches!(subject.structure(), Ok(Some(_))) {
            return;
        }
        let words = "Drawn as layers of its mean reflectance: of these sizes there is no material yet, so neither glints nor where its light goes are known.";
        let place = egui::Rect::from_min_max(rect.left_top() + egui::vec2(12.0, 12.0), rect.right_bottom());
        ui.scope_builder(egui::UiBuilder::new().max_rect(place), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_max_width((place.width() - 40.0).max(120.0));
                ui.label(words);
                ui.horizontal_wrapped(|ui| {
                    let coarse = ui
                        .button("Make a coarse one")
                        .on_hover_text("every 5th wavelength and direction (M)");
                    if coarse.clicked() {
                        actions.push(Action::MakeMaterial { whole: false });
                    }
                    let whole = ui
                        .button("Make the whole one")
                        .on_hover_text("in minutes; kept in the cache (Shift+M)");
                    if whole.clicked() {
                        actions.push(Action::MakeMaterial { whole: true });
                    }
                });
            });
        });
    }

    /// Windows in front of everything: help, names of files, what a drop would do.
    fn windows(&mut self, ctx: &Context) {
        help::help(ctx, &mut self.has_help);
        if let Some(asking) = &mut self.asking {
            match asking.show(ctx, &self.folder) {
                Answer::Waits => {}
                Answer::Leaves => self.asking = None,
                Answer::Writes => {
                    let (export, path) = (asking.export, asking.path(&self.folder));
                    self.asking = None;
                    let written = self.write(export, &path);
                    self.tell(written);
                }
            }
        }
        if ctx.input(|input| !input.raw.hovered_files.is_empty()) {
            egui::Area::new(egui::Id::unique("drop"))
                .order(egui::Order::Foreground)
                .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
                .show(ctx, |ui| {
                    Frame::popup(ui.style()).inner_margin(24.0).show(ui, |ui| {
                        ui.heading(
                            "Drop it to open it; a measured spectrum is drawn beside what is computed",
                        );
                    });
                });
        }
    }

    /// Asks for what has changed, and takes what was found.
    fn follow(&mut self) {
        let News { errors, show } = self.desk.follow(&self.state, self.effort, &mut self.results);
        for error in errors {
            self.tell(Err(error));
        }
        if let Ok(stage) = &self.stage {
            let put = show.map_or(Ok(()), |show| stage.put(&show));
            let drawn = stage.error().map_or(Ok(()), Err);
            self.tell(put.and(drawn));
        }
    }

    /// Takes the files that were dropped onto the window.
    fn take_files(&mut self, ctx: &Context) {
        let files = ctx.input(|input| input.raw.dropped_files.clone());
        for file in files {
            let taken = self.take(file.path());
            self.tell(taken);
        }
    }

    fn take(&mut self, path: &Path) -> Result<()> {
        let name = shortened(&path.display().to_string());
        match self.state.drop_file(path, &Unobserved)? {
            Dropped::Opened => self.say(format!("{name} is open")),
            Dropped::Measured => self.say(format!("{name} is drawn beside the spectrum")),
        }
        Ok(())
    }

    /// Does what somebody asked for.
    fn apply(&mut self, ctx: &Context, action: Action) -> Result<()> {
        match action {
            Action::Size { key, value } => self.state.move_size(&key, value),
            Action::ResetSizes => self.state.reset_sizes(),
            Action::Settle => {
                self.state.settle();
                Ok(())
            }
            Action::Look { what, change } => self.state.look(what, change),
            Action::Choose(mode) => self.state.choose(mode, &Unobserved),
            Action::Pin => {
                self.state.pin();
                Ok(())
            }
            Action::Unpin => {
                self.state.unpin();
                Ok(())
            }
            Action::Swap => self.state.swap(&Unobserved).map(|_| ()),
            Action::Undo => self.state.undo().map(|_| ()),
            Action::Redo => self.state.redo().map(|_| ()),
            Action::Open(text) => self.open(&text),
            Action::TakeAway(index) => {
                self.state.take_away(index);
                Ok(())
            }
            Action::Export(export) => {
                self.asking = Some(Asking::new(export, self.state.subject(), &self.folder));
                Ok(())
            }
            Action::CopyCommand => {
                let command = self.state.picture_command(self.size_px(), &Unobserved)?;
                self.copy(ctx, &command)
            }
            Action::MakeMaterial { whole } => self.desk.make_material(&self.state, whole),
            Action::Stop => {
                self.desk.stop();
                self.traced.pause();
                Ok(())
            }
        }
    }

    fn open(&mut self, text: &str) -> Result<()> {
        let path = Path::new(text);
        if path.is_file() && !barbule::open::is_built_in(text) {
            return self.take(path);
        }
        self.state.open_instead(text, &Unobserved)?;
        self.message = None;
        Ok(())
    }

    /// Esc: what is in front closes, else what is computed stops.
    fn leave(&mut self, actions: &mut Vec<Action>) {
        let was_open =
            self.finder.leave() | self.asking.take().is_some() | std::mem::take(&mut self.has_help);
        if !was_open && self.message.take().is_none() {
            actions.push(Action::Stop);
        }
    }

    /// Pixels of the picture.
    fn size_px(&self) -> [u32; 2] {
        let traced = self.traced.picture().map(|(size, _)| size);
        let own = Some(self.picture.size_px).filter(|size| size.iter().all(|side| *side > 0));
        let size = if self.state.view().mode == Mode::Scene { traced.or(own) } else { own };
        size.unwrap_or(USUAL_PX)
    }

    /// The picture as it is shown, in its own pixels.
    fn pixels(&self) -> Result<Pixels> {
        if self.state.view().mode == Mode::Scene {
            let (size, bytes) = self
                .traced
                .picture()
                .ok_or_else(|| Error::input("the picture has no sample yet; wait until it is drawn"))?;
            return Ok(Pixels { size, bytes: bytes.to_vec(), has_alpha: true });
        }
        let stage = self.stage.as_ref().map_err(|why| Error::input(why.as_str()))?;
        let size = self.size_px();
        let bytes = stage.pixels(size, &show::look(self.state.view()))?;
        Ok(Pixels { size, bytes, has_alpha: false })
    }

    fn write(&mut self, export: crate::state::Export, path: &Path) -> Result<()> {
        export.check(path)?;
        match export {
            crate::state::Export::Picture => export::write_picture(path, &self.state, &self.pixels()?)?,
            _ => export::write(path, export, &self.state, &self.results)?,
        }
        self.say(format!("{} is written", shortened(&path.display().to_string())));
        Ok(())
    }

    /// A command into the clipboard, and the files that it needs beside where it is run.
    fn copy(&mut self, ctx: &Context, command: &Command) -> Result<()> {
        export::write_needed(command, &self.folder)?;
        ctx.copy_text(command.line());
        let names: Vec<&str> = command.files.iter().map(|file| file.name.as_str()).collect();
        let beside = match &names[..] {
            [] => String::new(),
            names => format!("; it reads {}, written into the working folder", names.join(" and ")),
        };
        self.say(format!("{} is in the clipboard{beside}", shortened(&command.line())));
        Ok(())
    }

    fn say(&mut self, words: String) {
        self.message = Some(Message { words, is_wrong: false });
    }

    /// Says what went wrong, if something did.
    fn tell(&mut self, done: Result<()>) {
        if let Err(error) = done {
            self.message = Some(Message { words: error.to_string(), is_wrong: true });
        }
    }

    /// The title of the system's window.
    fn entitle(&mut self, ctx: &Context) {
        let title = format!("{} - Barbule", self.state.subject().title());
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.draw(ui);
    }

    fn on_exit(&mut self) {
        if let Some(saving) = &self.saving {
            saving.write(&self.state);
        }
    }
}

/// An error that a window leaves behind for the program to say, since it cannot any more.
pub type Farewell = Arc<Mutex<Option<Error>>>;

/// Takes what a window left behind.
#[must_use]
pub fn said(farewell: &Farewell) -> Option<Error> {
    farewell.lock().unwrap_or_else(PoisonError::into_inner).take()
}

#[cfg(test)]
mod tests;
