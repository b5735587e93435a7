//! What is computed beside the window: films exactly, single individuals at once, means over individuals better and better, and
//! materials when somebody asks for them.
//!
//! [`run`] does one [`Job`] and tells what it finds as it goes; a [`Worker`] does that on a thread of its own, the newest job first
//! and alone. Results are plain numbers in arrays. The window's desk asks for what has changed, and keeps what was found as [`Results`].

mod bench;
mod benches;
mod compared;
mod curves;
mod desk;
mod film;
mod hemisphere;
mod individual;
mod material;
mod mean;
mod media;
mod raster;
mod results;
mod show;
mod sight;
mod strips;
pub mod trace;
mod window;
mod worker;

use barbule::Result;
use barbule::progress::Progress;

use crate::stage::Show;

pub use compared::{Compared, Told};
pub use curves::Curves;
pub use desk::Effort;
pub(crate) use desk::{Busy, Desk, News};
pub use film::{FilmJob, film};
pub use hemisphere::{
    Hemisphere, HemisphereJob, direction_at, hemisphere, lit_across, lobe_spectrum, place_of, radius_of,
};
pub use individual::{Individual, IndividualJob, Lobe, individual};
pub use material::{MaterialFound, MaterialJob, expected_seconds, material};
pub use mean::{MeanFound, MeanJob, mean, stages};
pub use media::{Entry, Hatch, Legend};
pub use raster::{Raster, raster};
pub use results::{Known, Results};
pub use show::{ShowJob, show};
pub use sight::{Sight, Viewer};
pub use strips::{AngleSeen, along_angles, reaches, spectral_srgb};
pub use window::{Window, extent, first_window, near_window};
pub use worker::{Update, Worker};

/// Something to compute.
#[derive(Debug, Clone)]
pub enum Job {
    /// Reflectance of flat layers.
    Film(FilmJob),
    /// One individual: its section, its colour along the normal, what it scatters.
    Individual(Box<IndividualJob>),
    /// A material's lobe.
    Hemisphere(Box<HemisphereJob>),
    /// The mean over individuals.
    Mean(Box<MeanJob>),
    /// The material.
    Material(Box<MaterialJob>),
    /// What the picture shows.
    Show(Box<ShowJob>),
}

/// Something that was computed.
#[derive(Debug, Clone)]
pub enum Found {
    /// Of a film; all there is.
    Film(Curves),
    /// An individual, first without and then with what it scatters.
    Individual(Box<Individual>),
    /// A material's lobe; all there is.
    Hemisphere(Hemisphere),
    /// A mean, over more individuals and wavelengths each time.
    Mean(MeanFound),
    /// A material, a coarse one and then perhaps the whole one.
    Material(MaterialFound),
    /// What the picture shows, as far as it is known.
    Show(Box<Show>),
}

/// Does a job, and hands over what is found as soon as it is.
///
/// # Errors
/// As the job's own function, or a stop by `progress`.
pub fn run(job: &Job, progress: &dyn Progress, found: &mut dyn FnMut(Found)) -> Result<()> {
    match job {
        Job::Film(job) => film(job, progress).map(|curves| found(Found::Film(curves))),
        Job::Individual(job) => individual(job, progress, &mut |one| found(Found::Individual(Box::new(one)))),
        Job::Hemisphere(job) => hemisphere(job, progress).map(|lobe| found(Found::Hemisphere(lobe))),
        Job::Mean(job) => mean(job, progress, &mut |mean| found(Found::Mean(mean))),
        Job::Material(job) => material(job, progress, &mut |made| found(Found::Material(made))),
        Job::Show(job) => show(job, progress, &mut |made| found(Found::Show(Box::new(made)))),
    }
}
