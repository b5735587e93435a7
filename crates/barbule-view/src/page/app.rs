//! The page: what is chosen, what was fetched and worked out, and how both are laid out on wide and on narrow screens.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use barbule_appearance::brdf::{BrdfTables, FeatherBrdf, Options, decode_material};
use barbule_base::Error;
use barbule_light::material::Library;
use barbule_light::spectrum::Wavelengths;
use barbule_light::spectrum::colour::Observer;
use eframe::egui;
use glam::DVec3;

use super::choice::{BIRDS, Choice, Solid, Worn, show};
use super::fetch::{Fetched, Surroundings};
use super::film::Film;
use super::grating::Ridges;
use super::picture::Picture;
use super::spectrum::Curve;
use super::view::{Extent, View};
use crate::Result;
use crate::gpu::Gpu;
use crate::scene::Shape;

/// From this width on, points, controls are beside the picture.
const WIDE: f32 = 720.0;
/// Width of the controls there.
const CONTROLS: f32 = 348.0;
/// Their share of a narrow screen's height.
const NARROW_SHARE: f32 = 0.48;

/// What the picture and the plots are of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Asked {
    pub(super) choice: Choice,
    pub(super) solid: Solid,
    pub(super) film: Film,
    pub(super) ridges: Ridges,
    /// Angle of incidence of the curve, across the barbule, rad.
    pub(super) angle: f64,
}

/// Where a material is.
#[derive(Debug, Clone)]
enum Material {
    Fetched,
    Here(Arc<FeatherBrdf>),
    Missing(String),
}

/// What is drawn beside the picture.
#[derive(Debug, Clone, Default)]
pub(super) struct Plots {
    pub(super) curve: Option<Curve>,
    pub(super) strip: Vec<[f64; 3]>,
    /// How long the last change of what is worn took, ms.
    pub(super) ms: f64,
}

/// The page.
pub struct Page {
    around: Box<dyn Surroundings>,
    pub(super) asked: Asked,
    /// What the stage shows.
    shown: Option<Asked>,
    pub(super) view: View,
    pub(super) plots: Plots,
    pub(super) picture: Picture,
    materials: BTreeMap<usize, Material>,
    shape: Option<(Solid, Shape)>,
    extent: Extent,
    library: Library,
    sender: Sender<Fetched>,
    receiver: Receiver<Fetched>,
    /// Why something is not shown.
    pub(super) fault: Option<String>,
    is_marked: bool,
    pub(super) help: String,
}

impl Page {
    /// On eframe's canvas.
    ///
    /// # Errors
    /// There is no adapter, or it refuses a shader.
    pub fn new(context: &eframe::CreationContext<'_>, around: Box<dyn Surroundings>) -> Result<Self> {
        let state = context
            .wgpu_render_state
            .as_ref()
            .ok_or_else(|| Error::machine("no graphics adapter was found; try another browser"))?;
        let info = state.adapter.get_info();
        let gpu = Gpu::of(state.device.clone(), state.queue.clone(), info);
        super::controls::dress(&context.egui_ctx);
        Self::on(gpu, state.target_format, around)
    }

    /// On an adapter, for targets of a format.
    ///
    /// # Errors
    /// The adapter refuses a shader.
    pub fn on(gpu: Gpu, format: wgpu::TextureFormat, around: Box<dyn Surroundings>) -> Result<Self> {
        let picture = Picture::new(gpu, format)?;
        around.mark("barbule-started");
        Ok(Self::of(picture, around))
    }

    fn of(picture: Picture, around: Box<dyn Surroundings>) -> Self {
        let (sender, receiver) = channel();
        let choice = Choice::Bird(0);
        let asked = Asked {
            choice,
            solid: Solid::Ball,
            film: Film::default(),
            ridges: Ridges::default(),
            angle: 0.0,
        };
        Self {
            help: around.help(),
            around,
            asked,
            shown: None,
            view: View { stops: choice.stops(), ..View::usual() },
            plots: Plots::default(),
            picture,
            materials: BTreeMap::new(),
            shape: None,
            extent: Extent { middle: DVec3::ZERO, radius: 1.0 },
            library: Library::builtin(),
            sender,
            receiver,
            fault: None,
            is_marked: false,
        }
    }

