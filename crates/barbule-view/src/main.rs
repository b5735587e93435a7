//! The `barbule-view` program: a window, or without one a picture or times of frames.

#![allow(clippy::print_stdout, clippy::print_stderr)] // a program

use std::path::PathBuf;
use std::process::ExitCode;

use barbule::io::Ledger;
use barbule::{Error, Result, Unobserved};
use barbule_view::arguments::{Arguments, Given, read};
use barbule_view::gpu::Gpu;
use barbule_view::headless;
use barbule_view::live::Effort;
use barbule_view::ui::{
    Adapter, App, Farewell, Saving, Start, look, lost, restored, said, usual_file, usual_folder,
};
use eframe::{egui, egui_wgpu};

/// The window's size at first and at least, points.
const SIZE: [f32; 2] = [1280.0, 800.0];
const LEAST_SIZE: [f32; 2] = [640.0, 420.0];

fn main() -> ExitCode {
    // What is read is never written over.
    let _ledger = Ledger::open();
    let done = match read(std::env::args_os()) {
        Ok(Given::Words(words)) => {
            println!("{}", words.trim_end());
            Ok(())
        }
        Ok(Given::Arguments(arguments)) => run(&arguments),
        Err(error) => Err(error),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("barbule-view: {error}");
            ExitCode::from(if error.is_input() { 2 } else { 1 })
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let caches = [("XDG_CACHE_HOME", ""), ("LOCALAPPDATA", ""), ("HOME", ".cache")];
    let opening = arguments.opening(usual_folder(&caches, variable));
    if arguments.is_headless() {
        let request = arguments.request(arguments.state(None, &opening, &Unobserved)?);
        if request.file.is_some() {
            headless::screenshot(&request)?;
        }
        if arguments.bench {
            println!("{}", headless::bench(&request)?);
        }
        return Ok(());
    }
    let file = arguments.state.clone().or_else(|| usual_file(variable));
    let farewell = Farewell::default();
    let saving = file.map(|file| Saving { file, farewell: farewell.clone() });
    let mut words = None;
    // What is named is looked at as it looks best; what was kept is left alone until the window closes.
    let kept = saving.as_ref().filter(|_| arguments.open.is_none()).and_then(|saving| {
        restored(&saving.file, &opening, &Unobserved).unwrap_or_else(|error| {
            words = Some(lost(&error));
            None
        })
    });
    if let Some(words) = &words {
        eprintln!("barbule-view: {words}");
    }
    let state = arguments.state(kept, &opening, &Unobserved)?;
    let start = Start { state, folder: PathBuf::new(), saving, words, effort: Effort::default() };
    window(arguments, start)?;
    said(&farewell).map_or(Ok(()), Err)
}

/// A variable of the environment that is a path.
fn variable(name: &str) -> Option<PathBuf> {
    std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// Opens the window, until it closes.
fn window(arguments: &Arguments, start: Start) -> Result<()> {
    let size = arguments.size.map_or(SIZE, |size| size.map(|side| side as f32));
    let viewport = egui::ViewportBuilder::default()
        .with_title("Barbule")
        .with_app_id("barbule-view")
        .with_icon(look::icon())
        .with_inner_size(size)
        .with_min_inner_size(LEAST_SIZE);
    let options =
        eframe::NativeOptions { viewport, persist_window: false, ..eframe::NativeOptions::default() };
    let create = move |context: &eframe::CreationContext<'_>| {
        let adapter = context.wgpu_render_state.as_ref().map(adapter);
        let app = App::new(&context.egui_ctx, adapter, start)?;
        Ok(Box::new(app) as Box<dyn eframe::App>)
    };
    eframe::run_native("barbule-view", options, Box::new(create)).map_err(|error| match error {
        eframe::Error::AppCreation(error) => Error::machine(error.to_string()),
        error => Error::input(format!(
            "no window can be opened ({}); --screenshot FILE draws a picture without one",
            reason(&error.to_string())
        )),
    })
}

/// Why there is no window, without the place in a library's source that stands before it.
fn reason(words: &str) -> &str {
    words.rsplit(": ").next().unwrap_or(words).trim_end_matches(['.', '\n'])
}

fn adapter(state: &egui_wgpu::RenderState) -> Adapter {
    let gpu = Gpu::of(state.device.clone(), state.queue.clone(), state.adapter.get_info());
    Adapter { gpu, format: state.target_format }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_name_no_source() {
        let words = "os error at /src/x11.rs:27: neither WAYLAND_DISPLAY nor DISPLAY is set.";
        assert_eq!(reason(words), "neither WAYLAND_DISPLAY nor DISPLAY is set");
        assert_eq!(reason("no adapter"), "no adapter");
    }
}
