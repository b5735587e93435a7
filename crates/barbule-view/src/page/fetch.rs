//! What the page asks of its browser: files beside it, the time, and marks for whoever measures.

use std::sync::mpsc::Sender;

use crate::Result;

/// A file that was asked for: the number it was asked under, and its bytes or why there are none.
pub type Fetched = (usize, Result<Vec<u8>>);

/// Where the page is.
pub trait Surroundings {
    /// Fetches a file beside the page, and sends it under a number when it is there.
    fn fetch(&self, file: &str, number: usize, to: Sender<Fetched>, repaint: eframe::egui::Context);
    /// Time since some moment, ms.
    fn now_ms(&self) -> f64;
    /// Notes that something is there for the first time.
    fn mark(&self, what: &str);
    /// The page of the documentation.
    fn help(&self) -> String;
}