    /// Another material, on what it can be shown on.
    pub(super) fn choose(&mut self, choice: Choice) {
        self.asked.choice = choice;
        self.view.stops = choice.stops();
        if !choice.solids().contains(&self.asked.solid) {
            self.asked.solid = Solid::Ball;
        }
    }

    /// What is waited for.
    pub(super) fn waits_for(&self) -> Option<&'static str> {
        match self.asked.choice {
            Choice::Bird(number) if matches!(self.materials.get(&number), Some(Material::Fetched)) => {
                BIRDS.get(number).map(|bird| bird.label)
            }
            _ => None,
        }
    }

    /// Takes in what was fetched.
    fn receive(&mut self) {
        while let Ok((number, bytes)) = self.receiver.try_recv() {
            let made = bytes.and_then(|bytes| prepared(&bytes));
            let file = BIRDS.get(number).map_or("", |bird| bird.file);
            let material = match made {
                Ok(brdf) => Material::Here(Arc::new(brdf)),
                Err(error) => Material::Missing(error.at(file).to_string()),
            };
            self.materials.insert(number, material);
        }
    }

    /// Puts on the stage what is asked for, once it is there.
    fn keep_up(&mut self, context: &egui::Context) {
        let Some(worn) = self.worn(context) else { return };
        if self.shown == Some(self.asked) || self.is_sliding(context) {
            return;
        }
        let begun = self.around.now_ms();
        let result = worn.and_then(|worn| self.put(&worn));
        self.fault = result.err().map(|error| error.to_string());
        self.shown = Some(self.asked);
        self.plots.ms = self.around.now_ms() - begun;
        let Asked { choice, solid, .. } = self.asked;
        let ms = self.plots.ms;
        self.around.mark(&format!("barbule-shows {} on {}: {ms:.1} ms", choice.label(), solid.label()));
    }

    /// Whether a grating's sizes are being moved, which takes longer to work out than a frame: then it is done when the hand rests.
    fn is_sliding(&self, context: &egui::Context) -> bool {
        let is_same =
            self.shown.is_some_and(|shown| Asked { ridges: self.asked.ridges, ..shown } == self.asked);
        is_same && context.input(|input| input.pointer.any_down())
    }

    /// What is worn, where it is known already; materials that are not are fetched.
    fn worn(&mut self, context: &egui::Context) -> Option<Result<Option<Worn>>> {
        let Choice::Bird(number) = self.asked.choice else { return Some(Ok(None)) };
        match self.materials.get(&number) {
            Some(Material::Here(brdf)) => Some(Ok(Some(Worn::Bird(Arc::clone(brdf))))),
            Some(Material::Missing(why)) => Some(Err(Error::machine(why.clone()))),
            Some(Material::Fetched) => None,
            None => {
                let bird = BIRDS.get(number)?;
                self.materials.insert(number, Material::Fetched);
                self.around.fetch(bird.file, number, self.sender.clone(), context.clone());
                None
            }
        }
    }

    /// Works out what is asked for, and hands it to the picture.
    fn put(&mut self, bird: &Option<Worn>) -> Result<()> {
        let asked = self.asked;
        let worn = match (asked.choice, bird) {
            (Choice::Bird(_), Some(Worn::Bird(brdf))) => {
                let curve = reflected(brdf, asked.angle)?;
                if self.shown.is_none_or(|shown| shown.choice != asked.choice) {
                    self.view.stops = stops_of(curve.rgb);
                }
                self.plots.curve = Some(curve);
                self.plots.strip.clear();
                Worn::Bird(Arc::clone(brdf))
            }
            (Choice::Ridges, _) => {
                self.plots.curve = Some(first_orders(&asked.ridges));
                self.plots.strip.clear();
                Worn::Ridges(Arc::new(asked.ridges.surface()?))
            }
            _ => {
                let looked = asked.film.look(&self.library, asked.angle)?;
                (self.plots.curve, self.plots.strip) = (Some(looked.curve), looked.strip);
                Worn::Film(Arc::new(looked.reflected))
            }
        };
        // The curve's angle changes nothing of the picture.
        let is_same = self.shown.is_some_and(|shown| Asked { angle: asked.angle, ..shown } == asked);
        if is_same && self.fault.is_none() {
            return Ok(());
        }
        if self.shape.as_ref().is_none_or(|(solid, _)| *solid != asked.solid) {
            let shape = asked.solid.shape()?;
            self.extent = Extent::of(&shape);
            self.view.zoom = 1.0;
            self.shape = Some((asked.solid, shape));
        }
        match &self.shape {
            Some((_, shape)) => self.picture.put(&show(shape, &worn)?),
            None => Ok(()),
        }
    }

    /// All of the page.
    pub fn draw(&mut self, ui: &mut egui::Ui) {
        self.receive();
        let context = ui.ctx().clone();
        self.keep_up(&context);
        let space = ui.available_size();
        let frame = egui::Frame::central_panel(ui.style());
        if space.x >= WIDE {
            let panel = egui::Panel::right("controls").resizable(false).exact_size(CONTROLS);
            panel.frame(frame.inner_margin(16.0)).show(ui, |ui| self.scrolled(ui));
        } else {
            let panel = egui::Panel::bottom("controls").resizable(false);
            let panel = panel.exact_size((NARROW_SHARE * space.y).max(150.0));
            panel.frame(frame.inner_margin(12.0)).show(ui, |ui| self.scrolled(ui));
        }
        let behind = egui::Frame::new().fill(egui::Color32::from_gray(20));
        egui::CentralPanel::default().frame(behind).show(ui, |ui| self.pictured(ui));
        if let Some(fault) = self.picture.fault() {
            self.fault = Some(fault);
        }
        if !self.is_marked && self.picture.frames() > 0 {
            self.is_marked = true;
            self.around.mark("barbule-first-picture");
        }
    }

    fn scrolled(&mut self, ui: &mut egui::Ui) {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.controls(ui));
    }

    fn pictured(&mut self, ui: &mut egui::Ui) {
        let (view, extent) = (self.view, self.extent);
        self.view = self.picture.widget(ui, view, extent);
        let waits = self.waits_for().map(|what| format!("fetching {what} …"));
        let text = self.fault.clone().or(waits);
        if let Some(text) = text {
            self.picture.caption(ui, &text);
        }
    }
}

