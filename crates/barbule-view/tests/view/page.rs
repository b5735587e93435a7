//! The browser's page without a browser: what it fetches, works out and says.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::mpsc::Sender;

use barbule_view::gpu::Gpu;
use barbule_view::page::{Fetched, Page, Surroundings};
use eframe::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

/// What was asked for and marked.
type Log = Rc<RefCell<Vec<String>>>;

/// Files from this program.
struct Desk {
    log: Log,
    is_damaged: bool,
}

impl Surroundings for Desk {
    fn fetch(&self, file: &str, number: usize, to: Sender<Fetched>, repaint: egui::Context) {
        self.log.borrow_mut().push(file.to_owned());
        let name = file.strip_suffix(".barbule").unwrap();
        let mut bytes = barbule_birds::material(name).unwrap().to_vec();
        if self.is_damaged {
            bytes.truncate(1000);
        }
        to.send((number, Ok(bytes))).unwrap();
        repaint.request_repaint();
    }

    fn now_ms(&self) -> f64 {
        0.0
    }

    fn mark(&self, what: &str) {
        self.log.borrow_mut().push(what.to_owned());
    }

    fn help(&self) -> String {
        "viewer-web.html".to_owned()
    }
}

/// A page of this size and its log; nothing where there is no adapter.
fn opened(size: egui::Vec2, is_damaged: bool) -> Option<(Harness<'static>, Log)> {
    let gpu = match Gpu::new(None) {
        Ok(gpu) => gpu,
        Err(error) => {
            println!("skipped: {error}");
            return None;
        }
    };
    let log = Log::default();
    let desk = Desk { log: Rc::clone(&log), is_damaged };
    let mut page = Page::on(gpu, wgpu::TextureFormat::Rgba8Unorm, Box::new(desk)).unwrap();
    let mut harness = Harness::builder().with_size(size).build_ui(move |ui| page.draw(ui));
    harness.run_steps(4);
    Some((harness, log))
}

#[test]
fn the_page_opens_with_a_starling_and_fetches_nothing_else() {
    let Some((mut harness, log)) = opened(egui::vec2(1000.0, 900.0), false) else { return };
    assert_eq!(
        log.borrow()[..],
        ["barbule-started", "starling-green.barbule", "barbule-shows Starling on Ball: 0.0 ms"]
    );
    harness.get_by_label("Magpie").click();
    harness.run_steps(4);
    assert_eq!(log.borrow()[3..], ["magpie-violet.barbule", "barbule-shows Magpie on Ball: 0.0 ms"]);
    harness.get_by_label("Starling").click();
    harness.run_steps(3);
    assert_eq!(log.borrow()[5..], ["barbule-shows Starling on Ball: 0.0 ms"]);
}

/// Films and gratings need no file; sizes are what their sliders say, on narrow screens too.
#[test]
fn films_and_gratings_follow_their_sliders() {
    for size in [egui::vec2(1000.0, 900.0), egui::vec2(390.0, 2400.0)] {
        let Some((mut harness, log)) = opened(size, false) else { return };
        harness.get_by_label("Thin film").click();
        harness.run_steps(3);
        harness.get_by_label("thickness: 330 nm");
        harness.get_by_label("In a terminal: barbule film 'air/keratin:330/melanin'");
        harness.get_by_label("Soap film").click();
        harness.run_steps(3);
        harness.get_by_label("thickness: 420 nm");
        harness.get_by_label("Grating").click();
        harness.run_steps(3);
        harness.get_by_label("from ridge to ridge: 1.60 µm");
        harness.get_by_label("Snake").click();
        harness.run_steps(3);
        assert_eq!(log.borrow().last().unwrap(), "barbule-shows Grating on Snake: 0.0 ms");
    }
}

/// A file that is none is not asked for again, and whatever else can be shown is.
#[test]
fn damaged_files_leave_the_rest_alone() {
    let Some((mut harness, log)) = opened(egui::vec2(1000.0, 900.0), true) else { return };
    harness.get_by_label("Thin film").click();
    harness.run_steps(3);
    harness.get_by_label("Starling").click();
    harness.run_steps(3);
    let asked = log.borrow().iter().filter(|line| line.ends_with(".barbule")).count();
    assert_eq!((asked, log.borrow().len()), (1, 5));
}
