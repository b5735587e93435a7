//! The page's start: the canvas, what a browser is asked for, and one sentence where nothing can be drawn.

use std::sync::mpsc::Sender;

use barbule_base::Error;
use eframe::egui;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsCast as _, JsValue};
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{Document, HtmlCanvasElement, Performance, Response, Window};

use super::app::Page;
use super::fetch::{Fetched, Surroundings};
use crate::Result;

/// The canvas, where sentences are shown instead, and the link to the documentation: by their ids.
const CANVAS: &str = "picture";
const SENTENCE: &str = "sentence";
const HELP: &str = "help";
/// In the address: WebGL 2 even where there is WebGPU, to see how the page looks there.
const PLAIN: &str = "webgl2";
/// The largest file that is fetched, bytes: a material has 0.5 MB.
const LARGEST: usize = 64 << 20;

/// A browser's window.
struct Browser {
    window: Window,
    performance: Option<Performance>,
    document: Document,
}

impl Surroundings for Browser {
    fn fetch(&self, file: &str, number: usize, to: Sender<Fetched>, repaint: egui::Context) {
        let (window, file) = (self.window.clone(), file.to_owned());
        spawn_local(async move {
            let bytes = fetched(&window, &file).await;
            // Nobody listens any more only where the page is gone.
            drop(to.send((number, bytes)));
            repaint.request_repaint();
        });
    }

    fn now_ms(&self) -> f64 {
        self.performance.as_ref().map_or(0.0, Performance::now)
    }

    fn mark(&self, what: &str) {
        if let Some(performance) = &self.performance {
            // A mark that cannot be made is missed by nobody who looks at the page.
            drop(performance.mark(what));
        }
    }

    fn help(&self) -> String {
        let link = self.document.get_element_by_id(HELP);
        link.and_then(|link| link.get_attribute("href")).unwrap_or_default()
    }
}

/// The bytes of a file beside the page.
async fn fetched(window: &Window, file: &str) -> Result<Vec<u8>> {
    let refuse =
        |what: String| Error::machine(format!("{file} cannot be fetched: {what}; load the page again"));
    let words = |error: JsValue| refuse(text_of(&error));
    let response: Response =
        JsFuture::from(window.fetch_with_str(file)).await.map_err(words)?.dyn_into().map_err(words)?;
    if !response.ok() {
        return Err(refuse(format!("the server answers {}", response.status())));
    }
    let buffer = JsFuture::from(response.array_buffer().map_err(words)?).await.map_err(words)?;
    let bytes = js_sys::Uint8Array::new(&buffer);
    if bytes.length() as usize > LARGEST {
        return Err(refuse(format!("it has {} bytes, over {LARGEST}", bytes.length())));
    }
    Ok(bytes.to_vec())
}

/// What a browser says of an error.
fn text_of(error: &JsValue) -> String {
    error.dyn_ref::<js_sys::Error>().map_or_else(|| format!("{error:?}"), |error| error.message().into())
}

/// Shows a sentence instead of the picture.
fn say(document: &Document, sentence: &str) {
    if let Some(place) = document.get_element_by_id(SENTENCE) {
        place.set_text_content(Some(sentence));
        place.remove_attribute("hidden").unwrap_or_default();
    }
}

/// Starts the page; browsers call it when the program is loaded.
#[wasm_bindgen(start)]
pub fn start() {
    let Some(window) = web_sys::window() else { return };
    let Some(document) = window.document() else { return };
    let canvas = document.get_element_by_id(CANVAS).and_then(|canvas| canvas.dyn_into().ok());
    let Some(canvas): Option<HtmlCanvasElement> = canvas else {
        say(&document, "The page has no canvas to draw on; load it again.");
        return;
    };
    let is_plain = window.location().search().is_ok_and(|query| query.contains(PLAIN));
    let browser = Browser { performance: window.performance(), window, document: document.clone() };
    spawn_local(async move {
        let made: eframe::AppCreator<'static> = Box::new(|context| {
            Page::new(context, Box::new(browser))
                .map(|page| Box::new(page) as Box<dyn eframe::App>)
                .map_err(|error| error.to_string().into())
        });
        if let Err(error) = eframe::WebRunner::new().start(canvas, options(is_plain), made).await {
            web_sys::console::error_1(&error);
            say(
                &document,
                "This browser offers neither WebGPU nor WebGL 2, with one of which barbules are drawn; try a current Chrome, Edge, Firefox or Safari, with hardware acceleration on.",
            );
        }
    });
}

/// Textures as large as the adapter has them, nothing else beyond what WebGL 2 has.
fn options(is_plain: bool) -> eframe::WebOptions {
    let mut options = eframe::WebOptions::default();
    if let eframe::egui_wgpu::WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        if is_plain {
            setup.instance_descriptor.backends = wgpu::Backends::GL;
        }
        setup.device_descriptor = std::sync::Arc::new(|adapter| wgpu::DeviceDescriptor {
            label: Some("barbule"),
            required_limits: wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        });
    }
    options
}