impl eframe::App for Page {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.draw(ui);
    }
}

/// A material from its file, ready.
fn prepared(bytes: &[u8]) -> Result<FeatherBrdf> {
    let material = decode_material(bytes)?;
    Ok(FeatherBrdf::from_tables(BrdfTables::new(&material, Options::default())?))
}

/// What a barbule reflects in all, in the mean over individuals, of light at an angle across it (rad).
fn reflected(brdf: &FeatherBrdf, angle: f64) -> Result<Curve> {
    let at = Wavelengths::new((0..=100).map(|k| 300.0 + 4.0 * f64::from(k)).collect::<Vec<_>>())?;
    let wi = DVec3::new(angle.sin(), 0.0, angle.cos());
    let values: Vec<f64> = at.nm().iter().map(|nm| brdf.exact(*nm, wi).reflected()).collect();
    let rgb = Observer::default().weights(&at).linear_rgb(&values);
    Ok(Curve { nm: at.nm().to_vec(), values, rgb })
}

/// Stops of exposure for a barbule that reflects this colour: bright ones get less, but stay brighter than dark ones.
fn stops_of(rgb: [f64; 3]) -> f64 {
    let most = rgb.into_iter().fold(1e-3, f64::max);
    (1.3 - 0.7 * (most / 0.065).log2()).clamp(-1.5, 2.5)
}

/// Where the first order of each wavelength leaves, in degrees from the mirror direction of light from straight above.
fn first_orders(ridges: &Ridges) -> Curve {
    let all = (0..=100).map(|k| 300.0 + 5.0 * f64::from(k));
    let of = |nm: f64| Some((nm, ridges.first_order(1e-3 * nm)?.to_degrees()));
    let (nm, values) = all.filter_map(of).unzip();
    Curve { nm, values, rgb: [0.0; 3] }
}
