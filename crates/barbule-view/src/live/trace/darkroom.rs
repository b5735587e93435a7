//! The thread that develops films, as `barbule render` does, and takes their noise away.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, PoisonError};

use barbule::picture::{Cleaner, development};
use barbule::render::film::Film;
use barbule::render::picture::{Bytes, bytes};
use barbule::scene::description::{Exposure, KeyLight, LightDescription};
use barbule::{Error, Result};

use super::{Desk, Negative, TracedPicture};

/// What is kept from film to film.
#[derive(Default)]
struct Darkroom {
    found: Option<Found>,
    /// The denoiser, once somebody asked for one: it, or why there is none.
    cleaner: Option<std::result::Result<Cleaner, String>>,
}

/// An exposure that was found by what a picture shows, and the lamps and set that it showed.
struct Found {
    exposure: f64,
    set: u64,
    lamps: (KeyLight, Vec<LightDescription>),
}

/// The life of the thread: waits for a film and develops it.
pub(super) fn life(desk: &Desk) {
    let mut room = Darkroom::default();
    while let Some(negative) = taken(desk) {
        let number = negative.number;
        let done = catch_unwind(AssertUnwindSafe(|| room.picture(&negative, &|note| desk.note(note))));
        let mut state = desk.state();
        state.is_developing = false;
        match done {
            Ok(Ok(picture)) => {
                if number >= state.oldest_shown {
                    state.told.picture = Some(Arc::new(picture));
                }
                if negative.is_last {
                    state.told.done = Some(number);
                }
                drop(state);
                (desk.wake)();
            }
            Ok(Err(error)) => {
                drop(state);
                desk.fail(number, error);
            }
            Err(_) => {
                drop(state);
                room = Darkroom::default();
                desk.fail(
                    number,
                    Error::machine("developing the picture ended unexpectedly; move something to try again"),
                );
            }
        }
    }
}

/// The film that waits, once there is one; none once the desk is closed.
fn taken(desk: &Desk) -> Option<Negative> {
    let mut state = desk.state();
    loop {
        if state.is_closed {
            return None;
        }
        let oldest_shown = state.oldest_shown;
        if let Some(negative) = state.negative.take() {
            if negative.number >= oldest_shown {
                state.is_developing = true;
                return Some(negative);
            }
            continue;
        }
        state = desk.developing.wait(state).unwrap_or_else(PoisonError::into_inner);
    }
}

impl Darkroom {
    /// A film as a picture; `note` hears why noise stays that was to be taken away.
    ///
    /// # Errors
    /// As [`development`].
    fn picture(&mut self, negative: &Negative, note: &dyn Fn(String)) -> Result<TracedPicture> {
        let film = &*negative.film;
        let mut development = match self.held(negative) {
            Some(exposure) => {
                let scene = negative.scene.changed(|scene| scene.exposure = Exposure::Factor(exposure))?;
                development(&scene, film)?
            }
            None => development(&negative.scene, film)?,
        };
        if negative.scene.exposure.factor().is_none() && !negative.holds_exposure {
            let lamps = (negative.scene.light, negative.scene.lights.clone());
            self.found = Some(Found { exposure: development.exposure, set: negative.set, lamps });
        }
        let mut denoised_by = None;
        if negative.cleans {
            match self.cleaned(film) {
                Ok((pixels, name)) => {
                    development.denoised = Some(pixels);
                    denoised_by = Some(name);
                }
                Err(sentence) => note(sentence),
            }
        }
        let pixels = f64::from(film.size()[0]) * f64::from(film.size()[1]);
        Ok(TracedPicture {
            size: film.size(),
            rgba: rgba(bytes(film, &development)),
            samples: film.samples() as f64 / pixels,
            of: negative.of,
            noise: film.noise(),
            seconds: negative.seconds,
            exposure: development.exposure,
            is_small: negative.is_small,
            denoised_by,
            thinned: negative.thinned,
            camera: negative.scene.camera(),
            depth_mm: depths(film),
        })
    }

    /// The exposure that holds, where the one that was found last does: a picture does not flicker while a camera moves.
    fn held(&self, negative: &Negative) -> Option<f64> {
        let (found, scene) = (self.found.as_ref()?, &negative.scene);
        let is_alike =
            found.set == negative.set && found.lamps.0 == scene.light && found.lamps.1 == scene.lights;
        (negative.holds_exposure && scene.exposure.factor().is_none() && is_alike).then_some(found.exposure)
    }

    /// A film without noise, and by what; or why not, in a sentence.
    fn cleaned(&mut self, film: &Film) -> std::result::Result<Cleaned, String> {
        let load = || Cleaner::load(None).map_err(|error| error.to_string());
        let cleaner = self.cleaner.get_or_insert_with(load).as_ref().map_err(Clone::clone)?;
        let pixels = cleaner.clean(film).map_err(|error| error.to_string())?;
        Ok((pixels, cleaner.name()))
    }
}

/// CIE XYZ of each pixel without its noise, and the name of what took that away.
type Cleaned = (Arc<[[f32; 3]]>, String);

/// Pixels with alpha, whether they had any or not.
fn rgba(bytes: Bytes) -> Vec<u8> {
    if bytes.has_alpha {
        return bytes.values;
    }
    bytes.values.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], u8::MAX]).collect()
}

/// How far the first hits of pixels are, mm; 0 where more than half of their samples hit nothing.
fn depths(film: &Film) -> Vec<f32> {
    let [width, height] = film.size();
    let depth = |(x, y): (u32, u32)| {
        let (pixel, count) = (film.pixel(x, y), film.count(x, y));
        if pixel.hits == 0 || 2 * pixel.hits < count {
            0.0
        } else {
            (pixel.depth / f64::from(pixel.hits)) as f32
        }
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(depth).collect()
}
